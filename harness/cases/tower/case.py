"""The case ``tower``: one run of it, its checks and its sections of a report.

A tower has no dissipation, so every engine with a linear spring runs the same physics, whatever
its rules on damping. Each is compared with the exact propagator, which has no step, and at equal
steps; RK4 of this package likewise, and the two laws with one another.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache, lru_cache, partial
from importlib.resources import files
from itertools import product
from typing import Any

import numpy as np

from harness.cases.base import Case, Check, Level, Quantity, Value
from harness.cases.bench import OWN, Bench
from harness.cases.checks import FULL_DIGITS
from harness.cases.tower.impulse import (
    HEIGHTS,
    MARGIN,
    READINGS,
    Runner,
    Window,
    angle_figure,
    energy_drift,
    first_contact_end,
    grain_velocity_at,
    impulse,
    impulse_until,
    peak_force,
    source_angles,
    source_table,
    touch_time,
    turnaround,
    window_end,
)
from harness.cases.tower.parameters import LAWS, SEARCH, Law, Tower, TowerParameters
from harness.cases.tower.runs import (
    Setup,
    TowerRun,
    first_divergence,
    make_setup,
    read,
    run_in,
    solve,
)
from harness.engines.base import Engine, Job, Output
from harness.errors import EngineOutputError, RequestError
from harness.model.scene import Floats
from harness.report.content import Discs, Drawing, Opening, Section
from harness.results.rows import Kind, Tolerance
from harness.theory.chain import DETACHMENT_TAU, Reading, grain_velocity

LEVELS: dict[int, Level] = {1: "quick", 2: "quick", 3: "default", 10: "default"}
RATIO_WINDOWS: dict[int, tuple[Window, ...]] = {
    2: ("turnaround", "structure", "first-contact"),
    3: ("turnaround", "structure", "first-contact"),
    10: ("turnaround", "first-contact"),  # its chain never holds all ten contacts
}
TALL = Tower(height=40, law="overlap", gravity=0.0)
TALL_NAME, TALL_SAMPLES = "tall tower", 6000
LAW_HEIGHTS = (2, 10, 19)  # at which both laws are compared

Number = Callable[[TowerRun], float]

VERLET = "velocity-verlet"  # scheme of second order; of others the reference's error is allowed
SAME_TIME = 1e-12  # [-] of a run: differences of times that round-off makes
EQUAL_STEPS = 1e-9
FORCE: dict[Law, Tolerance] = {
    "overlap": Tolerance(
        absolute=1e-5,
        reason="velocity Verlet at 1000 steps per contact: second order, (omega h)^2 = 1e-5; RK4 "
        "at 4000 steps takes contact changes at second order too",
    ),
    "deformable": Tolerance(
        absolute=1e-4,
        reason="as for the overlap law, but the highest frequency grows with the touching chain: "
        "ten times the room",
    ),
}
IMPULSE = Tolerance(relative=1e-5, reason="an integral of the force, at least as close as it")
RATIO = Tolerance(absolute=1e-5, reason="two impulses, each good to 1e-5 at worst")
TALL_TOWER = Tolerance(absolute=1e-5, reason="velocity Verlet: (omega h)^2 = 1e-5")
NO_STEP = Tolerance(relative=1e-10, reason="no step: round-off, and events located to 1e-13")
SAME_STEPS = Tolerance(
    absolute=EQUAL_STEPS, reason="the same steps: round-off, which contact changes magnify"
)


def _force_scale(case: Tower) -> float:
    mass, stiffness = (case.each(name)[0] for name in ("mass", "stiffness"))
    return mass * case.gravity + case.speed * float((mass * stiffness) ** 0.5)


def _impulse_scale(case: Tower) -> float:
    return case.each("mass")[0] * (2.0 * case.speed + case.gravity * case.contact_time)


class TowerCase(Case[TowerParameters]):
    """A grain that runs into a row of particles at rest: force, impulse, energy."""

    name = "tower"
    has_figures = True
    group = "chains"
    summary = "A grain that runs into a row of particles at rest: force, impulse, energy."
    parameters = TowerParameters
    quantities = (
        Quantity("peak_force_N", "N", "largest contact force on the grain", _force_scale),
        Quantity("impulse_Ns", "N s", "impulse on the grain, turnaround window", _impulse_scale),
        Quantity("turnaround_s", "s", "time at which grain and base are closest",
                 lambda case: case.contact_time),
        Quantity("energy_drift", "1", "largest change of the energy, over its largest value"),
        Quantity("final_velocity_m_per_s", "m/s", "velocity of the grain after the duration",
                 lambda case: case.speed + case.gravity * case.contact_time),
    )  # fmt: skip
    presets = {  # noqa: RUF012 - as the base declares it
        "source-overlap": TowerParameters(),
        "source": TowerParameters(law="deformable"),
        "source-tallest": TowerParameters(height=19, law="deformable"),
        "grain-on-one": TowerParameters(height=1),
    }
    sources = {"source": "the source paper, arXiv 2409.13633"}  # noqa: RUF012
    solvers = ("exact", "rk4")
    exact_by = "exact propagator"

    def job(self, parameters: TowerParameters) -> Job:
        """Return the job of one run, long enough for the turnaround window."""
        return _setup(parameters).job

    def measure(self, parameters: TowerParameters, output: Output) -> Mapping[str, float]:
        """Return the quantities of one run; raise EngineOutputError for a bad output."""
        run = read(_setup(parameters), output)
        try:
            return _quantities(run, parameters)
        except RequestError as error:
            raise EngineOutputError(f"{output.engine}: {error}") from error

    def exact(self, parameters: TowerParameters) -> Mapping[str, float]:
        """Return the quantities by the exact propagator, which has no step; no drift of energy."""
        return {**_quantities(_exact(parameters), parameters), "energy_drift": 0.0}

    def reference(self, parameters: TowerParameters, bench: Bench) -> Mapping[str, float]:
        """Return the quantities at equal steps, of the deformable law by velocity Verlet here."""
        return _quantities(reference_run(_setup(parameters), bench), parameters)

    def solve(self, parameters: TowerParameters, solver: str) -> Mapping[str, float]:
        """Return the quantities by the exact propagator or RK4."""
        if solver not in self.solvers:
            return super().solve(parameters, solver)
        steps, duration = parameters.steps_per_contact, _duration(parameters)
        run = solve(parameters, solver, duration=duration, steps_per_contact=steps)
        return _quantities(run, parameters)

    def cost(self, parameters: TowerParameters) -> float:
        """Return the steps of a run times its particles."""
        return float(_asked_setup(parameters).steps * parameters.particles)

    def film_job(self, parameters: TowerParameters, frames: int) -> Job:
        """Return the job of a run with so many samples."""
        return _asked_setup(parameters, frames).job

    def discs(self, parameters: TowerParameters, output: Output) -> Discs:
        """Return the particles of a run, displacements drawn larger."""
        numbers = output.table(("step",))["step"]
        steps, every = int(numbers[-1]), int(numbers[min(1, len(numbers) - 1)])
        step = parameters.duration * parameters.contact_time / steps
        return read(Setup(parameters, parameters.duration, step, steps, every), output).discs()

    def checks(self, engine: Engine) -> Iterable[Check]:
        """Return the checks of an engine, against the exact propagator and at equal steps."""
        return engine_checks(engine)

    def own_checks(self) -> Iterable[Check]:
        """Return RK4 against the exact propagator, and findings on the two laws."""
        return solver_checks()

    def sections(self, benches: Mapping[str, Bench]) -> Sequence[Section]:
        """Return what a tower does to the critical angle, and the forces of engines."""
        return [_section()]


def _setup(parameters: TowerParameters) -> Setup:
    _asked_setup(parameters)  # raises for too many steps, before the exact run
    return make_setup(parameters, _duration(parameters), parameters.steps_per_contact)


def _asked_setup(parameters: TowerParameters, samples: int | None = None) -> Setup:
    """Return the setup of the duration that was asked for, perhaps without the whole window."""
    return make_setup(parameters, parameters.duration, parameters.steps_per_contact, samples)


def _duration(parameters: TowerParameters) -> float:
    """Return how long a run must be to cover the duration and the turnaround window [t0]."""
    exact, t0 = _exact(parameters), parameters.contact_time
    needed = max(window_end(exact, "turnaround") / t0, touch_time(exact) / t0 + SEARCH)
    return parameters.duration if needed <= parameters.duration else needed * MARGIN


@lru_cache(maxsize=64)
def _exact(parameters: TowerParameters) -> TowerRun:
    """Return the exact run that covers the duration and the turnaround window."""
    runner = Runner("exact")
    (run,) = runner.runs([parameters], max(parameters.duration, SEARCH))
    return runner.covering(run, "turnaround")


def _quantities(run: TowerRun, parameters: TowerParameters) -> dict[str, float]:
    end = min(parameters.duration * parameters.contact_time, float(run.time[-1]))
    return {
        "peak_force_N": peak_force(run),
        "impulse_Ns": impulse(run),
        "turnaround_s": turnaround(run),
        "energy_drift": energy_drift(run),
        "final_velocity_m_per_s": grain_velocity_at(run, end),
    }


# ---- runs that checks compare


def run_of(setup: Setup, bench: Bench) -> TowerRun:
    """Return the run in an engine; of this package's solvers, by RK4 in its own steps."""
    if bench.name == OWN:
        return bench.once(solve, setup.tower, "rk4")
    return bench.once(run_in, bench, setup)[0]


