"""An engine on the incline, held against the closed form and against itself."""

from __future__ import annotations

from functools import partial

from harness.cases.contract import Part, rows_of_parts
from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.critical_angles import complete, critical_angle, critical_angles
from harness.cases.incline.evidence import Verifying
from harness.cases.incline.extrapolation import extrapolate
from harness.cases.incline.invariance import scales, two_ways
from harness.cases.incline.levels import SOURCE_CASE, SOURCE_CLIPPED
from harness.cases.incline.parameters import Incline
from harness.cases.incline.passage import PHASES
from harness.cases.incline.passages import passages
from harness.cases.incline.records import angle_case, extrapolated_case, in_phases
from harness.cases.incline.recursion import recursion
from harness.cases.incline.reference_checks import MOTION_EVERY, against_the_reference
from harness.cases.incline.runs import run_inclines
from harness.cases.incline.tolerances import EXTRAPOLATED, MOST_ROUTE_JITTER
from harness.comparison.findings import Headline
from harness.comparison.tolerances import Tolerance
from harness.comparison.verdicts import Check, Kind, failed_run, finding, judge, not_tested
from harness.errors import EngineError
from harness.parameters.contact import PLASTIC

NEAR_CRITICAL_DEG = (10.20, 10.22)
"""The two angles of the source's velocity figure: trapped and moving."""

HEADLINE = "critical angle of the frictionless incline"


def incline_checks(verifying: Verifying) -> list[Check]:
    """Run the incline in an engine and return its checks; fill in findings and evidence.

    A part whose engine dies becomes a failed row; the other parts go on.
    """
    parts: list[Part] = [
        ("extrapolation", partial(_extrapolation, verifying)),
        ("source's and clipped contact", partial(_beside, verifying)),
        ("the source's contact and its tail", partial(_tails, verifying)),
        ("two routes", partial(_routes, verifying)),
        ("energy after each shock", partial(recursion, verifying)),
        ("motion near the critical angle", partial(_motions, verifying)),
        ("scale invariance", partial(scales, verifying)),
        ("two ways to run it", partial(two_ways, verifying)),
        ("passages at a fixed angle", partial(passages, verifying)),
        ("against the reference DEM", partial(against_the_reference, verifying)),
    ]
    return rows_of_parts("incline", parts, "deg")


def _extrapolation(verifying: Verifying) -> list[Check]:
    name = f"incline: critical angle, {verifying.who} extrapolated"
    cases = verifying.level.ladder.cases(Incline(contact=PLASTIC))
    refused = verifying.refusal(cases[0])
    if refused:
        return [not_tested(name, Kind.ANALYTIC, refused, "deg")]
    found_or_died = critical_angles(
        cases,
        verifying.engine,
        stage="plastic contact, extrapolation",
        progress=verifying.study.progress,
    )
    verifying.keep(cases, found_or_died, PHASES)
    angles = complete(found_or_died)
    evidence = verifying.evidence
    evidence.by_contact[PLASTIC.name] = angles
    evidence.extrapolated = found = extrapolate(angles)
    verifying.found.records.append(extrapolated_case(found, angles))
    expected = evidence.closed_form_deg
    verifying.found.headlines.append(
        Headline(
            HEADLINE,
            "deg",
            expected,
            found.value_deg,
            found.uncertainty_deg,
            verifying.who,
            "plastic contact, step to zero, then stiffness to infinity",
        )
    )
    value, stated = found.value_deg, found.uncertainty_deg
    cap = EXTRAPOLATED.absolute
    why = "the stated interval contains the closed form and is no wider than the tolerance"
    return [
        judge(name, Kind.ANALYTIC, value, expected, EXTRAPOLATED, uncertainty=stated),
        judge(
            "incline: the stated uncertainty holds the closed form",
            Kind.ANALYTIC,
            value,
            expected,
            Tolerance("deg", min(stated, cap), 0.0, why),
            uncertainty=stated,
        ),
    ]


