"""Checks of the incline: what is measured, against what, how close and why so close.

The reference takes the same steps under the conventions of the engine: it differs by round-off.
Theory holds for rigid grains, in the limit of stiffness and step. Steady motion is the second,
independent way to the angle.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from harness.cases.base import Check, Value
from harness.cases.bench import Bench
from harness.cases.incline.angle import angle_on, reference_angle
from harness.cases.incline.closed_form import rigid_angle
from harness.cases.incline.extrapolation import (
    FULL_LADDER,
    QUICK_LADDER,
    Ladder,
    extrapolated_on,
)
from harness.cases.incline.runs import read
from harness.cases.incline.search import first_cases, friction_text
from harness.cases.incline.system import Incline, Route, job_of, scene_of
from harness.cases.plane import COLUMNS, path_in
from harness.engines.base import Engine, Job
from harness.errors import EngineMissingError, EngineOutputError, Unsupported
from harness.model.contact import CLIPPED, PLASTIC, SOURCE
from harness.report.text import power
from harness.results.rows import LEVELS, Kind, Level, Tolerance
from harness.theory.chain import SHOCK_WITHOUT_REBOUND as SHOCK
from harness.theory.incline import critical_angle, energies, well_depth

Ladders = tuple[tuple[Level, Ladder, float], ...]  # shortest level, ladder, tolerance [deg]

COMPARED = Tolerance(reason="compared, not judged")
EVERY = 10  # steps between the samples of a path
PASSAGE_RUNS, STEADY_RUNS = 12, 16  # of a search
PATH_ANGLE = 10.2  # [deg] just below the critical angle: the margin is small, and shows a change

SLOW_MICROSECONDS = 5.0  # of a step, from which an engine has fewer checks of many runs

PLASTIC_CASE = Incline(contact=PLASTIC, steps_per_contact=100.0)
SOURCE_CASE = Incline(contact=SOURCE, steps_per_contact=50.0)
CLIPPED_CASE = Incline(contact=CLIPPED, steps_per_contact=50.0)
CASES = (PLASTIC_CASE, SOURCE_CASE, CLIPPED_CASE)
SOURCE_CLIPPED = SOURCE_CASE.replace(contact=SOURCE.replace(name="clipped source", tail="clipped"))
SHOCKS = PLASTIC_CASE.replace(steps_per_contact=200.0, angle=10.6)

LADDERS: Ladders = (
    ("quick", QUICK_LADDER, 1e-3),
    ("default", Ladder(), 3e-4),
    ("full", FULL_LADDER, 3e-4),
)

# a grain with friction, or of another size
ROLLING = PLASTIC_CASE.replace(friction=0.5)
DISC, LARGE = ROLLING.replace(shape="disc"), PLASTIC_CASE.replace(grain_diameter=2.0)
SLIDING = PLASTIC_CASE.replace(friction=0.1)
SLIGHT = PLASTIC_CASE.replace(friction=0.016)  # the highest critical angle
# of the sweep at 50 steps: where the angle is of the order k^(-1/2), and where it is not
SLIGHT_FRICTIONS, FRICTIONS = (0.005, 0.016, 0.03), (0.05, 0.1, 0.2, 0.35, 0.5)
# hardly a rebound, 6e-4, which a grain whose shocks slide feels
STIFF_CONTACT = PLASTIC.replace(name="stiff plastic", damping_ratio=20.0)
STIFF_SLIDING = SLIDING.replace(contact=STIFF_CONTACT, steps_per_contact=400.0, stiffness=1e7)

SLOW_LADDERS: Ladders = (("full", QUICK_LADDER, 1e-3),)

SAME_STEPS = Tolerance(
    1e-8,
    reason="the same steps in two codes: round-off of 1e-15 in some 1e5 steps, over the slope "
    "0.01 m g d per deg; measured 1e-11 deg",
)
SAME_PATH = Tolerance(
    1e-10,
    reason="the same steps in two codes: round-off of 1e-15, times 20 at the shock, and in a "
    "velocity times the rate of the contact, 3e2; measured 2e-12",
)
SAME_MOTION = Tolerance(1e-9, reason="only k d / (m g) enters: round-off of some 1e5 steps")
ROUTES = Tolerance(
    7e-3, reason="resolution of the search, and where in a step a contact begins, 1e-3 deg"
)
FRICTION_CURVE = Tolerance(
    0.012,
    reason="a grain that slides feels the restitution of the contact, 0.01, by 0.01 deg (0.0097 at "
    "mu = 0.05 as k goes to infinity); step 4e-3 deg",
)
STIFF_SLIDER = Tolerance(
    1e-3, reason="restitution 6e-4, k = 1e7 N/m, 400 steps: 4e-4 deg in the reference"
)
FIRST_CRESTS = 5
SAME_CRESTS = Tolerance(
    1e-8, reason="the same steps in two codes: round-off of 1e-15, times 20 at each of five shocks"
)
SHOCK_ENERGY = Tolerance(
    5e-5,
    reason="E' = (E + dE) / 4: stiffness and step move the angle by 2e-3 deg, the energy by 2e-5 "
    "m g d; a sum of such errors, each passed on with 1/4, is 4/3 of one",
)


def checks(engine: Engine, longest: Level = "full") -> Iterator[Check]:
    """Yield the checks of an engine up to a level; a slow one has fewer of many runs."""
    slow = engine.traits.microseconds_per_step >= SLOW_MICROSECONDS
    yield from limits(PLASTIC_CASE, SLOW_LADDERS if slow else LADDERS, longest)
    for case in CASES:
        yield same_angle(case, "quick")
    for case in CASES:
        yield same_path(case.replace(angle=PATH_ANGLE))
    yield routes(SOURCE_CASE, "quick")
    yield Check(
        setup=f"{words(SHOCKS)}, {SHOCKS.angle:g} deg",
        quantity="largest error of the energy after each shock",
        unit="m g d",
        measure=_worst_shock,
        expected=0.0,
        tolerance=SHOCK_ENERGY,
        kind=Kind.ANALYTIC,
        jobs=(job_of(SHOCKS, "steady"),),
    )
    yield Check(
        setup=f"{words(SHOCKS)}, {SHOCKS.angle:g} deg",
        quantity=f"largest error of the energy at {FIRST_CRESTS} crests",
        unit="m g d",
        measure=_worst_crest,
        expected=0.0,
        tolerance=partial(_with_digits, tolerance=SAME_CRESTS, unit=1.0),
        check="reference",
        jobs=(job_of(SHOCKS, "steady"),),
    )
    yield from _scales()
    yield Check(
        setup=f"{words(SOURCE_CASE)}, {PATH_ANGLE:g} deg, in-process against executable",
        quantity="margin_over_mgd",
        unit="1",
        measure=partial(_margin, case=SOURCE_CASE),
        expected=partial(_margin_of_twin, case=SOURCE_CASE),
        tolerance=Tolerance(1e-12, reason="the same instructions: round-off of another build"),
        jobs=(job_of(SOURCE_CASE, "passage"),),
    )
    yield from _findings()
    for case in (ROLLING, SLIDING):
        yield from _equal_steps(case, "quick")
    if longest == "quick":
        return
    for case in CASES:
        for stiffness in (1e5, 1e7):
            yield same_angle(case.replace(stiffness=stiffness), "default")
    for case in (DISC, LARGE):
        yield from _equal_steps(case, "default")
    if not slow:
        yield from _of_many_runs(engine, longest)


def _of_many_runs(engine: Engine, longest: Level) -> Iterator[Check]:
    """Yield limits, steady motion and the course over friction, of the levels default and full."""
    yield routes(PLASTIC_CASE, "full", 1e-3)
    rolling: Ladders = (("default", QUICK_LADDER, 1e-3), ("full", FULL_LADDER, 3e-4))
    yield from limits(ROLLING, rolling, longest)
    yield from limits(LARGE, (("full", Ladder(), 5e-4),), longest)
    yield from limits(DISC, (("full", Ladder(), 3e-4),), longest)
    yield from limits(SLIGHT, (("full", Ladder(), 2e-3),), longest)
    yield routes(ROLLING.replace(steps_per_contact=50.0), "default")
    coulomb = _limits_dashpot(engine)
    for friction in (*SLIGHT_FRICTIONS, *FRICTIONS):
        judged = friction in FRICTIONS and coulomb
        case = PLASTIC_CASE.replace(friction=friction, steps_per_contact=50.0)
        tolerance, kind = (FRICTION_CURVE, Kind.ANALYTIC) if judged else (COMPARED, Kind.FINDING)
        level: Level = "default" if judged or friction == SLIGHT.friction else "full"
        yield against_theory(case, tolerance, level, kind)
    kind = Kind.ANALYTIC if coulomb else Kind.FINDING
    yield against_theory(STIFF_SLIDING, STIFF_SLIDER if coulomb else COMPARED, "full", kind)


def _limits_dashpot(engine: Engine) -> bool:
    """Return whether Coulomb's limit holds for spring and dashpot together, as in theory.

    Otherwise a strongly damped grain sticks beyond the limit: -0.06 deg at a friction of 0.05.
    """
    try:
        rules = engine.rules(scene_of(SLIDING, "passage"))
    except Unsupported:
        return True
    return rules.damping_in_cap == "inside"


def _equal_steps(case: Incline, level: Level) -> Iterator[Check]:
    """Yield the angle of a case, and the path near it, against the reference."""
    yield same_angle(case, level)
    yield same_path(case.replace(angle=round(rigid_angle(case)[0], 2)), level)


def words(case: Incline) -> str:
    """Return contact, stiffness, step and friction of a case for a setup."""
    return (
        f"{case.contact.name} contact, k = {power(case.stiffness)} N/m, "
        f"{case.steps_per_contact:g} steps{friction_text(case)}"
    )


# ---- critical angles


def limits(case: Incline, ladders: Ladders, longest: Level) -> Iterator[Check]:
    """Yield the angle of rigid grains against theory; of a plain one its error over uncertainty."""
    for level, ladder, width in ladders:
        if LEVELS.index(level) > LEVELS.index(longest):
            continue
        stiffnesses = [case.stiffness * factor for factor in ladder.factors]
        setup = (
            f"{case.contact.name} contact{friction_text(case)}, step to zero, k from "
            f"{power(min(stiffnesses))} to {power(max(stiffnesses))} N/m and on to infinity"
        )
        jobs = tuple(job for one in ladder.cases(case) for job in _first_jobs(one))

        def measure(bench: Bench, ladder: Ladder = ladder) -> Value:
            found = extrapolated_on(bench, ladder, case)
            return Value(found.value, found.uncertainty)

        def over_uncertainty(bench: Bench, ladder: Ladder = ladder) -> float:
            found = extrapolated_on(bench, ladder, case)
            return (found.value - rigid_angle(case)[0]) / found.uncertainty

        expected = rigid_angle(case)[0]
        yield Check(
            setup=setup,
            quantity="critical_angle_deg",
            unit="deg",
            measure=measure,
            expected=expected,
            tolerance=Tolerance(width, reason="the last corrections that the ladder resolves"),
            kind=Kind.ANALYTIC,
            level=level,
            jobs=jobs,
        )
        if not case.is_plain:
            continue
        yield Check(
            setup=setup,
            quantity="error over uncertainty",
            unit="1",
            measure=over_uncertainty,
            expected=0.0,
            tolerance=Tolerance(1.0, reason="the uncertainty is a bound"),
            kind=Kind.ANALYTIC,
            level=level,
            jobs=jobs,
        )


def same_angle(case: Incline, level: Level) -> Check:
    """Return the angle of a case against the reference at equal steps."""
    return Check(
        setup=words(case),
        quantity="critical_angle_deg",
        unit="deg",
        measure=partial(_angle, case=case),
        expected=lambda bench: reference_angle(bench, case).value,
        tolerance=partial(_with_digits, tolerance=SAME_STEPS, unit=1.0 / 0.0087),
        level=level,
        check="reference",
        jobs=_first_jobs(case),
    )


def against_theory(
    case: Incline, tolerance: Tolerance, level: Level, kind: Kind = Kind.ANALYTIC
) -> Check:
    """Return the angle of a case against that of a rigid grain."""

    def measure(bench: Bench) -> Value:
        found = angle_on(bench, case)
        return Value(found.value, found.uncertainty)

    angle, model = rigid_angle(case)
    return Check(
        setup=words(case),
        quantity="critical_angle_deg",
        unit="deg",
        measure=measure,
        expected=angle,
        tolerance=tolerance,
        kind=kind,
        level=level,
        check="rigid grain",
        jobs=_first_jobs(case),
        note=model,
    )


def routes(case: Incline, level: Level, tolerance_deg: float | None = None) -> Check:
    """Return the angle by steady motion against the one by passage."""

    def measure(bench: Bench) -> Value:
        found = angle_on(bench, case, "steady", tolerance_deg)
        return Value(found.value, found.uncertainty, found.note)

    return Check(
        setup=words(case),
        quantity="critical_angle_deg",
        unit="deg",
        measure=measure,
        expected=partial(_angle, case=case),
        tolerance=ROUTES,
        level=level,
        check="steady motion against passage",
        jobs=_first_jobs(case, "steady"),
    )


def _angle(bench: Bench, case: Incline) -> float:
    return angle_on(bench, case).value


def _first_jobs(case: Incline, route: Route = "passage") -> tuple[Job, ...]:
    """Return the first jobs of a search, with the steps that the search is expected to take."""
    jobs = [job_of(one, route) for one in first_cases(case, route)]
    runs = (STEADY_RUNS if route == "steady" else PASSAGE_RUNS) / len(jobs)
    return tuple(replace(job, steps=runs * job.steps) for job in jobs)


def _scales() -> Iterator[Check]:
    """Yield angles of the same k d / (m g) in other units."""
    glass = CLIPPED_CASE.replace(diameter=3e-3, density=2500.0)
    for name, scaled in (
        ("3 mm glass", glass),
        ("lunar gravity", CLIPPED_CASE.replace(gravity=1.62)),
    ):
        overlap = CLIPPED_CASE.static_overlap * scaled.diameter
        case = scaled.replace(stiffness=scaled.mass * scaled.gravity / overlap)
        yield Check(
            setup=f"clipped contact, 50 steps, {name}",
            quantity="critical_angle_deg",
            unit="deg",
            measure=partial(_angle, case=case),
            expected=partial(_angle, case=CLIPPED_CASE),
            tolerance=partial(_with_digits, tolerance=SAME_MOTION, unit=1.0 / 0.0087),
            check="same k d / (m g)",
            jobs=_first_jobs(case),
        )


def _findings() -> Iterator[Check]:
    notes = {
        SOURCE_CASE: "close by cancellation: step and stiffness have errors of opposite sign",
        SOURCE_CLIPPED: "clipping the tail makes a rebound where there was none",
    }
    for case, note in notes.items():

        def measure(bench: Bench, case: Incline = case) -> Value:
            found = angle_on(bench, case)
            return Value(found.value, found.uncertainty)

        yield Check(
            setup=words(case),
            quantity="critical_angle_deg",
            unit="deg",
            measure=measure,
            expected=critical_angle(),
            tolerance=COMPARED,
            kind=Kind.FINDING,
            check="closed form",
            jobs=_first_jobs(case),
            note=note,
        )


# ---- single runs


def same_path(case: Incline, level: Level = "quick") -> Check:
    """Return the largest difference of the path of a passage from the reference's."""
    return Check(
        setup=f"{words(case)}, {case.angle:g} deg",
        quantity="largest difference of the path",
        unit="1",
        measure=partial(_path_difference, case=case),
        expected=0.0,
        tolerance=partial(_with_digits, tolerance=SAME_PATH, unit=1.0),
        level=level,
        check="reference",
        jobs=(job_of(case, "passage", EVERY),),
    )


