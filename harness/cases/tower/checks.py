"""Checks of the tower: engines against the exact propagator and at equal steps, RK4, the two laws.

A tower has no dissipation, so every engine with a linear spring runs the same physics, whatever
its rules on damping.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np

from harness.cases.base import Check, Level, Value
from harness.cases.bench import OWN, Bench
from harness.cases.tower.impulse import READINGS, angle_from_impulse_ratio, source_angles
from harness.cases.tower.parameters import LAWS, SEARCH, Law, Tower
from harness.cases.tower.runs import (
    Timing,
    TowerRun,
    job_of,
    read,
    run_in,
    scene_of,
    solve,
    timing_of,
)
from harness.cases.tower.windows import (
    Window,
    first_contact_end,
    impulse,
    impulse_until,
    peak_force,
)
from harness.engines.base import Engine, Job
from harness.errors import EngineOutputError
from harness.results.limits import slope_order
from harness.results.rows import Kind, Tolerance
from harness.results.series import first_divergence
from harness.solvers.chain.setup import Floats
from harness.theory.chain import DETACHMENT_TAU, Reading, grain_velocity

HEIGHTS: dict[int, Level] = {1: "quick", 2: "quick", 3: "default", 10: "default"}
WINDOWS: dict[int, tuple[Window, ...]] = {
    2: ("turnaround", "structure", "first-contact"),
    3: ("turnaround", "structure", "first-contact"),
    10: ("turnaround", "first-contact"),  # its chain never holds all ten contacts
}
ANGLE_HEIGHT = 10
LADDER = tuple(250.0 * 2.0 ** (i / 4) for i in range(17))  # steps per contact time
ORDER_HEIGHT = 2
FINE_SAMPLES = 60_000  # of the exact force, between which a straight line is off by 1e-8
TALL = Tower(height=40, law="overlap", gravity=0.0)
TALL_SAMPLES = 6000
LAW_HEIGHTS = (2, 10, 19)  # at which both laws are compared

VERLET = "velocity-verlet"  # scheme of second order; of others the reference's is expected
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
ANGLE = Tolerance(absolute=1e-4, reason="alpha good to 1e-5: by less than 8 deg for each of alpha")
ORDER = Tolerance(
    absolute=0.15,
    reason="order 2 of velocity Verlet, that of the reference in other schemes; contacts change "
    "anywhere within a step, which scatters the errors; a whole order is far outside",
)
TALL_TOWER = Tolerance(absolute=1e-5, reason="velocity Verlet: (omega h)^2 = 1e-5")
NO_STEP = Tolerance(relative=1e-10, reason="no step: round-off, and events located to 1e-13")
SAME_STEPS = Tolerance(
    absolute=EQUAL_STEPS, reason="the same steps: round-off, which contact changes magnify"
)


@dataclass(frozen=True)
class Setup:
    """A tower with its timing, as checks run it."""

    case: Tower
    timing: Timing

    @property
    def name(self) -> str:
        """Return the name of the setup in rows."""
        return f"{self.case.law} law, n = {self.case.height}"

    @property
    def job(self) -> Job:
        """Return the job of the run in an engine."""
        return job_of(self.case, self.timing)

    @property
    def samples(self) -> int:
        """Return how many samples follow the start."""
        return self.timing.steps // self.timing.every

    def run(self, bench: Bench) -> TowerRun:
        """Return the run in an engine; of this package's solvers, by RK4 in its own steps."""
        if bench.name == OWN:
            return bench.once(solve, self.case, "rk4")
        return bench.once(run_in, bench, self.case, self.timing)

    def exact(self) -> TowerRun:
        """Return the exact run, with samples at the same times."""
        return exact_run(self.case, self.timing.duration, self.samples)

    def reference(self, bench: Bench) -> TowerRun:
        """Return the run at equal steps: a scene by the reference, else velocity Verlet here."""
        if self.case.law == "overlap":
            output = bench.reference_output(scene_of(self.case, self.timing))
            return read(self.case, self.timing, output)
        return bench.once(
            solve, self.case, "verlet", samples=self.samples,
            duration=self.timing.duration, steps_per_contact=self.timing.steps_per_contact,
        )  # fmt: skip


