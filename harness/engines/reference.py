"""The reference DEM as an engine of the harness: one grain on equal fixed spheres.

The grain is moved stage after stage, and the tables say what it did.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness import __version__
from harness.engines.contract import Engine, Job, scenes_and_others
from harness.engines.output import SERIES, Output, Table
from harness.engines.process import cores, parallel_map
from harness.engines.traits import FRICTIONLESS, ContactModel, Traits
from harness.errors import EngineError, RequestError
from harness.model.conventions import Rules
from harness.model.motion import Motion
from harness.observables.provenance import Provenance
from harness.observables.reference import Trajectory
from harness.parameters.plane_scene import STAGES, Stage
from harness.parameters.scene import ContactScene
from harness.solvers import reference as steps
from harness.solvers.grain.columns import OverColumns
from harness.solvers.grain.row import FIXED_STEP, Grain, Row, fewest_steps_per_contact, row_of
from harness.solvers.grain.trajectory import Adaptive, FixedStep, TrajectoryIntegrator

COLUMNS = ("step", "time_s", "x_m", "y_m", "vx_m_per_s", "vy_m_per_s")


def tables_of(
    scene: ContactScene, mover: TrajectoryIntegrator, row: Row, origin: tuple[float, float]
) -> dict[str, Table]:
    """Run a scene and return its tables; ``origin`` [m] is that of the mover in the scene.

    Errors as for :meth:`TrajectoryIntegrator.watch`.
    """
    x0, y0 = origin
    raised = row.mass * (row.along * x0 + row.normal * y0)
    stages = [Stage(stage.place - x0, stage.floor + raised) for stage in scene.stages]
    ends, touches = _through(stages, mover, row)
    tables: dict[str, Table] = {}
    if scene.stages:
        touching = {} if mover.touching is None else {"touching": np.array(touches, dtype=float)}
        tables[STAGES] = {**_table(ends, origin), **touching}
    if not scene.every:
        tables[SERIES] = _table(ends, origin)
    else:
        samples = np.column_stack(list(vars(mover.trajectory()).values()))
        steps = scene.every * np.arange(len(samples))
        tables[SERIES] = _table(np.column_stack([steps, samples]), origin)
    return tables


def _through(
    stages: Sequence[Stage], mover: TrajectoryIntegrator, row: Row
) -> tuple[NDArray[np.float64], list[bool | None]]:
    """Return the rows of the start and of the end of each stage, or of the run without stages.

    And whether the grain touches in each.
    """
    rows, touches = [_row(mover)], [mover.touching]
    if not stages:
        mover.finish()
        rows.append(_row(mover))
    for stage in stages:
        passed = _passes(stage, mover, row)
        rows.append(_row(mover))
        touches.append(mover.touching)
        if not passed:
            break
    return np.array(rows, dtype=np.float64), touches


def _passes(stage: Stage, mover: TrajectoryIntegrator, row: Row) -> bool:
    """Move until the grain passes the stage's place, and return whether it does.

    Dissipation only lowers the energy: a grain that turns back with less than the floor never
    passes. One that turns back with more goes on.
    """
    while True:
        mover.watch(stage.place, stage.floor)
        if mover.grain.x > stage.place:
            return True
        if mover.over or (mover.grain.vx < 0.0 and mover.energy(row) < stage.floor):
            return False


def _row(mover: TrajectoryIntegrator) -> tuple[float, ...]:
    return (mover.steps, mover.time, *mover.grain[:4])


def _table(rows: NDArray[np.float64], origin: tuple[float, float]) -> Table:
    table = dict(zip(COLUMNS, rows.T.copy(), strict=True))
    table["x_m"] += origin[0]
    table["y_m"] += origin[1]
    return table


EQUAL = 1e-9
"""[d] by which fixed spheres may lie off the row."""


def unstated(scene: ContactScene) -> str:
    """Return why a scene cannot be run, or nothing where it can.

    The fixed spheres are one, or an endless row along x in which they touch.
    """
    d = scene.diameter[0]
    if scene.columns is not None:
        return _columns_unstated(scene, scene.columns.height)
    if scene.fixed[0] or not scene.fixed[1:].all():
        return f"it moves one particle, the first, not {np.count_nonzero(~scene.fixed)}"
    if scene.forces:
        return "it writes no forces"
    if scene.fixed.size == 1:
        return "it needs a fixed sphere"
    if np.abs(scene.diameter / d - 1.0).max() > EQUAL:
        return "its spheres have one diameter"
    if scene.period is None:
        return "" if scene.fixed.size == 2 else "several fixed spheres must be an endless row"
    count = scene.fixed.size - 1
    row = scene.position[1:] - scene.position[1]
    apart = np.abs(row - np.outer(np.arange(count) * d, (1.0, 0.0))).max()
    if max(apart, abs(scene.period - count * d)) > EQUAL * count * d:
        return "its fixed spheres touch in an endless row along x"
    return ""


def _columns_unstated(scene: ContactScene, n: int) -> str:
    """Return why columns cannot be run: they stand a diameter apart, the first one at x = 0."""
    d, held = float(scene.diameter[0]), scene.position[1:]
    count = len(held) // n
    along = np.repeat(d * np.arange(count), n)
    if scene.forces:
        return "over columns it writes no forces"
    apart = np.abs(held[:, 0] - along).max()
    if scene.period is None or max(apart, abs(scene.period - count * d)) > EQUAL * count * d:
        return "its columns touch in an endless row along x from 0 on"
    return ""


def origin_of(scene: ContactScene) -> tuple[float, float]:
    """Return the centre [m] of the first fixed sphere; of columns, where their axes begin."""
    if scene.columns is not None:
        return 0.0, 0.0
    return float(scene.position[1, 0]), float(scene.position[1, 1])


def grain_of(scene: ContactScene) -> Grain:
    """Return the mobile particle, its place from the first fixed sphere."""
    x, y = (float(value) for value in scene.position[0])
    x0, y0 = origin_of(scene)
    return Grain(x - x0, y - y0, *(float(value) for value in scene.velocity[0]))


ADAPTIVE = "adaptive"
INTEGRATORS = (*FIXED_STEP, ADAPTIVE)
DEFAULT_INTEGRATOR = "velocity-verlet"

MOST_STEPS = 10**15


class Reference(Engine):
    """One grain on fixed spheres, linear spring and dashpot, by one of ``INTEGRATORS``.

    ``velocity-verlet`` follows LAMMPS, ``mfix-euler`` and ``mfix-adams-bashforth``
    follow MFiX-DEM; ``adaptive`` has no step (that of a scene counts for the sampling and the
    time limit alone) and is the reference for the others. ``seconds`` [s] bounds the wall time of
    a run. Raise RequestError for an integrator that is not known.
    """

    name = "reference"
    traits = Traits(
        install_hint="comes with the harness",
        versions=(__version__,),
        integrator=DEFAULT_INTEGRATOR,
        frictionless=ContactModel("contact", FRICTIONLESS | {"law": ("overlap", "deformable")}),
        microseconds_per_step=0.05,
        title="reference DEM",
        conventions=lambda scene: Rules(),  # noqa: ARG005
    )
    ready = True
    has_lj_units = True

    def __init__(
        self,
        integrator: str = DEFAULT_INTEGRATOR,
        *,
        workers: int | None = None,
        seconds: float = 300.0,
    ) -> None:
        if integrator not in INTEGRATORS:
            raise RequestError(
                f"--integrator {integrator!r} is not known: must be one of {', '.join(INTEGRATORS)}"
            )
        self.integrator = integrator
        if type(self).traits is Reference.traits:  # a class of its own declares for itself
            cost = 0.0 if integrator == ADAPTIVE else self.traits.microseconds_per_step
            self.traits = replace(self.traits, integrator=integrator, microseconds_per_step=cost)
        self.workers = workers or cores()
        self._seconds = seconds

    def identify(self) -> Provenance:
        """Return the version, which is the harness's own, and the integrator."""
        return Provenance(
            engine=self.name, engine_version=__version__, how="compiled", integrator=self.integrator
        )

    def refuses(self, job: Job) -> str:
        """Return why the engine cannot run a job, or nothing where it can."""
        reason = super().refuses(job)
        if reason or job.template.scene is None:
            return reason
        scene = job.template.scene(job.values)
        return self._unstated(scene) or self._unstable(scene, row_of(scene))

    def fingerprint(self) -> Mapping[str, Any]:
        """Return the integrator and the libraries; its own source is in every key."""
        return {
            "engine": self.name,
            "integrator": self.integrator,
            "packages": {name: version(name) for name in ("numba", "scipy")},
        }

    def run(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Run the scenes of the jobs, errors as for :meth:`run_scenes`."""
        return scenes_and_others(jobs, self.run_scene_jobs, self._run_jobs)

    def motions(self, jobs: Sequence[Job]) -> list[Motion | EngineError]:
        """Return the motion of each job's scene by default conventions."""

        def run_one(job: Job) -> Motion | EngineError:
            try:
                return steps.run(self.scene_of(job))
            except EngineError as error:
                return error

        return parallel_map(run_one, jobs, self.workers)

    def _run_jobs(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        scenes = []
        for job in jobs:
            reason, build = super().refuses(job), job.template.scene
            if reason or build is None:
                raise self._refused(job.template.name, reason)
            scenes.append(build(job.values))
        return self.run_scenes(scenes, [job.template.name for job in jobs])

    def run_scenes(
        self, scenes: Sequence[ContactScene], names: Sequence[str] = ()
    ) -> list[Output | EngineError]:
        """Run scenes side by side and return their outputs in order.

        ``names`` are what errors call them. Raise RequestError, before anything runs, for a scene
        that cannot be run, or a step at which the integrator is unstable.
        """
        systems = [
            (scene, self._row(scene, name))
            for scene, name in zip(scenes, names or ["scene"] * len(scenes), strict=True)
        ]
        provenance = self.identify()

        def run_scene(system: tuple[ContactScene, Row]) -> Output | EngineError:
            started = time.perf_counter()
            scene, row = system
            try:
                mover = self._mover(scene, row)
                tables = tables_of(scene, mover, row, origin_of(scene))
            except EngineError as error:
                return error
            seconds = time.perf_counter() - started
            return Output((), provenance, tables, seconds=seconds, title=self.title)

        return parallel_map(run_scene, systems, self.workers)

    def follow(self, scene: ContactScene) -> Trajectory:
        """Return the first particle's path over all steps of a scene, whatever its stages.

        Raise RequestError as for :meth:`run_scenes`, EngineError when the run fails.
        """
        scene = replace(scene, stages=(), every=scene.every or 1)
        (output,) = self.run_scenes([scene])
        if isinstance(output, EngineError):
            raise output
        return Trajectory(*(output.tables[SERIES][name] for name in COLUMNS[1:]))

    def _row(self, scene: ContactScene, name: str) -> Row:
        """Return the system of a scene; raise RequestError for one that cannot be run."""
        reason = self._unstated(scene)
        if reason:
            raise self._refused(name, reason)
        if scene.steps > MOST_STEPS:
            raise RequestError(f"steps = {scene.steps}: must be at most {MOST_STEPS:g}")
        row = row_of(scene)
        reason = self._unstable(scene, row)
        if reason:
            raise RequestError(reason)
        return row

    def _unstated(self, scene: ContactScene) -> str:
        """Return why a scene cannot be run, or nothing where it can."""
        if scene.columns is not None and self.integrator != DEFAULT_INTEGRATOR:
            return f"over columns it has the integrator {DEFAULT_INTEGRATOR} only"
        return unstated(scene)

    def _unstable(self, scene: ContactScene, row: Row) -> str:
        """Return why the step is one at which the integrator is unstable in a well, or nothing."""
        if self.integrator == ADAPTIVE or row.single or scene.columns is not None:
            return ""
        zeta = scene.contact.zeta_against_full_mass
        fewest = _fewest_steps(self.integrator, zeta)
        steps_per_contact = row.contact_time / scene.step
        if steps_per_contact > fewest:
            return ""
        bound = f"greater than {fewest:.3f}" if math.isfinite(fewest) else "with damping"
        return (
            f"steps_per_contact = {steps_per_contact:g} is unstable with "
            f"{self.integrator} at damping ratio {zeta:.4g}: must be {bound}"
        )

    def _mover(self, scene: ContactScene, row: Row) -> TrajectoryIntegrator:
        grain, step, every = grain_of(scene), scene.step, scene.every or None
        if scene.columns is not None:
            return OverColumns(grain, row, scene, self._seconds)
        if self.integrator == ADAPTIVE:
            sampling = None if every is None else every * step
            return Adaptive(grain, row, scene.steps * step, sampling, self._seconds)
        number = FIXED_STEP[self.integrator].number
        return FixedStep(number, grain, row, step, scene.steps, every, self._seconds)

    def _refused(self, name: str, reason: str) -> RequestError:
        return RequestError(f"engine {self.name!r} cannot run {name!r}: {reason}")


@cache
def _fewest_steps(integrator: str, zeta: float) -> float:
    return fewest_steps_per_contact(FIXED_STEP[integrator].growth, zeta)
