"""What columns are held against: the incline, the reference DEM, and the limit of stiff ones."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from harness.cases.columns.evidence import Angles, damped_angles, damped_cases, elastic_angles
from harness.cases.columns.parameters import Columns
from harness.cases.columns.runs import critical_angle, run_columns
from harness.cases.columns.template import job_of
from harness.cases.columns.tolerances import FIRST_ORDER, ONE, RIGID, TWO_CODES
from harness.cases.contract import LevelName, Study
from harness.cases.incline.extrapolation import step_limit
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun
from harness.cases.incline.runs import run_inclines
from harness.cases.parts import Part
from harness.cases.runs import complete
from harness.cases.source_angles import READINGS
from harness.comparison.convergence import limit
from harness.comparison.verdicts import Check, Kind, finding, judge, not_tested
from harness.engines.contract import Engine
from harness.engines.parallel import cores, parallel_map
from harness.engines.reference.engine import Reference
from harness.errors import EngineOutputError
from harness.parameters.contact import PLASTIC, SOURCE
from harness.parameters.tower import LAWS
from harness.theory.critical_angle import critical_angle as closed_form

EVERY = 50
ORDERED = 1e6
"""[N/m] at which the order in the step is looked at: soft columns jitter more."""

ANGLE = 10.6
STEPS = (100.0, 200.0, 400.0, 800.0)
RAMP: dict[LevelName, tuple[float, ...]] = {
    "quick": (),
    "default": tuple(10.0 ** (4.5 + 0.5 * i) for i in range(5)),
    "full": tuple(10.0 ** (5.0 + 0.5 * i) for i in range(5)),
}


def engine_parts(engine: Engine) -> list[Part]:
    """Return the parts that need an engine, with the rows that each leaves."""
    ones = [Part("one particle", partial(_one_particle, engine), 1)]
    return ones + [Part(f"{law} law", partial(_two_codes, engine, law), 2) for law in LAWS]


def own_parts(study: Study, angles: Angles) -> list[Part]:
    """Return the parts of this package's own solvers; the angles go to ``angles``."""
    parts = [Part("angles", lambda: list(_angles(study.level, angles)))]
    if RAMP[study.level]:
        parts.append(Part("stiff columns", lambda: list(_stiff(RAMP[study.level]))))
    return parts


def _one_particle(engine: Engine) -> list[Check]:
    """Hold the path over columns of one particle against that over the incline's row."""
    case = Columns(n=1, contact=PLASTIC, steps_per_contact=100.0, stiffness=1e5, angle=ANGLE)
    row = f"columns: n = 1, path over three wells as on the incline, {engine.title}"
    reason = engine.refuses(job_of(case, "passage"))
    if reason:
        return [not_tested(row, Kind.CROSS_CODE, reason, "m")]
    case = case.replace(wells=3)
    same = {name: getattr(case, name) for name in Incline.model_fields}
    (over,) = complete(run_columns(engine, [case], "steady", every=EVERY))
    (on,) = complete(run_inclines(engine, [Incline(**same)], "steady", every=EVERY))
    return [judge(row, Kind.CROSS_CODE, _apart(over, on), 0.0, ONE)]


def _apart(one: InclineRun, other: InclineRun) -> float:
    """Return the largest distance [m] of two paths where both have samples; at least 100."""
    if one.trajectory is None or other.trajectory is None:
        raise EngineOutputError("a run left no path")
    rows = min(one.trajectory.x_m.size, other.trajectory.x_m.size)
    if rows < 100:
        raise EngineOutputError(f"the paths have {rows} samples in common: 100 are needed")
    a, b = one.trajectory, other.trajectory
    return float(np.hypot(a.x_m[:rows] - b.x_m[:rows], a.y_m[:rows] - b.y_m[:rows]).max())


def _two_codes(engine: Engine, law: str) -> list[Check]:
    """Hold the margins of passages over three particles against the reference DEM's."""
    rows, own = [], Reference()
    for inside in ("damped", "elastic"):
        # soft and with the source's contact: an external force costs a millisecond a step
        case = Columns(
            n=3, law=law, inside=inside, contact=SOURCE, stiffness=2e3, angle=ANGLE
        )  # fmt: skip
        row = f"columns: n = 3, {law} law, {inside}, margin against reference DEM, {engine.title}"
        reason = engine.refuses(job_of(case, "passage"))
        if reason:
            rows.append(not_tested(row, Kind.CROSS_CODE, reason, "m g d"))
            continue
        (theirs,) = complete(run_columns(engine, [case], "passage"))
        (ours,) = complete(run_columns(own, [case], "passage"))
        rows.append(judge(row, Kind.CROSS_CODE, theirs.margin, ours.margin, TWO_CODES))
    return rows


def _angles(level: LevelName, angles: Angles) -> Iterator[Check]:
    """Find the angles of a level and yield the highest columns' beside the source's."""
    engine = Reference()
    angles.found += damped_angles(damped_cases(level), engine)
    angles.found += elastic_angles(level, engine)
    for law in LAWS:
        for inside in ("damped", "elastic"):
            found = angles.of(law=law, inside=inside)
            if not found:
                continue
            top = max(found, key=lambda angle: (angle.n, angle.stiffness))
            for reading, words in READINGS.items():
                yield finding(
                    f"columns: n = {top.n}, {law} law, {inside}, against the source ({words})",
                    top.value_deg,
                    top.source_deg[reading],
                    "deg",
                    f"critical angle at k = {top.stiffness:g} N/m in the reference DEM",
                    top.uncertainty_deg,
                )


def _stiff(stiffnesses: Sequence[float]) -> Iterator[Check]:
    """Yield the order in the step, and the limit of stiff damped columns against 10.2078 deg."""
    engine = Reference()
    for law in LAWS:
        cases = [
            Columns(n=4, law=law, contact=PLASTIC, stiffness=k, steps_per_contact=steps)
            for k in reversed(stiffnesses)  # the costliest first
            for steps in reversed(STEPS)
        ]
        angles = parallel_map(partial(critical_angle, engine=engine, phases=4), cases, cores())
        at = {k: step_limit([a for a in angles if a.case.stiffness == k]) for k in stiffnesses}
        row = f"columns: n = 4, {law} law, order in the step of the critical angle"
        yield judge(row, Kind.ANALYTIC, at[ORDERED].order, 1.0, FIRST_ORDER)
        rigid = limit(
            [1.0 / k for k in at],
            [one.value for one in at.values()],
            [one.uncertainty for one in at.values()],
            (0.5, 1.0, 1.5),
        )
        row = f"columns: n = 4, {law} law, damped, critical angle of stiff columns"
        yield judge(
            row, Kind.ANALYTIC, rigid.value, closed_form(), RIGID, uncertainty=rigid.uncertainty
        )
