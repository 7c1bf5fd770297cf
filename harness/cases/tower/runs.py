"""Runs of towers: by the solvers of this package, and in engines by a script or a scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.bench import Bench
from harness.cases.tower.parameters import PROPERTIES, SEARCH, Tower, TowerParameters
from harness.engines.base import Engine, Job, Output, Template, Value
from harness.engines.output import Provenance
from harness.engines.scenes import check_clock
from harness.errors import EngineNaNError, EngineOutputError, RequestError, Unsupported
from harness.model.base import COUNT, Allowed, allowed_in
from harness.model.law import Law
from harness.model.scene import Body, Floats, Scene
from harness.report.content import Discs, Plottable
from harness.results.rows import Failure
from harness.solvers.chain import (
    STABILITY,
    Chain,
    ChainMotion,
    Scheme,
    compliance,
    highest_frequency,
    make_chain,
    overlaps_of_forces,
)

if TYPE_CHECKING:
    import pandas as pd

    from harness.report.figures import Figure

SCHEMES: dict[str, Scheme] = {"rk4": "rk4", "verlet": "velocity_verlet"}
SOLVERS = ("exact", *SCHEMES)
STEPS: dict[Scheme, float] = {"rk4": 4000.0, "velocity_verlet": 1000.0}  # in pi sqrt(m/k)
SAMPLES_PER_T0 = 1000
MOST_ROWS = 1_000_000  # particles times samples that an engine writes, unless samples are given
MOST_KEPT = 10_000_000  # likewise, that a solver keeps
MOST_STEPS = 2_000_000_000  # LAMMPS counts to 2^31
ROUNDING = 4 * float(np.finfo(float).eps)  # overlaps as small, over the position, count as open
SAME_TIME = 1e-9  # [-] of the record: differences of times that round-off makes
LARGEST_DRAWN = 0.32  # [diameters] the largest compression in a film
IN_SCRIPTS = ("height", "speed", "gravity", "base", "start", "gap", "law")
UNITS = {
    "time": "s", "grain_displacement": "m", "grain_velocity": "m/s", "grain_force": "N",
    "contacts": "1", "compression": "m", "compression_rate": "m/s", "kinetic_energy": "J",
    "elastic_energy": "J", "gravitational_energy": "J", "momentum": "kg m/s", "base_force": "N",
}  # fmt: skip

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True, kw_only=True, repr=False)
class TowerRun(ChainMotion, Plottable):
    """The motion of a tower, with what made it; ``provenance`` is that of an engine."""

    tower: Tower
    solver: str
    provenance: Provenance | None = None

    @property
    def time_over_t0(self) -> Floats:
        """Return the time in contact times of the grain and one fixed particle (M,) [1]."""
        return self.time / self.tower.contact_time

    @property
    def deformations(self) -> Floats:
        """Return how much each particle's diameter is shortened (M, N) [m], f/k by each contact."""
        force = np.pad(self.forces, ((0, 0), (1, 1)))
        return np.asarray((force[:, 1:] + force[:, :-1]) / np.array(self.tower.each("stiffness")))

    def to_frame(self) -> pd.DataFrame:
        """Return the series as a table, units in the names, ``t_over_t0`` in front."""
        import pandas as pd

        columns = {"t_over_t0": self.time_over_t0}
        for name, unit in UNITS.items():
            suffix = "" if unit == "1" else f"_{unit.replace('/', '_per_').replace(' ', '_')}"
            columns[name + suffix] = getattr(self, name)
        return pd.DataFrame(columns).astype({"contacts": int})

    def summary(self) -> dict[str, str]:
        """Return the tower, the largest force, the last velocity, and what ran it."""
        return {
            "tower": f"{self.tower.particles} particles, {self.tower.law} law",
            "largest force": f"{float(self.grain_force.max()):.7g} N",
            "last velocity of the grain": f"{float(self.grain_velocity[-1]):.7g} m/s",
            "run by": self.provenance.label if self.provenance else self.solver,
        }

    def draw(self) -> Figure:
        """Draw the force on the grain over time."""
        from harness.report.figures import axis, label, panels

        figure = panels(1, 1)
        figure.axes[0].plot(self.time_over_t0, self.grain_force)
        label(figure.axes[0], axis("time", "t0"), axis("force on the grain", "N"))
        return figure

    def discs(self) -> Discs:
        """Return the particles, with displacements and deformations drawn larger.

        All by one factor, so that the drawn boundaries touch where the particles do. Under the
        deformable law particles are drawn shortened; under the overlap law they overlap.
        """
        case = self.tower
        diameter = np.array(case.each("diameter"))
        factor = LARGEST_DRAWN * float(diameter.min()) / max(float(self.deformations.max()), 1e-300)
        shortened = factor * self.deformations if case.law == "deformable" else 0.0
        touching = np.cumsum(diameter) - (diameter + diameter[0]) / 2
        force = np.pad(self.forces, ((0, 0), (1, 1)))
        x = touching + factor * self.displacements
        title = f"tower of height {case.height}, {case.law} law, drawn {factor:.3g} times"
        return Discs(
            title, self.time, x, np.zeros_like(x),
            radius=np.broadcast_to(0.5 * (diameter - shortened), x.shape),
            value=np.maximum(force[:, 1:], force[:, :-1]),
            value_label="largest force on a particle (N)",
        )  # fmt: skip