def setup(law: Law, height: int, steps_per_contact: float | None = None) -> Setup:
    """Return the source's tower of a law and height at k = 1e6 N/m and 2 m/s."""
    case = Tower(law=law, height=height)
    return Setup(case, timing_of(case, steps_per_contact=steps_per_contact))


@cache
def exact_run(case: Tower, duration: float, samples: int) -> TowerRun:
    """Return an exact run, made once for all engines."""
    return solve(case, "exact", duration=duration, samples=samples)


# ---- engines


def engine_checks(engine: Engine) -> Iterator[Check]:
    """Yield the checks of an engine; of a law that it refuses one alone, for the reason."""
    for law in LAWS:
        checks = law_checks(law)
        first = next(checks)
        yield first
        if not engine.refuses(first.jobs[0]):
            yield from checks
    tall = Setup(TALL, timing_of(TALL, samples=TALL_SAMPLES))
    yield _tall_check(
        measure=lambda bench: _first_contact_ratio(tall.run(bench)),
        tolerance=_of_scheme(tall, TALL_TOWER, _first_contact_ratio),
        level="default",
        jobs=[tall.job],
        note="first contact, over that of a rigid base; a row without end in Bessel functions",
    )


def law_checks(law: Law) -> Iterator[Check]:
    """Yield the checks of a law: force, impulse, equal steps, alpha, angles, order."""
    for height in HEIGHTS:
        one = setup(law, height)
        yield from _run_checks(one, jobs=[one.job])
        yield Check(
            setup=one.name,
            quantity="motion_difference",
            unit="1",
            check="equal steps",
            measure=partial(motion_difference, one),
            expected=0.0,
            tolerance=SAME_STEPS,
            level=HEIGHTS[height],
            jobs=[one.job],
            note="largest difference of all particles, over the sizes of the columns",
        )
    for height, windows in WINDOWS.items():
        for window in windows:
            yield _ratio_check(setup(law, height), window)
    for reading in READINGS:
        yield _ratio_check(setup(law, ANGLE_HEIGHT), "turnaround", reading)
    yield _order_check(law)


def _run_checks(one: Setup, check: str = "", jobs: Sequence[Job] = ()) -> Iterator[Check]:
    """Yield the checks of force and impulse of one run against the exact ones."""
    of_run = partial(Check, setup=one.name, check=check, level=HEIGHTS[one.case.height], jobs=jobs)
    yield of_run(
        quantity="force_difference",
        unit="1",
        measure=lambda bench: force_difference(one.run(bench)),
        expected=0.0,
        tolerance=_of_scheme(one, FORCE[one.case.law], force_difference),
        note="largest difference from the exact force on the grain, over its peak",
    )
    yield of_run(
        quantity="impulse_Ns",
        unit="N s",
        measure=lambda bench: impulse(one.run(bench)),
        expected=lambda _: impulse(one.exact()),
        tolerance=_of_scheme(one, IMPULSE, impulse),
    )


def _ratio_check(one: Setup, window: Window, reading: Reading | None = None) -> Check:
    """Return the check of alpha(n) in a window, or of the critical angle by a reading of it."""
    first = setup(one.case.law, 1)

    def value(run: Callable[[Setup], TowerRun]) -> float:
        ratio = impulse(run(one), window) / impulse(run(first), window)
        return angle_from_impulse_ratio(ratio, reading) if reading else ratio

    return Check(
        setup=one.name,
        quantity="critical_angle_deg" if reading else "impulse_ratio",
        unit="deg" if reading else "1",
        check=f"velocity {reading}" if reading else window,
        measure=lambda bench: value(lambda one: one.run(bench)),
        expected=lambda _: value(Setup.exact),
        tolerance=_of_scheme(one, ANGLE if reading else RATIO, partial(impulse, window=window)),
        level=HEIGHTS[one.case.height],
        jobs=[first.job, one.job],
    )