def _path_difference(bench: Bench, case: Incline) -> float:
    """Return the largest difference of two paths, in d, sqrt(g d) and sqrt(d / g)."""
    run = read(case, "passage", bench.output(job_of(case, "passage", EVERY)), EVERY)
    other = path_in(bench.reference_output(scene_of(case, "passage", EVERY)))
    count = len(other["time_s"])
    if len(run.path["time_s"]) != count:
        raise EngineOutputError(
            f"{run.output.who} left {len(run.path['time_s'])} samples of a passage, the reference "
            f"{count}"
        )
    speed = math.sqrt(case.gravity * case.diameter)
    units = (case.unit_of_time, case.diameter, case.diameter, speed, speed)
    return max(
        float(np.abs(run.path[name] - other[name]).max()) / unit
        for name, unit in zip(COLUMNS, units, strict=True)
    )


def _worst_shock(bench: Bench) -> Value:
    """Return the largest deviation from E[j+1] = (E[j] + dE) / 4; all wells must be passed."""
    run = read(SHOCKS, "steady", bench.output(job_of(SHOCKS, "steady")))
    if run.crest_margins.size < SHOCKS.wells:
        return Value(math.inf, note=f"it passed {run.crest_margins.size} wells of {SHOCKS.wells}")
    measured = run.crest_margins + well_depth(SHOCKS.angle)
    expected = energies(float(measured[0]), measured.size - 1, SHOCKS.angle, SHOCK)
    return Value(float(np.abs(measured[1:] - expected).max()))