def tower(
    case: Tower,
    *,
    solver: str | None = None,
    engine: Engine | None = None,
    duration: float = SEARCH,
    steps_per_contact: float | None = None,
    progress: Progress = lambda *_: None,
) -> TowerRun:
    """Run a tower for ``duration`` [t0] in an engine, else by a solver: RK4 unless named.

    ``steps_per_contact`` counts steps in pi sqrt(m/k), for solvers with a step. Raise RequestError
    for parameters out of range, and for a solver together with an engine of another name;
    EngineError for a run that failed.
    """
    if not (math.isfinite(duration) and duration > 0):
        raise RequestError(f"duration = {duration} t0: must be finite and greater than 0")
    if engine is not None:
        if solver not in (None, engine.name):
            raise RequestError(f"solver = {solver!r}: contradicts the engine {engine.name!r}")
        (run,) = run_in(Bench(engine), make_setup(case, duration, steps_per_contact))
        return run
    stage = f"tower of height {case.height}, {case.law} law"
    return solve(
        case, solver or "rk4", duration=duration, steps_per_contact=steps_per_contact,
        progress=partial(progress, stage),
    )  # fmt: skip


def solve(
    case: Tower,
    solver: str,
    *,
    duration: float = SEARCH,
    steps_per_contact: float | None = None,
    samples: int | None = None,
    progress: Callable[[int, int], None] = lambda *_: None,
) -> TowerRun:
    """Run a tower by ``exact``, ``rk4`` or ``verlet``; arguments and errors as of :func:`tower`.

    ``samples`` is how many to keep; about 1000 per t0 unless given, fewer of over 3333 particles.
    """
    from harness.solvers import chain_exact, chain_stepped

    if solver not in SOLVERS:
        raise RequestError(f"solver = {solver!r}: must be one of {', '.join(SOLVERS)}")
    seconds, chain = duration * case.contact_time, chain_of(case)
    if samples is None:
        most = max(100, MOST_KEPT // case.particles)
        samples = math.ceil(min(SAMPLES_PER_T0 * duration, most))
    how: dict[str, Any] = {"samples": samples, "progress": progress}
    if solver == "exact":
        if steps_per_contact is not None:
            raise RequestError(
                f"steps_per_contact = {steps_per_contact}: the exact solver has no step"
            )
        motion = chain_exact.run(chain, seconds, **how)
    else:
        scheme = SCHEMES[solver]
        steps = _stable_steps(chain, case, scheme, steps_per_contact)
        motion = chain_stepped.run(
            chain, seconds, case.contact_period / steps, scheme=scheme, **how
        )
    return TowerRun(**vars(motion), tower=case, solver=solver)


def _stable_steps(
    chain: Chain, case: Tower, scheme: Scheme, steps: float | None, fewest: float = 0.0
) -> float:
    """Return steps in pi sqrt(m/k), twice what is stable or more unless given.

    Raise RequestError for steps at which the scheme is unstable.
    """
    fewest = max(fewest, case.contact_period * highest_frequency(chain) / STABILITY[scheme])
    steps = max(STEPS[scheme], 2.0 * fewest) if steps is None else steps
    if not (math.isfinite(steps) and steps > fewest):
        raise RequestError(
            f"steps_per_contact = {steps!r}: must be finite and greater than {fewest:.5g}, where "
            f"{scheme} is unstable ({case.law} law, {case.height} touching contacts)"
        )
    return steps


def chain_of(case: Tower) -> Chain:
    """Return a tower as arrays at its start."""
    mass, stiffness = np.array(case.each("mass")), np.array(case.each("stiffness"))
    deformable, overlap = case.law == "deformable", np.full(case.height, -case.gap)
    if case.start == "preloaded":
        above = case.gravity * (np.cumsum(mass[:-1]) - mass[0])
        overlap = overlaps_of_forces(above, *compliance(stiffness, deformable))
    return make_chain(
        mass, stiffness, deformable=deformable, gravity=case.gravity,
        fixed_base=case.base == "fixed", speed=case.speed, overlap=overlap,
    )  # fmt: skip


# ---- engines: a script with values, or the same tower as a scene


@dataclass(frozen=True)
class Setup:
    """A tower and the steps of its run in an engine.

    ``duration`` is in t0, ``step`` in s; ``every`` steps lie between two samples.
    """

    tower: Tower
    duration: float
    step: float
    steps: int
    every: int

    @property
    def samples(self) -> int:
        """Return how many samples follow the start."""
        return self.steps // self.every

    @property
    def steps_per_contact(self) -> float:
        """Return the steps in pi sqrt(m/k)."""
        return self.tower.contact_period / self.step

    @property
    def values(self) -> dict[str, Value]:
        """Return a script's values; raise RequestError for unequal particles."""
        case = self.tower
        if any(len(set(case.each(name))) > 1 for name in PROPERTIES):
            raise RequestError("mass, stiffness and diameter must be one number each in an engine")
        return {
            **{name: case.each(name)[0] for name in PROPERTIES},
            **{name: getattr(case, name) for name in IN_SCRIPTS},
            "duration": self.duration,
            "steps_per_contact": self.steps_per_contact,
            "series_every": self.every,
        }

    @property
    def scene(self) -> Scene:
        """Return a tower of equal particles under the overlap law as a scene, gravity along x."""
        case = self.tower
        mass, stiffness, d = (case.each(name)[0] for name in PROPERTIES)
        last = case.height if case.base == "fixed" else -1
        # contact i of a preloaded tower carries the i - 1 particles between it and the grain
        sunk = mass * case.gravity / stiffness if case.start == "preloaded" else 0.0
        bodies = tuple(
            Body(
                radius=0.5 * d, mass=mass,
                position=(i * (d + case.gap) - 0.5 * i * (i - 1) * sunk, 0.0, 0.0),
                velocity=(0.0 if i else case.speed, 0.0, 0.0),
                motion="frozen" if i == last else "free",
            )
            for i in range(case.particles)
        )  # fmt: skip
        return Scene(
            bodies=bodies, law=Law(normal_stiffness=stiffness, damping="none"),
            gravity=(case.gravity, 0.0, 0.0),
            step=math.pi / case.omega / self.steps_per_contact,  # as the script has it
            steps=self.steps, every=self.every,
        )  # fmt: skip

    @property
    def job(self) -> Job:
        """Return the job, which writes the motion of all particles; errors as of `values`."""
        scene = self.scene if self.tower.law == "overlap" else None
        return Job(TEMPLATE, self.values, sampled=True, scene=scene)


def make_setup(
    case: Tower,
    duration: float = SEARCH,
    steps_per_contact: float | None = None,
    samples: int | None = None,
) -> Setup:
    """Return the setup of a run of ``duration`` [t0]; the step divides it and the samples.

    Raise RequestError for a step at which velocity Verlet is unstable, and for a script's least pi
    steps in a contact.
    """
    scheme: Scheme = "velocity_verlet"
    wanted = STEPS[scheme] if steps_per_contact is None else steps_per_contact
    _stable_steps(chain_of(case), case, scheme, wanted, math.pi)
    seconds = duration * case.contact_time
    least = seconds / case.contact_period * wanted
    if not least <= MOST_STEPS:
        raise RequestError(
            f"duration = {duration:g} t0, {wanted:g} steps per contact: more than 2e9 steps, "
            "LAMMPS's bound"
        )
    if samples is None:
        samples = math.ceil(SAMPLES_PER_T0 * duration)
        samples = max(100, min(samples, MOST_ROWS // case.particles))
    every = max(1, math.floor(least / samples))
    steps = every * math.ceil(least / every * (1 - 1e-12))
    return Setup(case, duration, seconds / steps, steps, every)


TEMPLATE = Template(
    "tower",
    {"": {**make_setup(Tower(height=2, law="overlap")).values,
          "steps_per_contact": STEPS["velocity_verlet"], "series_every": 4}},
    allowed={
        "restitution": Allowed(bounds={"minimum": 0, "maximum": 1}),
        "tail": Allowed(words=("attractive", "clipped")),
        **allowed_in(TowerParameters),
        "steps_per_contact": Allowed(bounds={"exclusiveMinimum": math.pi}),
        "duration": Allowed(bounds={"exclusiveMinimum": 0}, unit="t0"),
        "series_every": COUNT,
    },
)  # fmt: skip


def run_in(bench: Bench, *setups: Setup) -> list[TowerRun]:
    """Return the runs of towers in an engine, of one batch; raise the first EngineError."""
    jobs = [setup.job for setup in setups]
    bench.prepare(jobs)
    return [read(setup, bench.output(job)) for setup, job in zip(setups, jobs, strict=True)]


def read(setup: Setup, output: Output) -> TowerRun:
    """Return the run in an output: places, velocities and forces of all particles along x.

    Raise EngineOutputError for samples that are missing, cut or at other times, for other
    parameters, and for a tower in which nothing ever touches; EngineNaNError for values that are
    not finite; Unsupported for an engine that writes no forces.
    """
    case, shape = setup.tower, (setup.samples + 1, setup.tower.particles)
    output.check_numbers({
        **{f"{name}_{unit}": case.each(name)[0] for name, unit in PROPERTIES.items()},
        "speed_m_per_s": case.speed,
        "gravity_m_per_s2": case.gravity,
        "contact_time_s": case.contact_time,
        "step_s": setup.step,
        "steps": setup.steps,
    })  # fmt: skip
    # the base's force, perhaps unknown, is not used: it may be NaN
    table = output.table(("step", "x_m", "vx_m_per_s"), shape[0])
    columns = [table[name] for name in ("x_m", "vx_m_per_s", "fx_N") if name in table]
    if [column.shape for column in columns] != 3 * [shape]:
        raise EngineOutputError(
            f"{output.engine} left places, velocities or forces of another shape than {shape}"
        )
    if not np.array_equal(table["step"], setup.every * np.arange(shape[0])):
        raise EngineOutputError(
            f"{output.engine} left samples at other steps than every {setup.every}"
        )
    time = np.asarray(table["step"] * setup.step)
    if "time_s" in table:
        check_clock(output.engine, table["time_s"], time)
    x, v, force_x = columns
    # a scene's motion has the forces of contacts alone, a script's dump those with the weight
    weight = 0.0 if "tz_N_m" in table else case.each("mass")[0] * case.gravity
    if np.isnan(force_x[:, :-1]).all():
        raise Unsupported(f"{output.engine} writes no forces")
    force = _contact_forces(case, force_x, weight, x)
    if not np.isfinite(force).all():
        raise EngineNaNError(f"{output.engine} wrote a force that is not a number")
    if not (force > 0.0).any():
        raise EngineOutputError(f"{output.engine}: no contact of the tower ever presses")
    run = TowerRun(
        chain=chain_of(case), time=time,
        displacements=x - case.each("diameter")[0] * np.arange(shape[1]), velocities=v,
        forces=force, step=setup.step, tower=case, solver=output.provenance.engine,
        provenance=output.provenance,
    )  # fmt: skip
    final = {"final_velocity_m_per_s": float(run.grain_velocity[-1])}
    output.check_numbers(final, "is what its series has")
    return run


def _contact_forces(case: Tower, force: Floats, weight: float, x: Floats) -> Floats:
    """Return the contact forces (M, n) [N] from those on the particles (M, N), grain first.

    Particle i has its weight [N], is pushed on by contact i - 1 and stopped by contact i.
    """
    contact = np.cumsum(weight - force[:, :-1], axis=1)
    smallest = ROUNDING * case.each("stiffness")[0] * float(np.abs(x).max())
    contact[np.abs(contact) <= smallest] = 0.0
    return np.asarray(contact)


def compile_chains() -> None:
    """Compile the kernels of the exact propagator and of the steps, which serve both laws."""
    from harness.solvers import chain_exact, chain_stepped

    chain = make_chain(np.ones(3), np.full(3, 1e6), deformable=True, speed=1.0, overlap=np.zeros(2))
    chain_exact.run(chain, 0.01, samples=10)
    chain_stepped.run(chain, 0.01, 1e-4, scheme="rk4", samples=10)


def first_divergence(
    time: Floats,
    columns: Mapping[str, Floats],
    reference_time: Floats,
    reference: Mapping[str, Floats],
    band: float,
) -> tuple[Failure, str]:
    """Return class and place of the first difference from a reference by more than ``band``.

    Without any it is ``Failure.NONE``. Times [s] and columns have shape (samples,); both series
    have the same times, nothing is interpolated. NaN is outside the band. Raise ValueError for
    other times.
    """
    record = float(np.ptp(reference_time)) if reference_time.size else 0.0
    same = time.shape == reference_time.shape
    if not (same and np.all(np.abs(time - reference_time) <= SAME_TIME * record)):
        raise ValueError(f"{time.size} samples at other times than {reference_time.size} expected")
    starts = {}  # sample of each column that leaves the band
    for name, expected in reference.items():
        outside = ~(np.abs(columns[name] - expected) <= band)
        if outside.any():
            starts[name] = int(outside.argmax())
    if not starts:
        return Failure.NONE, ""
    name = min(starts, key=lambda column: starts[column])
    failure = Failure.FROM_FIRST_STEP if starts[name] <= 1 else Failure.LATE
    largest = float(np.max(np.abs(columns[name] - reference[name])))
    place = f"{name} at {time[starts[name]]:.6g} s, by up to {largest:.3g}"
    return failure, f"{failure}: {place}"
