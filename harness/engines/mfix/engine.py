"""MFiX-DEM as an engine of the harness: the batch solver that a user builds.

A run is stated from its scene (``system.py``, ``scripts.py``) and read from the frames that MFiX
writes (``vtp.py``, ``read.py``). The folder ``recorded`` holds output of 21.3.2.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from harness.engines.contract import Engine, Job, Template
from harness.engines.fingerprints import facts, program_files
from harness.engines.mfix.contact_balls import contact_table
from harness.engines.mfix.contact_input import ContactInput
from harness.engines.mfix.declared import OBTAIN, TRAITS
from harness.engines.mfix.read import check_end, forced_table, path_table
from harness.engines.mfix.scripts import contact_files, input_files, states_contact, system_files
from harness.engines.mfix.solver import Run, Solver, version_of
from harness.engines.mfix.step import REFERENCE, Scheme, steps_per_contact
from harness.engines.mfix.system import System, contact_in, system_of
from harness.engines.output import SERIES, Output, Table
from harness.engines.parallel import cores, parallel_map
from harness.engines.process import Limits
from harness.engines.programs import find_program
from harness.engines.scene import LOOK, Scene
from harness.errors import EngineError, EngineMissingError, EngineOutputError, RequestError
from harness.observables.provenance import Provenance
from harness.parameters.contact import Contact

MOST_FRAMES = 100_000
"""Files that a run writes at most: MFiX writes one a sample."""

STRETCHES = (8.0, 32.0, 128.0, 512.0)
"""[sqrt(d/g)] that a scene is run for before all its steps: MFiX cannot stop early."""


class Mfix(Engine):
    """The batch solver of MFiX at ``program``, a path or a name on PATH.

    ``workers`` processes run side by side, as many as there are cores unless told
    otherwise. Raise EngineMissingError without a program or with one that is no MFiX,
    RequestError where there is no such file. ``scheme`` is MFiX's integrator.
    """

    name = "mfix"
    traits = TRAITS

    def __init__(
        self,
        program: str | None = None,
        workers: int | None = None,
        limits: Limits | None = None,
        scheme: Scheme = "EULER",
    ) -> None:
        if program is None:
            raise EngineMissingError(f"MFiX was not found: {OBTAIN}")
        self._program = find_program(f"program {self.name}=", program)
        self._version = version_of(self._program)
        self._workers = workers or cores()
        self._solver = Solver(self._program, limits or Limits())
        self._scheme: Scheme = scheme
        if scheme != "EULER":
            self.traits = replace(self.traits, integrator=REFERENCE[scheme], contact_powers=())

    def identify(self) -> Provenance:
        """Return the version that the solver names, and its path."""
        return Provenance(
            engine=self.name,
            engine_version=self._version,
            executable=self._program,
            how="executable",
            script="mfix.dat",
            integrator=self.traits.integrator,
        )

    @classmethod
    def fingerprint_of(cls, **options: Any) -> Mapping[str, Any] | None:
        """Return the contents of the solver and its libraries, and the integrator."""
        if options.get("program") is None:
            raise EngineMissingError(f"MFiX was not found: {OBTAIN}")
        files = program_files(Path(find_program(f"program {cls.name}=", options["program"])))
        scheme = {"scheme": options.get("scheme", "EULER")}
        return facts(cls.name, "executable", files, options=scheme) if files else None

    def fingerprint(self) -> Mapping[str, Any] | None:
        """Return :meth:`fingerprint_of` this solver."""
        return self.fingerprint_of(program=self._program, scheme=self._scheme)

    @classmethod
    def states(cls, template: Template) -> bool:
        """Return whether it can be told of a template: by a scene, or by an input of its own."""
        return super().states(template) or states_contact(template)

    @classmethod
    def steps_of(cls, own: float, contact: Contact) -> float:
        """Return the steps per contact of a ``DTSOLID_FACTOR``."""
        return steps_per_contact(own, contact)

    def refuses(self, job: Job) -> str:
        """Return why the engine cannot run a job, or nothing where it can."""
        reason = super().refuses(job)
        if reason or job.template.scene is None:
            return reason
        try:
            scene = job.template.scene(job.values, self.traits.spring)
            _stated(job.template.name, scene, _stretches(scene)[0], self._scheme)
        except RequestError as error:
            return str(error)
        return ""

    def run(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Run the scenes of the jobs, a process for each, in longer stretches until decided."""
        self.check(jobs)
        return parallel_map(self._one, jobs, self._workers)

    @classmethod
    def inputs(cls, templates: Iterable[Template]) -> dict[str, str]:
        """Return the inputs of templates that have an example, by their names below ``inputs``."""
        return input_files(templates)

    def close(self) -> None:
        """End MFiX's processes and remove what they left."""
        self._solver.close()

    def _one(self, job: Job) -> Output | EngineError:
        """Run one job until it is decided, or all its steps."""
        if job.template.scene is None:
            return self._contact(ContactInput(job.values, self._scheme))
        scene, seconds = job.template.scene(job.values, self.traits.spring), 0.0
        for steps in _stretches(scene):
            try:
                system = _stated(job.template.name, scene, steps, self._scheme)
            except RequestError as error:
                return EngineOutputError(f"MFiX: undecided after {seconds:.3g} s; {error}")
            found = self._solver.run(system_files(system))
            if isinstance(found, EngineError):
                return found
            seconds += found.seconds
            try:
                table = _read(system, scene, found)
            except EngineError as error:
                error.log = found.log
                return error
            if scene.decided is None or scene.decided(table):
                break
        return Output((), self.identify(), {SERIES: table}, found.log, seconds, self.title)

    def _contact(self, contact: ContactInput) -> Output | EngineError:
        """Run a contact with friction."""
        found = self._solver.run(contact_files(contact))
        if isinstance(found, EngineError):
            return found
        try:
            table = contact_table(contact, found.frames)
        except EngineError as error:
            error.log = found.log
            return error
        return Output((), self.identify(), {SERIES: table}, found.log, found.seconds, self.title)


def _read(system: System, scene: Scene, found: Run) -> Table:
    """Return the table of a run; a scene that nothing decides early must reach its end."""
    if scene.forces:
        table = forced_table(system, scene, found.frames, found.forces)
    else:
        table = path_table(system, scene, found.frames)
    if scene.decided is None:
        check_end(system, found.frames)
    return table


def _stretches(scene: Scene) -> list[int]:
    """Return the steps to run a scene for, in order, until it is decided."""
    gravity = math.hypot(*scene.gravity)
    if scene.decided is None or gravity == 0.0:
        return [scene.steps]
    unit = math.sqrt(float(scene.diameter[0]) / gravity) / scene.step
    return sorted({*(min(math.ceil(s * unit), scene.steps) for s in STRETCHES), scene.steps})


def _stated(name: str, scene: Scene, steps: int, scheme: Scheme) -> System:
    """Return a system that MFiX can be told; raise RequestError for one that it cannot."""
    refused = TRAITS.refuses_contact(contact_in(scene))
    if scene.columns is not None:
        refused = "it holds no particles to the axis of a column"
    if refused:
        raise RequestError(refused)
    every = scene.every or max(LOOK, math.ceil(steps / MOST_FRAMES))
    system = system_of(name, scene, steps, every, scheme)
    frames = system.steps // system.every
    if frames > MOST_FRAMES:
        raise RequestError(
            f"every = {system.every} steps: MFiX writes a file each, {frames} of them; "
            f"must be at most {MOST_FRAMES}"
        )
    assert system.factor > 0.0
    return system
