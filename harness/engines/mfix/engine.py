"""MFiX-DEM as an engine of the harness. A user builds it; it was not run by this engine yet.

What is proven of MFiX-DEM here are recorded runs of 21.3.2 (``recorded.py``): its contact,
its scheme, its step. How this engine states a run (``system.py``, ``scripts.py``) and reads it
(``vtp.py``, ``read.py``) follows the source of 21.3.2 and is tested against a stand-in that
keeps to what is read there. The first live run is judged by qualification.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from harness.cases.drop.parameters import Drop
from harness.cases.drop.result import DropRun
from harness.cases.incline.judge import run_of_path
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun, Motion
from harness.cases.incline.routes import start_of
from harness.cases.tower.timing import Plan, plan
from harness.engines.contract import Engine, Route
from harness.engines.input_values import check_equal_particles, check_overlap_law
from harness.engines.mfix.declared import OBTAIN, TRAITS
from harness.engines.mfix.read import check_end, read_path, read_tower
from harness.engines.mfix.solver import Solver, version_of
from harness.engines.mfix.system import System, drop_system, incline_system, tower_system
from harness.engines.parallel import cores, parallel_map
from harness.engines.process import Limits
from harness.engines.programs import find_program
from harness.errors import EngineError, EngineMissingError, EngineOutputError, RequestError
from harness.observables.provenance import Provenance
from harness.observables.tower import TowerRun
from harness.parameters.contact import Contact
from harness.parameters.tower import Tower

WATCH = 50
"""Steps between two looks at the grain, as in LAMMPS's script."""

MOST_FRAMES = 100_000
"""Files that a run writes at most: MFiX writes one a sample."""

STRETCHES = (8.0, 32.0, 128.0)
"""[sqrt(d/g)] that an incline is run for before its whole time limit: MFiX cannot stop early."""


class Mfix(Engine):
    """The batch solver of MFiX at ``program``, a path or a name on PATH.

    ``workers`` processes run side by side, as many as there are cores unless told
    otherwise. Not run here: see the module. Raise EngineMissingError without a program or
    with one that is no MFiX, RequestError where there is no such file.
    """

    name = "mfix"
    traits = TRAITS

    def __init__(
        self,
        program: str | None = None,
        workers: int | None = None,
        limits: Limits | None = None,
    ) -> None:
        if program is None:
            raise EngineMissingError(f"MFiX was not found: {OBTAIN}")
        self._program = find_program(self.name, program)
        self._version = version_of(self._program)
        self._workers = workers or cores()
        self._solver = Solver(self._program, limits or Limits())

    def identify(self) -> Provenance:
        """Return the version that the solver names, and its path."""
        return Provenance(
            engine=self.name,
            engine_version=self._version,
            executable=self._program,
            how="executable",
            script="mfix.dat",
            integrator="mfix-euler",
        )

    def drops(self, cases: Sequence[Drop]) -> list[DropRun | EngineError]:
        """Run the grain against one held sphere, a process for each case."""
        systems = [_stated(case.contact, drop_system(case)) for case in cases]
        who = self.identify()

        def one(index: int) -> DropRun | EngineError:
            output = self._solver.run(systems[index])
            if isinstance(output, EngineError):
                return output
            try:
                path = read_path(systems[index], output.frames)
                check_end(systems[index], output.frames)
            except EngineError as error:
                error.log = output.log
                return error
            return DropRun(cases[index], path, output.seconds, who)

        return parallel_map(one, range(len(cases)), self._workers)

    def inclines(
        self, cases: Sequence[Incline], route: Route, *, every: int | None = None
    ) -> list[InclineRun | EngineError]:
        """Run the cases on a row that is long enough, in longer stretches until they are decided.

        ``case.spheres`` has no effect: the row is not periodic.
        """
        for case in cases:
            _incline(case, route, STRETCHES[0], every)
        return parallel_map(lambda case: self._incline(case, route, every), cases, self._workers)

    def towers(
        self,
        cases: Sequence[Tower],
        duration: float,
        *,
        steps_per_contact: float | None = None,
        samples: int | None = None,
        profiles: bool = False,
    ) -> list[TowerRun | EngineError]:
        """Run towers of equal particles under the overlap law, a process for each."""
        plans = [plan(case, duration, steps_per_contact, samples) for case in cases]
        systems = [_tower(case, timing) for case, timing in zip(cases, plans, strict=True)]
        who = self.identify()

        def one(index: int) -> TowerRun | EngineError:
            case, system = cases[index], systems[index]
            output = self._solver.run(system)
            if isinstance(output, EngineError):
                return output
            try:
                return read_tower(case, system, output.frames, output.forces, who, profiles)
            except EngineError as error:
                error.log = output.log
                return error

        return parallel_map(one, range(len(cases)), self._workers)

    def close(self) -> None:
        """End MFiX's processes and remove what they left."""
        self._solver.close()

    def _incline(self, case: Incline, route: Route, every: int | None) -> InclineRun | EngineError:
        """Run one case until it is decided, or its time limit."""
        seconds = 0.0
        for stretch in sorted({*(min(s, case.time_limit) for s in STRETCHES), case.time_limit}):
            try:
                system = _incline(case, route, stretch, every)
            except RequestError as error:
                return EngineOutputError(f"MFiX: undecided after {seconds:.3g} s; {error}")
            output = self._solver.run(system)
            if isinstance(output, EngineError):
                return output
            seconds += output.seconds
            try:
                run = run_of_path(
                    case.replace(time_limit=stretch),
                    route,
                    read_path(system, output.frames),
                    self.identify(),
                    seconds=seconds,
                    keep=every is not None,
                )
            except EngineError as error:
                error.log = output.log
                return error
            if run.motion is not Motion.UNDECIDED:
                break
        return replace(run, case=case)


def _incline(case: Incline, route: Route, stretch: float, every: int | None) -> System:
    """Return the system of a case over a stretch [sqrt(d/g)]."""
    duration = stretch * math.sqrt(case.diameter / case.gravity)
    looked = every or max(WATCH, math.ceil(duration / case.step / MOST_FRAMES))
    wells = 1 if route == "passage" else case.wells
    system = incline_system(case, start_of(case, route), wells, duration, looked)
    return _stated(case.contact, system)


def _tower(case: Tower, timing: Plan) -> System:
    check_equal_particles(case, "MFiX")
    check_overlap_law(case, "MFiX")
    system = tower_system(case, timing.step, timing.steps, timing.every)
    return _stated(system.contact, system)


def _stated(contact: Contact, system: System) -> System:
    """Return a system that MFiX can be told; raise RequestError for one that it cannot."""
    refused = TRAITS.refuses(contact)
    if refused:
        raise RequestError(f"contact = {contact.name!r} cannot be stated to MFiX: {refused}")
    frames = system.steps // system.every
    if frames > MOST_FRAMES:
        raise RequestError(
            f"every = {system.every} steps: MFiX writes a file each, {frames} of them; "
            f"must be at most {MOST_FRAMES}"
        )
    assert system.factor > 0.0
    return system
