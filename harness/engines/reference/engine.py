"""The reference DEM as an engine of the harness: the incline only."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from typing import NamedTuple, get_args

from harness import __version__
from harness.cases.drop.parameters import Drop
from harness.cases.drop.result import DropRun
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun
from harness.cases.incline.routes import Start, start_of
from harness.cases.incline.springs import SpringLaw
from harness.engines.contract import Engine, Route
from harness.engines.parallel import cores, parallel_map
from harness.engines.reference import (
    mfix_adams_bashforth,
    mfix_euler,
    rk4,
    stretch,
    velocity_verlet,
)
from harness.engines.reference.adaptive import Adaptive
from harness.engines.reference.fixed_step import FixedStep
from harness.engines.reference.incline import run
from harness.engines.reference.row import Grain, Row, row_below, row_of
from harness.engines.reference.stability import Growth, fewest_steps_per_contact
from harness.engines.reference.trajectory_integrator import TrajectoryIntegrator
from harness.engines.traits import Traits
from harness.errors import EngineError, RequestError
from harness.observables.provenance import Provenance
from harness.observables.tower import TowerRun
from harness.observables.trajectory import Trajectory
from harness.parameters.hertz import STIFFEST
from harness.parameters.tower import Tower


class Method(NamedTuple):
    """An integrator in fixed steps: its number in the kernels, and its growth in the well."""

    number: int
    growth: Growth


FIXED_STEP = {
    "velocity-verlet": Method(stretch.VELOCITY_VERLET, velocity_verlet.growth),
    "mfix-euler": Method(stretch.MFIX_EULER, mfix_euler.growth),
    "mfix-adams-bashforth": Method(stretch.MFIX_ADAMS_BASHFORTH, mfix_adams_bashforth.growth),
    "rk4": Method(stretch.RK4, rk4.growth),
}

ADAPTIVE = "adaptive"
INTEGRATORS = (*FIXED_STEP, ADAPTIVE)
DEFAULT_INTEGRATOR = "velocity-verlet"

MOST_STEPS = 10**15


class Reference(Engine):
    """One grain on fixed spheres, linear or Hertz's spring with dashpot, by one of ``INTEGRATORS``.

    ``velocity-verlet`` follows LAMMPS, ``mfix-euler`` and ``mfix-adams-bashforth``
    follow MFiX-DEM; ``adaptive`` has no step (``steps_per_contact`` is ignored but for
    the sampling and the shift by ``phase``) and is the reference for the others.
    ``spring`` is ``linear`` or ``Hertz`` (:mod:`harness.parameters.hertz`).
    ``seconds`` [s] bounds the wall time of a run. Raise RequestError for an
    integrator or a spring that is not known.
    """

    name = "reference"
    traits = Traits(
        install_hint="comes with the harness",
        versions=(__version__,),
        integrator=DEFAULT_INTEGRATOR,
    )
    states_towers = False

    def __init__(
        self,
        integrator: str = DEFAULT_INTEGRATOR,
        *,
        spring: SpringLaw = "linear",
        workers: int | None = None,
        seconds: float = 300.0,
    ) -> None:
        if integrator not in INTEGRATORS:
            raise RequestError(
                f"--integrator {integrator!r} is not known: must be one of {', '.join(INTEGRATORS)}"
            )
        if spring not in get_args(SpringLaw):
            raise RequestError(f"spring {spring!r} is not known: must be linear or Hertz")
        self.integrator = integrator
        if type(self).traits is Reference.traits:  # a class of its own declares for itself
            self.traits = replace(self.traits, integrator=integrator, spring=spring)
        self._law: SpringLaw = spring
        self._workers = workers or cores()
        self._seconds = seconds

    def identify(self) -> Provenance:
        """Return the version, which is the harness's own, and the integrator."""
        return Provenance(
            engine=self.name,
            engine_version=__version__,
            how="compiled",
            integrator=self.integrator,
        )

    def drops(self, cases: Sequence[Drop]) -> list[DropRun | EngineError]:
        """Run the grain against the first sphere of the row; the others are out of its reach."""
        who = self.identify()

        def one(case: Drop) -> DropRun | EngineError:
            started = time.perf_counter()
            grain = Grain(0.0, case.diameter + case.gap, case.sideways, -case.speed)
            try:
                row = row_below(case, self._law)
                mover = self._moved(grain, row, case.step, case.steps, case.every)
                mover.finish()
                return DropRun(case, mover.trajectory(), time.perf_counter() - started, who)
            except EngineError as error:
                return error

        return [one(case) for case in cases]

    def inclines(
        self,
        cases: Sequence[Incline],
        route: Route,
        *,
        every: int | None = None,
        start: Start | None = None,
    ) -> list[InclineRun | EngineError]:
        """Run the cases and return their results in order.

        A ``start`` takes the place of the route's own. Raise RequestError for a
        step that the integrator cannot take.
        """
        self._check(cases)
        who = self.identify()

        def one(case: Incline) -> InclineRun | EngineError:
            seconds = case.time_limit * math.sqrt(case.diameter / case.gravity)
            longest = math.ceil(seconds / case.step)
            try:
                first = start or start_of(case, route, self._law)
                mover = self._mover(case, first, longest, every)
                return run(case, route, mover, who, sampled=every is not None, law=self._law)
            except EngineError as error:
                return error

        return self._side_by_side(one, cases)

    def follow(self, case: Incline, start: Start, duration: float, *, every: int = 1) -> Trajectory:
        """Return the path over ``duration`` [s] from a start, sampled every so many steps.

        The last step reaches the duration or passes it. Raise RequestError for a
        duration that is not positive or asks for more than 1e15 steps, EngineError when
        the run fails.
        """
        self._check([case])
        if not (math.isfinite(duration) and 0.0 < duration <= MOST_STEPS * case.step):
            raise RequestError(
                f"duration = {duration!r} s: must be greater than 0 and at most "
                f"{MOST_STEPS * case.step:.4g} s ({MOST_STEPS:g} steps)"
            )
        longest = math.ceil(duration / case.step * (1.0 - 1e-12))
        mover = self._mover(case, start, longest, every)
        mover.finish()
        return mover.trajectory()

    def towers(
        self,
        cases: Sequence[Tower],  # noqa: ARG002
        duration: float,  # noqa: ARG002
        *,
        steps_per_contact: float | None = None,  # noqa: ARG002
        samples: int | None = None,  # noqa: ARG002
        profiles: bool = False,  # noqa: ARG002
    ) -> list[TowerRun | EngineError]:
        """Raise RequestError: towers are the chain solvers' business."""
        raise RequestError(
            "engine 'reference' states the incline only: run towers in lammps or a chain solver"
        )

    def _check(self, cases: Sequence[Incline]) -> None:
        """Raise RequestError for a step at which the integrator is unstable."""
        method = FIXED_STEP.get(self.integrator)
        if method is None:
            return
        for case in cases:
            zeta = case.contact.zeta_against_full_mass
            # the spring is stiffest at the largest overlap, where the dashpot is the linear one
            stiffer = math.sqrt(STIFFEST) if self._law == "Hertz" else 1.0
            fewest = stiffer * _fewest_steps(self.integrator, zeta / stiffer)
            if case.steps_per_contact <= fewest:
                bound = f"greater than {fewest:.3f}" if math.isfinite(fewest) else "with damping"
                raise RequestError(
                    f"steps_per_contact = {case.steps_per_contact:g} is unstable with "
                    f"{self.integrator} at damping ratio {zeta:.4g}: must be {bound}"
                )

    def _mover(
        self, case: Incline, start: Start, longest: int, every: int | None
    ) -> TrajectoryIntegrator:
        if every is not None and every < 1:
            raise RequestError(f"every = {every}: must be at least 1 step")
        grain = Grain(*start.state())
        return self._moved(grain, row_of(case, self._law), case.step, longest, every)

    def _moved(
        self, grain: Grain, row: Row, step: float, longest: int, every: int | None
    ) -> TrajectoryIntegrator:
        if self.integrator == ADAPTIVE:
            sampling = None if every is None else every * step
            return Adaptive(grain, row, longest * step, sampling, self._seconds)
        number = FIXED_STEP[self.integrator].number
        return FixedStep(number, grain, row, step, longest, every, self._seconds)

    def _side_by_side(
        self, one: Callable[[Incline], InclineRun | EngineError], cases: Sequence[Incline]
    ) -> list[InclineRun | EngineError]:
        if len(cases) == 1:
            return [one(cases[0])]
        return parallel_map(one, cases, self._workers)


@cache
def _fewest_steps(integrator: str, zeta: float) -> float:
    return fewest_steps_per_contact(FIXED_STEP[integrator].growth, zeta)
