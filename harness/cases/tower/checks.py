"""Checks of the tower: engines against the exact propagator and at equal steps, RK4, the two laws.

A tower has no dissipation, so every engine with a linear spring runs the same physics, whatever
its rules on damping.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np

from harness.cases.base import Check, Level, Value
from harness.cases.bench import OWN, Bench
from harness.cases.tower.impulse import READINGS, source_angles
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
from harness.results.rows import Kind, Tolerance
from harness.results.series import first_divergence
from harness.solvers.chain.motion import Floats
from harness.theory.chain import DETACHMENT_TAU, Reading, grain_velocity

HEIGHTS: dict[int, Level] = {1: "quick", 2: "quick", 3: "default", 10: "default"}
WINDOWS: dict[int, tuple[Window, ...]] = {
    2: ("turnaround", "structure", "first-contact"),
    3: ("turnaround", "structure", "first-contact"),
    10: ("turnaround", "first-contact"),  # its chain never holds all ten contacts
}
TALL = Tower(height=40, law="overlap", gravity=0.0)
TALL_SAMPLES = 6000
LAW_HEIGHTS = (2, 10, 19)  # at which both laws are compared

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

    def run(self, bench: Bench) -> TowerRun:
        """Return the run in an engine; of this package's solvers, by RK4 in its own steps."""
        if bench.name == OWN:
            return bench.once(solve, self.case, "rk4")
        return bench.once(run_in, bench, self.case, self.timing)

    def exact(self) -> TowerRun:
        """Return the exact run, with samples at the same times."""
        return exact_run(self.case, self.timing.duration, self.timing.samples)

    def reference(self, bench: Bench) -> TowerRun:
        """Return the run at equal steps: a scene by the reference, else velocity Verlet here."""
        if self.case.law == "overlap":
            output = bench.reference_output(scene_of(self.case, self.timing))
            return read(self.case, self.timing, output)
        return bench.once(
            solve, self.case, "verlet", samples=self.timing.samples,
            duration=self.timing.duration, steps_per_contact=self.timing.steps_per_contact,
        )  # fmt: skip


def setup(law: Law, height: int) -> Setup:
    """Return the source's tower of a law and height at k = 1e6 N/m and 2 m/s."""
    case = Tower(law=law, height=height)
    return Setup(case, timing_of(case))


@cache
def exact_run(case: Tower, duration: float, samples: int) -> TowerRun:
    """Return an exact run, made once for all engines."""
    return solve(case, "exact", duration=duration, samples=samples)


# ---- engines


def engine_checks(engine: Engine) -> Iterator[Check]:
    """Yield the checks of an engine; of a law that it refuses the first alone, for the reason."""
    for law in LAWS:
        checks = law_checks(law)
        first = next(checks)
        yield first
        if not engine.refuses(first.jobs[0]):
            yield from checks
    tall = Setup(TALL, timing_of(TALL, samples=TALL_SAMPLES))
    yield _tall_check(
        measure=lambda bench: _first_contact_ratio(tall.run(bench)),
        tolerance=partial(_of_scheme, tall, TALL_TOWER, _first_contact_ratio),
        level="default",
        jobs=[tall.job],
        note="first contact, over that of a rigid base; a row without end in Bessel functions",
    )


def law_checks(law: Law) -> Iterator[Check]:
    """Yield the checks of a law: force, impulse, equal steps, alpha."""
    for height in HEIGHTS:
        tower = setup(law, height)
        yield from _exact_checks(tower, jobs=[tower.job])
        yield _check(
            tower,
            "motion_difference",
            check="equal steps",
            measure=partial(motion_difference, tower),
            expected=0.0,
            tolerance=SAME_STEPS,
            jobs=[tower.job],
            note="largest difference of all particles, over the sizes of the columns",
        )
    first = setup(law, 1)
    for height, windows in WINDOWS.items():
        for window in windows:
            tower = setup(law, height)
            yield _check(
                tower,
                "impulse_ratio",
                check=window,
                measure=partial(_engine_ratio, tower, first, window),
                expected=partial(_exact_ratio, tower, first, window),
                tolerance=partial(_of_scheme, tower, RATIO, partial(impulse, window=window)),
                jobs=[first.job, tower.job],
            )


def _check(tower: Setup, quantity: str, unit: str = "1", **how: Any) -> Check:
    return Check(
        setup=tower.name, quantity=quantity, unit=unit, level=HEIGHTS[tower.case.height], **how
    )


def _exact_checks(tower: Setup, **how: Any) -> Iterator[Check]:
    """Yield the checks of force and impulse of one run against the exact ones."""
    yield _check(
        tower,
        "force_difference",
        measure=lambda bench: force_difference(tower.run(bench)),
        expected=0.0,
        tolerance=partial(_of_scheme, tower, FORCE[tower.case.law], force_difference),
        note="largest difference from the exact force on the grain, over its peak",
        **how,
    )
    yield _check(
        tower,
        "impulse_Ns",
        "N s",
        measure=lambda bench: impulse(tower.run(bench)),
        expected=lambda _: impulse(tower.exact()),
        tolerance=partial(_of_scheme, tower, IMPULSE, impulse),
        **how,
    )


def _engine_ratio(tower: Setup, first: Setup, window: Window, bench: Bench) -> float:
    return impulse(tower.run(bench), window) / impulse(first.run(bench), window)


def _exact_ratio(tower: Setup, first: Setup, window: Window, _: Bench) -> float:
    return impulse(tower.exact(), window) / impulse(first.exact(), window)


def _of_scheme(
    tower: Setup, tolerance: Tolerance, measure: Callable[[TowerRun], float], bench: Bench
) -> Tolerance:
    """Return a tolerance for velocity Verlet; of other schemes, with the reference's error."""
    verlet = bench.name == OWN or bench.engine.traits.integrator == VERLET
    if verlet or tower.case.law != "overlap":
        return tolerance
    step_error = abs(measure(tower.reference(bench)) - measure(tower.exact()))
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


def motion_difference(tower: Setup, bench: Bench) -> Value:
    """Return the largest difference from the run at equal steps, and when it began."""
    run, reference = tower.run(bench), tower.reference(bench)
    columns, expected = _columns(run, bench), _columns(reference, bench)
    divergence = first_divergence(
        run.time, columns, expected, reference_time=reference.time, absolute=EQUAL_STEPS
    )
    largest = float(np.max([np.abs(columns[name] - expected[name]) for name in expected]))
    if divergence is None:
        return Value(largest)
    return Value(largest, 0.0, divergence.note, divergence.failure)


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
            yield from _exact_checks(setup(law, height), check="RK4")
    yield _tall_check(
        check="exact propagator",
        measure=lambda _: _first_contact_ratio(exact_run(TALL, SEARCH, TALL_SAMPLES)),
        tolerance=NO_STEP,
    )
    for height in LAW_HEIGHTS:
        yield from _law_findings(height)


def _law_findings(height: int) -> Iterator[Check]:
    """Yield how far the forces and the critical angles of both laws are from each other."""
    deformable, overlap = (setup(law, height) for law in ("deformable", "overlap"))
    of_laws = partial(
        Check, setup=f"deformable against overlap law, n = {height}", kind=Kind.FINDING
    )
    yield of_laws(
        quantity="force_difference",
        unit="1",
        measure=lambda _: force_difference(deformable.exact(), overlap.exact()),
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
