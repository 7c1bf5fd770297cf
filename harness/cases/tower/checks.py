"""Checks of the tower: engines against the exact propagator and at equal steps, RK4, the two laws.

A tower has no dissipation, so every engine with a linear spring runs the same physics, whatever
its rules on damping.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, partial
from itertools import product

import numpy as np

from harness.cases.base import Check, Level, Value
from harness.cases.bench import OWN, Bench
from harness.cases.tower.impulse import READINGS, source_angles
from harness.cases.tower.parameters import LAWS, SEARCH, Law, Tower
from harness.cases.tower.runs import Setup, TowerRun, make_setup, read, run_in, solve
from harness.cases.tower.windows import (
    Window,
    first_contact_end,
    impulse,
    impulse_until,
    peak_force,
)
from harness.engines.base import Engine
from harness.errors import EngineOutputError
from harness.model.scene import Floats
from harness.results.rows import Kind, Tolerance
from harness.results.series import first_divergence
from harness.theory.chain import DETACHMENT_TAU, Reading, grain_velocity

HEIGHTS: dict[int, Level] = {1: "quick", 2: "quick", 3: "default", 10: "default"}
WINDOWS: dict[int, tuple[Window, ...]] = {
    2: ("turnaround", "structure", "first-contact"),
    3: ("turnaround", "structure", "first-contact"),
    10: ("turnaround", "first-contact"),  # its chain never holds all ten contacts
}
TALL = Tower(height=40, law="overlap", gravity=0.0)
TALL_NAME, TALL_SAMPLES = "tall tower", 6000
LAW_HEIGHTS = (2, 10, 19)  # at which both laws are compared

Measure = Callable[[TowerRun], float]

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


def exact(setup: Setup) -> TowerRun:
    """Return the exact run, with samples at the same times."""
    return exact_run(setup.tower, setup.duration, setup.samples)


@cache
def exact_run(case: Tower, duration: float, samples: int) -> TowerRun:
    """Return an exact run, made once for all engines."""
    return solve(case, "exact", duration=duration, samples=samples)


# ---- engines


def engine_checks(engine: Engine) -> Iterator[Check]:
    """Yield the checks of an engine; of a law that it refuses the first alone, for the reason."""
    for law in LAWS:
        first, *others = law_checks(law)
        yield first
        if not engine.refuses(first.jobs[0]):
            yield from others
    tall = make_setup(TALL, samples=TALL_SAMPLES)
    yield replace(
        _against_exact(tall, "impulse_ratio", "1", first_contact_ratio, TALL_TOWER, endless_ratio),
        setup=TALL_NAME, kind=Kind.ANALYTIC, jobs=[tall.job],
        note="first contact, over that of a rigid base; a row without end in Bessel functions",
    )  # fmt: skip


def law_checks(law: Law) -> Iterator[Check]:
    """Yield the checks of a law: force, impulse, equal steps, alpha."""
    setups = {height: make_setup(Tower(law=law, height=height)) for height in HEIGHTS}
    for setup in setups.values():
        for check in exact_checks(setup):
            yield replace(check, jobs=[setup.job])
        yield Check(
            setup=_name(setup), quantity="motion_difference", unit="1", check="equal steps",
            measure=partial(motion_difference, setup), expected=0.0, tolerance=SAME_STEPS,
            level=_level(setup), jobs=[setup.job],
            note="largest difference of all particles, over the sizes of the columns",
        )  # fmt: skip
    for height, windows in WINDOWS.items():
        for window in windows:
            yield _ratio_check(setups[height], setups[1], window)


def exact_checks(setup: Setup) -> list[Check]:
    """Return the checks of force and impulse of one run against the exact ones."""
    force = FORCE[setup.tower.law]
    return [
        replace(
            _against_exact(setup, "force_difference", "1", force_difference, force, 0.0),
            note="largest difference from the exact force on the grain, over its peak",
        ),
        _against_exact(setup, "impulse_Ns", "N s", impulse, IMPULSE),
    ]


def _against_exact(
    setup: Setup, quantity: str, unit: str, measure: Measure, tolerance: Tolerance,
    expected: float | Callable[[Bench], float] | None = None,
) -> Check:  # fmt: skip
    """Return the check of a number of a run, expected as of the exact run unless given."""
    return Check(
        setup=_name(setup), quantity=quantity, unit=unit, level=_level(setup),
        measure=lambda bench: measure(run_of(setup, bench)),
        expected=(lambda _: measure(exact(setup))) if expected is None else expected,
        tolerance=partial(_of_scheme, setup, tolerance, measure),
    )  # fmt: skip


def _ratio_check(setup: Setup, first: Setup, window: Window) -> Check:
    """Return the check of alpha, the impulse over that on one contact."""
    of_window = partial(impulse, window=window)
    return Check(
        setup=_name(setup), quantity="impulse_ratio", unit="1", check=window, level=_level(setup),
        measure=lambda bench: of_window(run_of(setup, bench)) / of_window(run_of(first, bench)),
        expected=lambda _: of_window(exact(setup)) / of_window(exact(first)),
        tolerance=partial(_of_scheme, setup, RATIO, of_window), jobs=[first.job, setup.job],
    )  # fmt: skip


def _name(setup: Setup) -> str:
    return f"{setup.tower.law} law, n = {setup.tower.height}"


def _level(setup: Setup) -> Level:
    return HEIGHTS.get(setup.tower.height, "default")


def _of_scheme(setup: Setup, tolerance: Tolerance, measure: Measure, bench: Bench) -> Tolerance:
    """Return a tolerance for velocity Verlet; of other schemes, with the reference's error."""
    verlet = bench.name == OWN or bench.engine.traits.integrator == VERLET
    if verlet or setup.tower.law != "overlap":
        return tolerance
    step_error = abs(measure(reference_run(setup, bench)) - measure(exact(setup)))
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
    for law, height in product(LAWS, HEIGHTS):
        for check in exact_checks(make_setup(Tower(law=law, height=height))):
            yield replace(check, check="RK4")
    yield Check(
        setup=TALL_NAME, quantity="impulse_ratio", unit="1", check="exact propagator",
        measure=lambda _: first_contact_ratio(exact_run(TALL, SEARCH, TALL_SAMPLES)),
        expected=endless_ratio, tolerance=NO_STEP, kind=Kind.ANALYTIC,
    )  # fmt: skip
    for height in LAW_HEIGHTS:
        yield from _law_findings(height)


def _law_findings(height: int) -> Iterator[Check]:
    """Yield how far the forces and the critical angles of both laws are from each other."""
    deformable, overlap = (
        make_setup(Tower(law=law, height=height)) for law in ("deformable", "overlap")
    )
    of_laws = partial(
        Check, setup=f"deformable against overlap law, n = {height}", kind=Kind.FINDING
    )
    yield of_laws(
        quantity="force_difference",
        unit="1",
        measure=lambda _: force_difference(exact(deformable), exact(overlap)),
        expected=0.0,
        note="both exact; the laws are one for a single contact",
    )
    for reading in READINGS:
        yield of_laws(
            quantity="critical_angle_deg",
            unit="deg",
            check=f"velocity {reading}",
            measure=partial(_source_angle, height, "deformable", reading),
            expected=partial(_source_angle, height, "overlap", reading),
            note="turnaround window, k = 1e6 N/m, 2 m/s",
        )


def _source_angle(height: int, law: Law, reading: Reading, _: Bench) -> float:
    return source_angles(height, law)[reading]