def reference_run(setup: Setup, bench: Bench) -> TowerRun:
    """Return the run at equal steps: a scene by the reference, else velocity Verlet here."""
    if setup.tower.law == "overlap":
        return read(setup, bench.reference_output(setup.scene))
    return bench.once(
        solve, setup.tower, "verlet", samples=setup.samples,
        duration=setup.duration, steps_per_contact=setup.steps_per_contact,
    )  # fmt: skip


@cache
def exact_run(case: Tower, duration: float, samples: int) -> TowerRun:
    """Return an exact run, made once for all engines."""
    return solve(case, "exact", duration=duration, samples=samples)


def _exact_of(setup: Setup) -> TowerRun:
    return exact_run(setup.tower, setup.duration, setup.samples)


# ---- engines


def engine_checks(engine: Engine) -> Iterator[Check]:
    """Yield the checks of an engine; of a law that it refuses the first alone, for the reason."""
    for law in LAWS:
        first, *others = law_checks(law)
        yield first
        if not engine.refuses(first.jobs[0]):
            yield from others
    tall = make_setup(TALL, samples=TALL_SAMPLES)
    yield _check(
        tall, "impulse_ratio", first_contact_ratio, TALL_TOWER,
        setup=TALL_NAME, expected=endless_ratio, kind=Kind.ANALYTIC,
        note="first contact, over that of a rigid base; a row without end in Bessel functions",
    )  # fmt: skip


