"""An engine on the incline, held against the closed form and against itself."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from harness.cases.contract import LevelName, Study
from harness.cases.incline.critical_angles import critical_angle, critical_angles, side_by_side
from harness.cases.incline.evidence import (
    InclineEvidence,
    Verifying,
    angle_case,
    extrapolated_case,
    in_phases,
)
from harness.cases.incline.extrapolation import extrapolate
from harness.cases.incline.levels import SOURCE_CASE, SOURCE_CLIPPED
from harness.cases.incline.parameters import Incline
from harness.cases.incline.passage import PHASES
from harness.cases.incline.reference_checks import MOTIONS, against_the_reference, reference_parts
from harness.cases.incline.reference_paths import MOTION_EVERY
from harness.cases.incline.runs import run_inclines
from harness.cases.incline.single_runs import (
    CASES,
    RECURSION_CASE,
    passages,
    recursion,
    scales,
    two_ways,
)
from harness.cases.incline.tolerances import EXTRAPOLATED, MOST_ROUTE_JITTER
from harness.cases.parts import Part, rows_of_parts
from harness.cases.runs import complete, whole
from harness.comparison.findings import Findings, Headline
from harness.comparison.tolerances import Tolerance
from harness.comparison.verdicts import Check, Kind, failed_run, finding, judge
from harness.engines.contract import Engine
from harness.engines.parallel import parallel_map
from harness.errors import EngineError
from harness.parameters.contact import PLASTIC

TAILS = (SOURCE_CASE.replace(contact=SOURCE_CLIPPED), SOURCE_CASE)
"""The source's contact at its own step, tail clipped and kept."""

HEADLINE = "critical angle of the frictionless incline"


def incline_checks(verifying: Verifying) -> list[Check]:
    """Run the incline in an engine and return its checks; fill in findings and evidence.

    A part whose engine dies becomes a failed row; the other parts go on. The angles over stiffness
    and step fill the cores; beside them go the other runs, many of which wait for one another.
    """
    lanes = [replace(verifying, found=Findings("incline")) for _ in range(2)]
    parts = [_angle_parts(lanes[0]), _other_parts(lanes[1])]
    rows = parallel_map(partial(rows_of_parts, "incline", unit="deg"), parts, len(lanes))
    for lane in lanes:
        verifying.found.add(lane.found)
    return [*rows[0], *rows[1], *rows_of_parts("incline", [_last_part(verifying)], "deg")]


def expected_rows(level: LevelName, engine: Engine) -> int:
    """Return how many rows a level leaves for an engine; one for each run that it refuses."""
    plan = Verifying(engine, Study(level), Findings("incline"), InclineEvidence(engine.title, 0.0))
    parts = (*_angle_parts(plan), *_other_parts(plan), _last_part(plan))
    return sum(part.rows for part in parts)


def _angle_parts(verifying: Verifying) -> list[Part]:
    part, beside = verifying.part, verifying.level.beside()
    plastic = not verifying.refusal(Incline(contact=PLASTIC))
    return [
        part("extrapolation", _extrapolation, 1 + plastic),
        part("source's and clipped contact", _beside, len(beside) - len(verifying.stated(beside))),
    ]


def _other_parts(verifying: Verifying) -> list[Part]:
    part, refusal = verifying.part, verifying.refusal
    tails, shocks = not any(map(refusal, TAILS)), not refusal(RECURSION_CASE, "steady")
    return [
        part("the source's contact and its tail", _tails, 1 + tails),
        part("two routes", _routes, len(verifying.level.routes)),
        part("energy after each shock", recursion, 1 + shocks),
        part("motion near the critical angle", _motions, bool(refusal(SOURCE_CASE, "steady"))),
        part("scale invariance", scales, 2),
        part("two ways to run it", two_ways, 1),
        part("passages at a fixed angle", passages, len(CASES) - len(verifying.stated(CASES))),
    ]


def _last_part(verifying: Verifying) -> Part:
    rows = sum(part.rows for part in reference_parts(verifying))
    return verifying.part("against the reference DEM", against_the_reference, rows)


