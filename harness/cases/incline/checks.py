"""Checks of the incline: what is measured, against what, how close and why so close.

The reference takes the same steps under the conventions of the engine: it differs by round-off.
Theory is for rigid grains, in the limit of stiffness and step. Steady motion is the second,
independent way to the angle. What another check decides already is of level full: it takes minutes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any

import numpy as np

from harness.cases.base import COLUMNS, LEVELS, Check, Value, path_in
from harness.cases.bench import Bench
from harness.cases.checks import with_digits
from harness.cases.incline import search
from harness.cases.incline.angle import friction_text
from harness.cases.incline.closed_form import rigid_angle
from harness.cases.incline.runs import job_of, read, scene_of
from harness.cases.incline.system import Incline, Route
from harness.engines.base import Engine, Job
from harness.errors import Unsupported
from harness.model.law import CLIPPED, PLASTIC, SOURCE
from harness.report.content import power
from harness.results.rows import Kind, Level, Tolerance
from harness.theory.chain import SHOCK_WITHOUT_REBOUND as SHOCK
from harness.theory.incline import critical_angle, energies, well_depth

EVERY = 10  # steps between the samples of a path
PATH_ANGLE = 10.2  # [deg] just below the critical angle: the margin is small, and shows a change
SLOW_MICROSECONDS = 5.0  # of a step, from which an engine has fewer checks of many runs
FIRST_CRESTS = 5
SLOPE = 0.0087  # [m g d / deg] of the margin

PLASTIC_CASE = Incline(contact=PLASTIC, steps_per_contact=100.0)
SOURCE_CASE = Incline(contact=SOURCE, steps_per_contact=50.0)
CLIPPED_CASE = Incline(contact=CLIPPED, steps_per_contact=50.0)
CASES = (PLASTIC_CASE, SOURCE_CASE, CLIPPED_CASE)
SOURCE_CLIPPED = SOURCE_CASE.replace(contact=SOURCE.replace(name="clipped source", tail="clipped"))
SHOCKS = PLASTIC_CASE.replace(steps_per_contact=200.0, angle=10.6)

# a grain with friction, or of another size
ROLLING = PLASTIC_CASE.replace(friction=0.5)
DISC, LARGE = ROLLING.replace(shape="disc"), PLASTIC_CASE.replace(grain_diameter=2.0)
SLIDING = PLASTIC_CASE.replace(friction=0.1)
SLIGHT = PLASTIC_CASE.replace(friction=0.016)  # the highest critical angle
# of the curve at 50 steps: where the angle is of the order k^(-1/2), and where it is not
SLIGHT_FRICTIONS, FRICTIONS = (0.005, 0.016, 0.03), (0.05, 0.1, 0.2, 0.35, 0.5)
DEFAULT_FRICTIONS = (0.016, 0.1, 0.5)

SCALED: dict[str, dict[str, float]] = {  # the same motion in other units
    "3 mm glass": {"diameter": 3e-3, "density": 2500.0},
    "lunar gravity": {"gravity": 1.62},
}

COMPARED = Tolerance(reason="compared, not judged")
SAME_STEPS = Tolerance(
    1e-8,
    reason="the same steps in two codes: round-off of 1e-15 in some 1e5 steps, over the slope "
    "0.01 m g d per deg; measured below 1e-11 deg",
)
SAME_PATH = Tolerance(
    1e-10,
    reason="the same steps in two codes: round-off of 1e-15, times 20 at the shock, and in a "
    "velocity times the rate of the contact, 3e2; measured below 1e-11",
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
    for level in LEVELS[: LEVELS.index(longest) + 1]:
        of_level = {"quick": _quick, "default": _default, "full": _full}[level]
        yield from (replace(check, level=level) for check in of_level(engine))


def _quick(engine: Engine) -> Iterator[Check]:
    if engine.traits.microseconds_per_step < SLOW_MICROSECONDS:
        yield limit_check(PLASTIC_CASE, search.QUICK_LADDER, 1e-3)
    for case in (*CASES, ROLLING, SLIDING):
        yield same_angle(case)
        yield same_path(near_critical(case) if case.friction else case.replace(angle=PATH_ANGLE))
    yield routes(SOURCE_CASE)
    yield from _shock_checks()
    for name, changes in SCALED.items():
        yield _same_units(name, CLIPPED_CASE.replace(**changes))
    for case, note in (
        (SOURCE_CASE, "close by cancellation: step and stiffness have errors of opposite sign"),
        (SOURCE_CLIPPED, "clipping the tail makes a rebound where there was none"),
    ):
        yield angle_check(case, expected=critical_angle(), kind=Kind.FINDING, tolerance=COMPARED,
                          check="closed form", note=note)  # fmt: skip


def _default(engine: Engine) -> Iterator[Check]:
    if engine.traits.microseconds_per_step < SLOW_MICROSECONDS:
        yield limit_check(PLASTIC_CASE, search.Ladder(), 3e-4)
        yield from _friction_curve(engine, "default")
    for case in CASES:
        for stiffness in (1e5, 1e7):
            yield same_angle(case.replace(stiffness=stiffness))
    yield from (same_path(near_critical(case)) for case in (DISC, LARGE))


def _full(engine: Engine) -> Iterator[Check]:
    """Yield also limits and steady motion of other grains, which shorter levels decide for one."""
    yield from (same_angle(case) for case in (DISC, LARGE))
    if engine.traits.microseconds_per_step >= SLOW_MICROSECONDS:
        yield limit_check(PLASTIC_CASE, search.QUICK_LADDER, 1e-3)
        return
    yield from _friction_curve(engine, "full")
    for case, ladder, width in (
        (PLASTIC_CASE, search.FULL_LADDER, 3e-4),
        (ROLLING, search.QUICK_LADDER, 1e-3),
        (ROLLING, search.FULL_LADDER, 3e-4),
        (LARGE, search.Ladder(), 5e-4),
        (DISC, search.Ladder(), 3e-4),
        (SLIGHT, search.Ladder(), 2e-3),
    ):
        yield limit_check(case, ladder, width)
    yield routes(PLASTIC_CASE, 1e-3)
    yield routes(ROLLING.replace(steps_per_contact=50.0))


def _friction_curve(engine: Engine, level: Level) -> Iterator[Check]:
    """Yield the course over friction; where a dashpot is not limited its angles are findings."""
    coulomb = limits_dashpot(engine)
    for friction in (*SLIGHT_FRICTIONS, *FRICTIONS):
        judged = friction in FRICTIONS and coulomb
        first = friction in DEFAULT_FRICTIONS and (judged or friction == SLIGHT.friction)
        if first is (level == "default"):
            yield against_theory(friction_case(friction), judged=judged)


def limits_dashpot(engine: Engine) -> bool:
    """Return whether Coulomb's limit is one for spring and dashpot together, as in theory.

    Otherwise a strongly damped grain sticks beyond the limit: -0.06 deg at a friction of 0.05.
    """
    try:
        rules = engine.rules(scene_of(SLIDING, "passage"))
    except Unsupported:
        return True
    return rules.damping_in_cap == "inside"


def friction_case(friction: float) -> Incline:
    """Return a case of the curve over friction."""
    return PLASTIC_CASE.replace(friction=friction, steps_per_contact=50.0)


def near_critical(case: Incline) -> Incline:
    """Return a case at its critical angle, to a hundredth of a degree."""
    return case.replace(angle=round(rigid_angle(case)[0], 2))


def words(case: Incline) -> str:
    """Return contact, stiffness, step and friction of a case for a setup."""
    contact, k = case.contact.name, power(case.stiffness)
    steps = f"{case.steps_per_contact:g} steps"
    return f"{contact} contact, k = {k} N/m, {steps}{friction_text(case)}"


# ---- critical angles


def angle_check(
    case: Incline, method: Route = "passage", resolution_deg: float | None = None, **how: Any
) -> Check:
    """Return a check of the critical angle of a case."""

    def measure(bench: Bench) -> Value:
        angle = search.angle_on(bench, case, method, resolution_deg)
        return Value(angle.value, angle.uncertainty, angle.note)

    return Check(**{"setup": words(case), "quantity": "critical_angle_deg", "unit": "deg",
                    "measure": measure, "jobs": first_jobs(case, method), **how})  # fmt: skip


def limit_check(case: Incline, ladder: search.Ladder, width: float) -> Check:
    """Return the angle of rigid grains, step to zero and stiffness to infinity, against theory."""
    stiffnesses = [case.stiffness * factor for factor in ladder.factors]
    setup = (
        f"{case.contact.name} contact{friction_text(case)}, step to zero, k from "
        f"{power(min(stiffnesses))} to {power(max(stiffnesses))} N/m and on to infinity"
    )

    def measure(bench: Bench) -> Value:
        angle = search.extrapolated_on(bench, ladder, case)
        return Value(angle.value, angle.uncertainty)

    tolerance = Tolerance(width, reason="the last corrections that the ladder resolves")
    return angle_check(case, setup=setup, measure=measure, expected=rigid_angle(case)[0],
                       tolerance=tolerance, kind=Kind.ANALYTIC,
                       jobs=ladder_jobs(case, ladder))  # fmt: skip


def same_angle(case: Incline) -> Check:
    """Return the angle of a case against the reference at equal steps."""
    return angle_check(case, measure=partial(_angle, case=case), check="reference",
                       expected=partial(_reference_angle, case=case),
                       tolerance=partial(with_digits, SAME_STEPS, 1.0 / SLOPE))  # fmt: skip


def against_theory(case: Incline, *, judged: bool) -> Check:
    """Return the angle of a case against that of a rigid grain, as a finding unless judged."""
    expected, model = rigid_angle(case)
    tolerance, kind = (FRICTION_CURVE, Kind.ANALYTIC) if judged else (COMPARED, Kind.FINDING)
    return angle_check(case, expected=expected, tolerance=tolerance, kind=kind,
                       check="rigid grain", note=model)  # fmt: skip


def routes(case: Incline, resolution_deg: float | None = None) -> Check:
    """Return the angle by steady motion against the one by passage."""
    return angle_check(case, "steady", resolution_deg, expected=partial(_angle, case=case),
                       tolerance=ROUTES, check="steady motion against passage")  # fmt: skip


def _same_units(name: str, scaled: Incline) -> Check:
    """Return the angle of the same k d / (m g) in other units."""
    overlap = CLIPPED_CASE.static_overlap * scaled.diameter
    case = scaled.replace(stiffness=scaled.weight / overlap)
    return angle_check(case, setup=f"clipped contact, 50 steps, {name}", check="same k d / (m g)",
                       measure=partial(_angle, case=case),
                       expected=partial(_angle, case=CLIPPED_CASE),
                       tolerance=partial(with_digits, SAME_MOTION, 1.0 / SLOPE))  # fmt: skip


def _angle(bench: Bench, case: Incline) -> float:
    return search.angle_on(bench, case).value


def _reference_angle(bench: Bench, case: Incline) -> float:
    return search.search(search.reference_measure(bench, "passage"), case, "passage").value


def ladder_jobs(case: Incline, ladder: search.Ladder) -> tuple[Job, ...]:
    """Return the first jobs of the searches of an extrapolation."""
    return tuple(job for refined in ladder.cases(case) for job in first_jobs(refined))


@lru_cache(maxsize=256)
def first_jobs(case: Incline, route: Route = "passage") -> tuple[Job, ...]:
    """Return the first jobs of a search, with the steps that the search is expected to take."""
    case = search.prepared(case, route)
    jobs = [job_of(first, route) for first in search.first_cases(case, route)]
    return tuple(replace(job, steps=search.RUNS[route] / len(jobs) * job.steps) for job in jobs)


# ---- single runs


def _run_check(
    case: Incline, suffix: str = "", route: Route = "passage", *,
    measure: Callable[..., Value | float], **how: Any,
) -> Check:  # fmt: skip
    return Check(**{"setup": f"{words(case)}, {case.angle:g} deg{suffix}", "unit": "1",
                    "measure": partial(measure, case=case), "expected": 0.0,
                    "jobs": (job_of(case, route),), **how})  # fmt: skip


def same_path(case: Incline) -> Check:
    """Return the largest difference of the path of a passage from the reference's."""
    return _run_check(case, quantity="largest difference of the path", measure=_path_difference,
                      tolerance=partial(with_digits, SAME_PATH, 1.0), check="reference",
                      jobs=(job_of(case, "passage", EVERY),))  # fmt: skip