def law_checks(law: Law) -> Iterator[Check]:
    """Yield the checks of a law: force, impulse, equal steps, alpha."""
    setups = {height: make_setup(Tower(law=law, height=height)) for height in LEVELS}
    for setup in setups.values():
        yield from exact_checks(setup)
        yield _check(
            setup, "motion_difference", peak_force, SAME_STEPS, check="equal steps",
            measure=partial(motion_difference, setup), expected=0.0, tolerance=_same_steps,
            note="largest difference of all particles, over the sizes of the columns",
        )  # fmt: skip
    for height, windows in RATIO_WINDOWS.items():
        for window in windows:
            yield _ratio_check(setups[height], setups[1], partial(impulse, window=window), window)


def exact_checks(setup: Setup, **how: Any) -> Iterator[Check]:
    """Yield the checks of force and impulse of one run against the exact ones."""
    yield _check(
        setup, "force_difference", force_difference, FORCE[setup.tower.law], expected=0.0,
        note="largest difference from the exact force on the grain, over its peak", **how,
    )  # fmt: skip
    yield _check(setup, "impulse_Ns", impulse, IMPULSE, unit="N s", **how)


def _ratio_check(setup: Setup, first: Setup, impulse_of: Number, window: Window) -> Check:
    """Return the check of alpha, the impulse over that on one contact."""
    return _check(
        setup, "impulse_ratio", impulse_of, RATIO, check=window, jobs=[first.job, setup.job],
        measure=lambda bench: impulse_of(run_of(setup, bench)) / impulse_of(run_of(first, bench)),
        expected=lambda _: impulse_of(_exact_of(setup)) / impulse_of(_exact_of(first)),
    )  # fmt: skip


