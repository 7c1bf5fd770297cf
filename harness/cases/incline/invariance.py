"""The same motion in other units, and run in another way."""

from __future__ import annotations

from harness.cases.incline.critical_angles import critical_angle
from harness.cases.incline.evidence import Verifying
from harness.cases.incline.levels import SOURCE_CASE
from harness.cases.incline.parameters import Incline
from harness.cases.incline.runs import measured
from harness.cases.incline.tolerances import SCALES, TWO_WAYS
from harness.cases.runs import whole
from harness.comparison.verdicts import Check, Kind, judge, not_tested
from harness.errors import EngineMissingError, RequestError


def scales(verifying: Verifying) -> list[Check]:
    """Hold critical angles at the same k d/(m g) in other units against one another."""
    base, rows = SOURCE_CASE, []
    glass = base.replace(diameter=3e-3, density=2500.0, stiffness=1.0e6)
    others = {
        "3 mm glass": _same_rigidity(glass, base),
        "lunar gravity": _same_rigidity(base.replace(gravity=1.62), base),
    }
    for number, (name, case) in enumerate(others.items(), 1):
        row = f"incline: scale invariance, {name}"
        rows += verifying.untested(row, base) or [_scaled(verifying, row, case, base)]
        verifying.study.progress("scale invariance", number, len(others))
    return rows


def _scaled(verifying: Verifying, row: str, case: Incline, base: Incline) -> Check:
    reference = whole(verifying.angle(base))
    angle = critical_angle(case, engine=verifying.engine)
    value, stated = angle.value_deg, angle.uncertainty_deg
    return judge(row, Kind.CROSS_CODE, value, reference.value_deg, SCALES, uncertainty=stated)


def _same_rigidity(case: Incline, base: Incline) -> Incline:
    """Return a case with the stiffness that keeps k d / (m g) of the base."""
    return case.replace(stiffness=case.mass * case.gravity / (base.static_overlap * case.diameter))


def two_ways(verifying: Verifying) -> list[Check]:
    """Hold a run against the same installation run in its other way, where it has one."""
    name = "incline: in-process against executable, energy margin"
    case = SOURCE_CASE.replace(angle=10.0)
    refused = verifying.refusal(case)
    try:
        twin = None if refused else verifying.engine.twin()
        if twin is None:
            reason = refused or f"{verifying.who} has no other way to be run here"
            return [not_tested(name, Kind.CROSS_CODE, reason, "J")]
        with twin:
            other = measured(twin, [case], "passage")[0]
    except (EngineMissingError, RequestError) as error:
        return [not_tested(name, Kind.CROSS_CODE, str(error), "J")]
    own = measured(verifying.engine, [case], "passage")[0]
    return [judge(name, Kind.CROSS_CODE, own.margin_J, other.margin_J, TWO_WAYS)]