def _extrapolation(verifying: Verifying) -> list[Check]:
    name = f"incline: critical angle, {verifying.who} extrapolated"
    cases = verifying.level.ladder.cases(Incline(contact=PLASTIC))
    untested = verifying.untested(name, cases[0], kind=Kind.ANALYTIC)
    if untested:
        return untested
    stage, progress = "plastic contact, extrapolation", verifying.study.progress
    found_or_died = side_by_side(verifying.angle, cases, stage, progress)
    verifying.keep(cases, found_or_died, PHASES)
    angles = complete(found_or_died)
    evidence = verifying.evidence
    evidence.by_contact[PLASTIC.name] = angles
    evidence.extrapolated = found = extrapolate(angles)
    verifying.found.records.append(extrapolated_case(found, angles))
    expected = evidence.closed_form_deg
    how = "plastic contact, step to zero, then stiffness to infinity"
    value, stated = found.value_deg, found.uncertainty_deg
    headline = Headline(HEADLINE, "deg", expected, value, stated, verifying.who, how)
    verifying.found.headlines.append(headline)
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
    level, asked = verifying.level, verifying.level.beside()
    rows = [row for case in asked for row in verifying.untested(_cell_name(case), case)]
    cases = verifying.stated(asked)
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
    for case in TAILS:
        untested = verifying.untested(_cell_name(case), case)
        if untested:
            return untested
    clipped, kept = complete(map(verifying.angle, TAILS))
    verifying.found.records += [angle_case(angle, in_phases(PHASES)) for angle in (clipped, kept)]
    return [
        finding(
            "incline: the source's contact at k = 1e6 N/m, 50 steps",
            kept.value_deg,
            verifying.evidence.closed_form_deg,
            "deg",
            "close by cancellation of step and stiffness bias, not by convergence",
            kept.uncertainty_deg,
        ),
        finding(
            "incline: the same with the attractive tail clipped",
            clipped.value_deg,
            kept.value_deg,
            "deg",
            "held against the unclipped contact: clipping puts a rebound where there was none",
            clipped.uncertainty_deg + kept.uncertainty_deg,
        ),
    ]


def _routes(verifying: Verifying) -> list[Check]:
    progress, cases = verifying.study.progress, verifying.level.routes
    rows = []
    for number, case in enumerate(cases, 1):
        progress("passage against steady", number - 1, len(cases))
        name = f"incline: steady against passage, {case.contact.name} contact"
        rows += verifying.untested(name, case) or [_route(verifying, name, case)]
        progress("passage against steady", number, len(cases))
    return rows


def _route(verifying: Verifying, name: str, case: Incline) -> Check:
    """Hold the critical angle by steady motion against that by passage."""
    resolution, engine = verifying.level.steady_tolerance_deg, verifying.engine
    passage = whole(verifying.angle(case))
    steady = critical_angle(case, method="steady", tolerance_deg=resolution, engine=engine)
    verifying.evidence.routes += [passage, steady]
    verifying.found.records += [
        angle_case(passage, in_phases(PHASES)),
        angle_case(steady, f"{resolution:g}-deg"),
    ]
    stated = steady.uncertainty_deg + passage.uncertainty_deg
    cap = resolution + MOST_ROUTE_JITTER
    why = (
        "passage and steady must agree within the sum of their uncertainties, and within the "
        f"resolution of the search and the jitter of a contact's begin, {cap:g} deg"
    )
    width = Tolerance("deg", min(stated, cap), 0.0, why)
    value, expected = steady.value_deg, passage.value_deg
    note = f"passage: {passage.phases_note}"
    return judge(name, Kind.CROSS_CODE, value, expected, width, uncertainty=stated, note=note)


def _motions(verifying: Verifying) -> list[Check]:
    name = "incline: motion near the critical angle"
    untested = verifying.untested(name, SOURCE_CASE, "steady", "")
    if untested:
        return untested
    for run in run_inclines(verifying.engine, MOTIONS, "steady", every=MOTION_EVERY):
        verifying.evidence.motions.append(whole(run))
    return []