def _worst_crest(bench: Bench) -> float:
    """Return the largest difference of the margin at the first crests from the reference's."""
    runs = [
        read(SHOCKS, "steady", output)
        for output in (
            bench.output(job_of(SHOCKS, "steady")),
            bench.reference_output(scene_of(SHOCKS, "steady")),
        )
    ]
    margins = [run.crest_margins[:FIRST_CRESTS] for run in runs]
    if any(len(some) < FIRST_CRESTS for some in margins):
        return math.inf
    return float(np.abs(margins[0] - margins[1]).max())


def _margin(bench: Bench, case: Incline) -> float:
    return read(case, "passage", bench.output(job_of(case, "passage"))).margin


def _margin_of_twin(bench: Bench, case: Incline) -> float:
    try:
        twin = bench.engine.twin()
    except EngineMissingError as error:
        raise Unsupported(str(error)) from None
    if twin is None:
        raise Unsupported("there is no other way to run it here")
    with twin:
        return _margin(Bench(twin), case)


def _with_digits(bench: Bench, tolerance: Tolerance, unit: float) -> Tolerance:
    """Return a tolerance with the error of the digits that an engine writes, times ``unit``."""
    digits = bench.engine.traits.digits
    error = 1.25 * 10.0 ** (1 - digits) * unit
    if error <= 0.1 * tolerance.absolute:
        return tolerance
    return Tolerance(tolerance.absolute + error, reason=f"{tolerance.reason}; {digits} digits")