def _check(run: Setup, quantity: str, number: Number, width: Tolerance, **how: Any) -> Check:
    """Return the check of a number of a run, expected as of the exact run unless given."""
    return Check(**{
        "setup": f"{run.tower.law} law, n = {run.tower.height}",
        "quantity": quantity,
        "unit": "1",
        "level": LEVELS.get(run.tower.height, "default"),
        "measure": lambda bench: number(run_of(run, bench)),
        "expected": lambda _: number(_exact_of(run)),
        "tolerance": partial(_of_scheme, run, width, number),
        "jobs": [run.job],
        **how,
    })  # fmt: skip


def _same_steps(bench: Bench) -> Tolerance:
    """Return round-off; the columns are over what the engine's digits resolve."""
    digits = bench.engine.traits.digits
    scaled = f"; differences are over what {digits} digits resolve"
    return replace(SAME_STEPS, reason=SAME_STEPS.reason + scaled * (digits < FULL_DIGITS))


def _of_scheme(setup: Setup, tolerance: Tolerance, measure: Number, bench: Bench) -> Tolerance:
    """Return a tolerance for velocity Verlet; of other schemes, with the reference's error."""
    verlet = bench.name == OWN or bench.engine.traits.integrator == VERLET
    if verlet or setup.tower.law != "overlap":
        return tolerance
    step_error = abs(measure(reference_run(setup, bench)) - measure(_exact_of(setup)))
    return Tolerance(
        tolerance.absolute + step_error,
        tolerance.relative + 10.0 ** (1 - bench.engine.traits.digits),
        f"{tolerance.reason}; the reference by the same scheme is off by {step_error:.2g}",
    )


# ---- measures


def force_difference(run: TowerRun, exact: TowerRun | None = None) -> float:
    """Return the largest difference of the force on the grain, over the exact peak [-].

    At the samples that both have: solvers add samples of their own where contacts change.
    ``exact`` has a sample at each step of a run unless given. Raise EngineOutputError without any.
    """
    if exact is None:
        exact = exact_run(run.tower, SEARCH, round(run.time[-1] / run.step)) if run.step else run
    near = SAME_TIME * exact.time[-1]
    place = np.searchsorted(exact.time, run.time - near).clip(max=exact.time.size - 1)
    same = np.abs(exact.time[place] - run.time) <= near
    if not same.any():
        raise EngineOutputError(f"{run.solver} left no sample at the time of an exact one")
    difference = run.grain_force[same] - exact.grain_force[place[same]]
    return float(np.abs(difference).max() / peak_force(exact))


def motion_difference(setup: Setup, bench: Bench) -> Value:
    """Return the largest difference from the run at equal steps, and when it began."""
    run, reference = run_of(setup, bench), reference_run(setup, bench)
    columns, expected = _columns(run, bench), _columns(reference, bench)
    failure, note = first_divergence(run.time, columns, reference.time, expected, EQUAL_STEPS)
    largest = float(np.max([np.abs(columns[name] - expected[name]) for name in expected]))
    return Value(largest, 0.0, note, failure)


def _columns(run: TowerRun, bench: Bench) -> dict[str, Floats]:
    """Return the columns of all particles over their sizes, or over what their digits resolve."""
    case = run.tower
    digit = 10.0 ** (1 - bench.engine.traits.digits) / EQUAL_STEPS
    place = digit * case.particles * case.each("diameter")[0]
    size = case.speed / case.omega
    sizes = {
        "displacement": (run.displacements, max(size, place)),
        "velocity": (run.velocities, max(1.0, digit) * case.speed),
        "force": (run.forces, max(1.0, digit) * case.each("stiffness")[0] * size),
    }
    return {
        f"{name} {i + 1}": values[:, i] / scale
        for name, (values, scale) in sizes.items()
        for i in range(values.shape[1])
    }


def first_contact_ratio(run: TowerRun) -> float:
    """Return the impulse of the first contact over 2 m v0 [-], for a mass of 1 kg."""
    return impulse_until(run, first_contact_end(run)) / (2.0 * run.tower.speed)


def endless_ratio(_: Bench) -> float:
    """Return the same of a row without end [-], 0.5661397."""
    return (1.0 - float(grain_velocity(DETACHMENT_TAU))) / 2.0


# ---- solvers of this package