def _path_difference(bench: Bench, case: Incline) -> Value | float:
    """Return the largest difference of two paths, in d, sqrt(g d) and sqrt(d / g)."""
    output = bench.output(job_of(case, "passage", EVERY))
    reference = bench.reference_output(scene_of(case, "passage", EVERY))
    steps, due = (read(case, "passage", run).steps for run in (output, reference))
    if steps != due:
        return Value(math.inf, note=f"it takes {steps} steps over the well, the reference {due}")
    expected = path_in(reference)
    path, speed = path_in(output, len(expected["time_s"])), case.diameter / case.unit_of_time
    units = (case.unit_of_time, case.diameter, case.diameter, speed, speed)
    errors = [np.abs(path[name] - expected[name]) for name in COLUMNS]
    return float(np.max([error.max() / unit for error, unit in zip(errors, units, strict=True)]))


def _shock_checks() -> Iterator[Check]:
    """Yield the energy after each shock by theory, and at the first crests by the reference."""
    of_shocks = partial(_run_check, SHOCKS, route="steady", unit="m g d")
    yield of_shocks(quantity="largest error of the energy after each shock",
                    measure=_worst_shock, tolerance=SHOCK_ENERGY, kind=Kind.ANALYTIC)  # fmt: skip
    yield of_shocks(quantity=f"largest error of the energy at {FIRST_CRESTS} crests",
                    measure=_worst_crest, tolerance=partial(with_digits, SAME_CRESTS, 1.0),
                    check="reference")  # fmt: skip


def _worst_shock(bench: Bench, case: Incline) -> Value:
    """Return the largest deviation from E[j+1] = (E[j] + dE) / 4; all wells must be passed."""
    margins = read(case, "steady", bench.output(job_of(case, "steady"))).crest_margins
    if margins.size < case.wells:
        return Value(math.inf, note=f"it passed {margins.size} wells of {case.wells}")
    measured = margins + well_depth(case.angle)
    expected = energies(float(measured[0]), measured.size - 1, case.angle, SHOCK)
    return Value(float(np.abs(measured[1:] - expected).max()))


def _worst_crest(bench: Bench, case: Incline) -> float:
    """Return the largest difference of the margin at the first crests from the reference's."""
    outputs = bench.output(job_of(case, "steady")), bench.reference_output(scene_of(case, "steady"))
    margins = [read(case, "steady", run).crest_margins[:FIRST_CRESTS] for run in outputs]
    if any(len(some) < FIRST_CRESTS for some in margins):
        return math.inf
    return float(np.abs(margins[0] - margins[1]).max())