def _beside(verifying: Verifying) -> list[Check]:
    level = verifying.level
    rows: list[Check] = []
    cases: list[Incline] = []
    for case in level.beside():
        refused = verifying.refusal(case)
        if refused:
            rows.append(not_tested(_cell_name(case), Kind.CROSS_CODE, refused, "deg"))
        else:
            cases.append(case)
    angles = critical_angles(
        cases,
        verifying.engine,
        phases=level.phases_beside,
        stage="source's and clipped contact",
        progress=verifying.study.progress,
    )
    verifying.keep(cases, angles, level.phases_beside)
    for case, angle in zip(cases, angles, strict=True):
        if isinstance(angle, EngineError):
            rows.append(failed_run(_cell_name(case), Kind.CROSS_CODE, angle, "deg"))
        else:
            verifying.evidence.by_contact.setdefault(case.contact.name, []).append(angle)
    return rows


def _cell_name(case: Incline) -> str:
    return (
        f"incline: {case.contact.name}, k = {case.stiffness:g} N/m, "
        f"{case.steps_per_contact:g} steps"
    )


def _tails(verifying: Verifying) -> list[Check]:
    """Return the findings on the source's contact at its own step, tail kept and clipped."""
    cut = SOURCE_CASE.replace(contact=SOURCE_CLIPPED)
    for case in (cut, SOURCE_CASE):
        refused = verifying.refusal(case)
        if refused:
            return [not_tested(_cell_name(case), Kind.CROSS_CODE, refused, "deg")]
    clipped, kept = (critical_angle(case, engine=verifying.engine) for case in (cut, SOURCE_CASE))
    verifying.found.records += [angle_case(angle, in_phases(PHASES)) for angle in (clipped, kept)]
    return [_bias(kept, verifying.evidence.closed_form_deg), _clipping(clipped, kept)]


def _bias(angle: CriticalAngle, closed_form: float) -> Check:
    return finding(
        "incline: the source's contact at k = 1e6 N/m, 50 steps",
        angle.value_deg,
        closed_form,
        "deg",
        "close by cancellation of step and stiffness bias, not by convergence",
        angle.uncertainty_deg,
    )


def _clipping(clipped: CriticalAngle, kept: CriticalAngle) -> Check:
    return finding(
        "incline: the same with the attractive tail clipped",
        clipped.value_deg,
        kept.value_deg,
        "deg",
        "held against the unclipped contact: clipping puts a rebound where there was none",
        clipped.uncertainty_deg + kept.uncertainty_deg,
    )


def _routes(verifying: Verifying) -> list[Check]:
    level, progress, engine = verifying.level, verifying.study.progress, verifying.engine
    rows = []
    for number, case in enumerate(level.routes, 1):
        name = f"incline: steady against passage, {case.contact.name} contact"
        progress("passage against steady", number - 1, len(level.routes))
        refused = verifying.refusal(case)
        if refused:
            rows.append(not_tested(name, Kind.CROSS_CODE, refused, "deg"))
            continue
        passage = critical_angle(case, method="passage", engine=engine)
        steady = critical_angle(
            case, method="steady", tolerance_deg=level.steady_tolerance_deg, engine=engine
        )
        verifying.evidence.routes += [passage, steady]
        verifying.found.records += [
            angle_case(passage, in_phases(PHASES)),
            angle_case(steady, f"{level.steady_tolerance_deg:g}-deg"),
        ]
        stated = steady.uncertainty_deg + passage.uncertainty_deg
        cap = level.steady_tolerance_deg + MOST_ROUTE_JITTER
        why = (
            "passage and steady must agree within the sum of their uncertainties, and within the "
            f"resolution of the search and the jitter of a contact's begin, {cap:g} deg"
        )
        width = Tolerance("deg", min(stated, cap), 0.0, why)
        value, expected = steady.value_deg, passage.value_deg
        rows.append(judge(name, Kind.CROSS_CODE, value, expected, width, uncertainty=stated))
        progress("passage against steady", number, len(level.routes))
    return rows


def _motions(verifying: Verifying) -> list[Check]:
    name = "incline: motion near the critical angle"
    refused = verifying.refusal(SOURCE_CASE, "steady")
    if refused:
        return [not_tested(name, Kind.CROSS_CODE, refused)]
    cases = [SOURCE_CASE.replace(angle=angle, wells=20) for angle in NEAR_CRITICAL_DEG]
    for run in run_inclines(verifying.engine, cases, "steady", every=MOTION_EVERY):
        if isinstance(run, EngineError):
            raise run
        verifying.evidence.motions.append(run)
    return []