def solver_checks() -> Iterator[Check]:
    """Yield RK4 against the exact propagator, that on a tall tower, and both laws compared."""
    for law, height in product(LAWS, LEVELS):
        yield from exact_checks(make_setup(Tower(law=law, height=height)), check="RK4", jobs=())
    yield Check(
        setup=TALL_NAME, quantity="impulse_ratio", unit="1", check="exact propagator",
        measure=lambda _: first_contact_ratio(exact_run(TALL, SEARCH, TALL_SAMPLES)),
        expected=endless_ratio, tolerance=NO_STEP, kind=Kind.ANALYTIC,
    )  # fmt: skip
    for height in LAW_HEIGHTS:
        yield from _law_findings(height)


def _law_findings(height: int) -> Iterator[Check]:
    """Yield how far the forces and the critical angles of both laws are from each other."""
    runs = [make_setup(Tower(law=law, height=height)) for law in ("deformable", "overlap")]
    setup = f"deformable against overlap law, n = {height}"
    yield Check(
        setup=setup, quantity="force_difference", unit="1", kind=Kind.FINDING, expected=0.0,
        measure=lambda _: force_difference(*map(_exact_of, runs)),
        note="both exact; the laws are one for a single contact",
    )  # fmt: skip
    for reading in READINGS:
        yield Check(
            setup=setup, quantity="critical_angle_deg", unit="deg", kind=Kind.FINDING,
            check=f"velocity {reading}",
            measure=partial(_source_angle, height, "deformable", reading),
            expected=partial(_source_angle, height, "overlap", reading),
            note="turnaround window, k = 1e6 N/m, 2 m/s",
        )  # fmt: skip


def _source_angle(height: int, law: Law, reading: Reading, bench: Bench) -> float:
    bench.once(source_table)  # by the first of the checks, which go side by side
    return source_angles(height, law)[reading]


# ---- report

TITLE = "What does a column of grains below do to that angle?"
OPENING = """\
In a well the velocity turns; what is left after the shock decides from which angle on the motion
persists. The source asks how a column of grains below the well changes that. Without friction the
answer rests on the impulse alone, and on how its formula is read.

A tower has no dissipation, so that every engine with a linear spring runs the same physics. Each is
compared with the exact propagator, and at equal steps against an independent program. Under the
overlap law, which DEM codes use, every contact presses with its own overlap. Under the deformable
law of the source a particle pressed on both sides gives way on both: a contact behind a compressed
one opens or closes at another time. They are the same law for one contact only."""
STEPS = (
    "A grain that falls on n contacts in a row takes the impulse J(n) from them; "
    "alpha = J(n) / J(1).",
    "The velocity lost in a well is rescaled by alpha: after it 1 - alpha / 2 of the "
    "velocity is left, in place of 1/2.",
)
TERMS = (
    ("overlap law", "each contact presses with its own overlap, as DEM codes have it"),
    ("deformable law", "the source's: a particle pressed on both sides gives way on both"),
    ("window", "the time over which the force is summed; turnaround: twice the time of the "
     "largest compression"),
    ("t0", "the time that a contact with one fixed particle lasts"),
)  # fmt: skip


def _section() -> Section:
    drawing = Drawing(
        "critical-angle-over-contacts",
        "The critical angle over the contacts below",
        "k = 1e6 N/m, 2 m/s, exact propagator, turnaround window. Solid: the impulse rescales the "
        "velocity lost; dashed: the velocity run. The band is measured in other work.",
        lambda: angle_figure(source_table()),
    )  # fmt: skip
    first = source_angles(1, "overlap")["lost"]
    overlap, deformable = (source_angles(HEIGHTS[-1], law)["lost"] for law in LAWS)
    result = (
        "So θ_c(n) = 2 atan(tan(15 deg) alpha / (4 - alpha)): "
        f"{first:.2f} deg for one contact, {overlap:.2f} (overlap law) and {deformable:.2f} "
        f"deg (deformable law) for {HEIGHTS[-1]}. "
        "Read the other way, as velocity kept, the same alpha makes it rise."
    )
    opening = Opening(
        title=TITLE,
        sketch=files(__package__).joinpath("sketch.svg").read_text(encoding="utf-8"),
        steps=(*STEPS, result),
        source="Harper, Dufek and Breard (arXiv:2409.13633)",
        terms=TERMS,
        figure=drawing,
    )
    return Section(TITLE, OPENING, opening=opening)


CASE = TowerCase()