def _order_check(law: Law) -> Check:
    """Return the check of the order in the step of the error of the force."""
    ladder = [setup(law, ORDER_HEIGHT, steps) for steps in LADDER]

    def expected(bench: Bench) -> float:
        if _is_verlet(bench, law):
            return 2.0
        return step_order([one.reference(bench) for one in ladder]).value

    return Check(
        setup=f"{ladder[0].name}, {LADDER[0]:g} to {LADDER[-1]:g} steps",
        quantity="order_in_step",
        unit="1",
        measure=lambda bench: step_order([one.run(bench) for one in ladder]),
        expected=expected,
        tolerance=ORDER,
        level="default",
        jobs=[one.job for one in ladder],
        note="of the root mean square of the error of the force, with its 95 % interval",
    )


def _is_verlet(bench: Bench, law: Law) -> bool:
    """Return whether closed forms are expected: of velocity Verlet, and of solvers here."""
    return law != "overlap" or bench.name == OWN or bench.engine.traits.integrator == VERLET


def _of_scheme(
    one: Setup, tolerance: Tolerance, measure: Callable[[TowerRun], float]
) -> Callable[[Bench], Tolerance]:
    """Return a tolerance for velocity Verlet; of other schemes, with the reference's own error."""

    def width(bench: Bench) -> Tolerance:
        if _is_verlet(bench, one.case.law):
            return tolerance
        step_error = abs(measure(one.reference(bench)) - measure(one.exact()))
        return Tolerance(
            tolerance.absolute + step_error,
            tolerance.relative + 10.0 ** (1 - bench.engine.traits.digits),
            f"{tolerance.reason}; the reference by the same scheme is off by {step_error:.2g}",
        )

    return width


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


def motion_difference(one: Setup, bench: Bench) -> Value:
    """Return the largest difference from the run at equal steps, and when it began."""
    run, reference = one.run(bench), one.reference(bench)
    columns, wanted = _columns(run, bench), _columns(reference, bench)
    found = first_divergence(
        run.time, columns, wanted, reference_time=reference.time, absolute=EQUAL_STEPS
    )
    largest = max(float(np.abs(columns[name] - wanted[name]).max()) for name in wanted)
    return Value(largest) if found is None else Value(largest, 0.0, found.note, found.failure)


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


def step_order(runs: list[TowerRun]) -> Value:
    """Return the order in the step of the error of the force, with its 95 % interval."""
    exact = exact_run(runs[0].tower, SEARCH, FINE_SAMPLES)
    steps, errors = [float(run.step or 0.0) for run in runs], []
    for run in runs:
        wanted = np.interp(run.time, exact.time, exact.grain_force)
        squares = (run.grain_force - wanted) ** 2
        square = float(0.5 * (squares[1:] + squares[:-1]) @ np.diff(run.time))
        errors.append(math.sqrt(square / run.time[-1]))
    order, (low, high) = slope_order(steps, errors)
    return Value(order, 0.5 * (high - low))


def _tall_check(**how: Any) -> Check:
    """Return a check of the impulse of the first contact over 2 m v0, of a row without end."""
    expected = (1.0 - float(grain_velocity(DETACHMENT_TAU))) / 2.0  # 0.5661397
    return Check(setup="tall tower", quantity="impulse_ratio", unit="1", expected=expected,
                 kind=Kind.ANALYTIC, **how)  # fmt: skip


def _first_contact_ratio(run: TowerRun) -> float:
    return impulse_until(run, first_contact_end(run)) / (2.0 * run.tower.speed)


# ---- solvers of this package


def solver_checks() -> Iterator[Check]:
    """Yield RK4 against the exact propagator, that on a tall tower, and both laws compared."""
    for law in LAWS:
        for height in HEIGHTS:
            yield from _run_checks(setup(law, height), "RK4")
    yield _tall_check(
        check="exact propagator",
        measure=lambda _: _first_contact_ratio(exact_run(TALL, SEARCH, TALL_SAMPLES)),
        tolerance=NO_STEP,
    )
    for height in LAW_HEIGHTS:
        yield from _law_findings(height)


def _law_findings(height: int) -> Iterator[Check]:
    """Yield how far the forces and the critical angles of both laws are from each other."""
    pair = [setup(law, height) for law in ("deformable", "overlap")]
    of_laws = partial(
        Check, setup=f"deformable against overlap law, n = {height}", kind=Kind.FINDING
    )
    yield of_laws(
        quantity="force_difference",
        unit="1",
        measure=lambda _: force_difference(*(one.exact() for one in pair)),
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
