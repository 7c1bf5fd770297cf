"""An engine on the incline, held against the closed form and the reference DEM.

Beside the reference DEM paths are compared sample by sample: same stiffness, step, contact and
integration, so that they may differ by round-off only. The adaptive integrator measures the error
of the integration itself.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from harness.cases.contract import LevelName
from harness.cases.grain import COLUMNS, complete, run_or_raise
from harness.cases.incline import levels
from harness.cases.incline.angle import (
    PHASES,
    CriticalAngle,
    critical_angle,
    critical_angles,
    extrapolate,
    side_by_side,
)
from harness.cases.incline.checks import (
    CASES,
    EVERY,
    RECURSION_CASE,
    SCALED,
    SHOCKS,
    WAYS_TO_RUN,
    WELLS_PASSED,
    WORST_SHOCK,
    InclineEvidence,
    Recursion,
    Stiffening,
    Verifying,
    angle_case,
    extrapolated_case,
    in_phases,
    passage_row,
    passages,
    recursion,
    restitution_checks,
    rigid_checks,
    scales,
    theory_checks,
    two_ways,
)
from harness.cases.incline.engine_checks import (
    OWN,
    EngineAngle,
    across_engines,
    angle_checks,
    reference_for,
)
from harness.cases.incline.levels import (
    EXTRAPOLATED,
    MOST_ROUTE_JITTER,
    SOURCE_CASE,
    SOURCE_CLIPPED,
)
from harness.cases.incline.runs import measured, run_inclines
from harness.cases.incline.system import (
    Incline,
    InclineRun,
    Motion,
    Route,
    energy,
    margin,
)
from harness.cases.verification import (
    Part,
    Study,
    Verification,
    planned_in,
    rows_of_parts,
)
from harness.comparison.verdicts import (
    Check,
    Kind,
    Planned,
    Tolerance,
    failed_run,
    finding,
    judge,
    not_tested,
)
from harness.comparison.verification import Findings
from harness.engines.contract import Engine
from harness.engines.process import parallel_map
from harness.engines.reference import Reference
from harness.errors import EngineError, EngineOutputError
from harness.observables.reference import Trajectory
from harness.observables.row import Row
from harness.parameters.law import CONTACTS, PLASTIC, SOURCE
from harness.parameters.plane_scene import LOOK
from harness.theory.incline import critical_angle as closed_form

if TYPE_CHECKING:
    pass

PATH_TIME = 20.0
"""[sqrt(d/g)] over which paths are compared: rounding grows on every slow crest, by e a unit."""

MOTION_EVERY = 100
"""Steps between the samples of the motions that are compared."""

FIRST_CRESTS = 5
"""Crests over which round-off has not grown yet."""


HELD_PATH = (
    "largest distance",
    "largest velocity apart",
    "energy told and of its path",
    "largest rise of energy",
)
"""What is held against the reference DEM of every path."""

CREST_ENERGY, CREST_TIME = "energy, the worst of", "time, the worst of"
"""What is held of crests, before how many they are."""


def motion_rows(name: str, reference: Reference, run: InclineRun) -> list[Check]:
    """Hold a steady run over its first wells against the reference's: path and crests."""
    short = run.case.replace(time_limit=PATH_TIME)
    rows, expected = _path(name, run, short, reference, "steady")
    first = min(FIRST_CRESTS, expected.crests.time_s.size)
    return [*rows, *_at_crests(name, run, expected, [(first, levels.REFERENCE_FIRST_CRESTS)])]


def passage_rows(name: str, reference: Reference, run: InclineRun) -> list[Check]:
    """Hold the path of a passage against the reference's."""
    return _path(name, run, run.case, reference, "passage")[0]


def _path(
    name: str, run: InclineRun, case: Incline, reference: Reference, route: Route
) -> tuple[list[Check], InclineRun]:
    """Compare a path and its reported energy with the reference's at every sample of the plan.

    Return the rows and the reference's run.
    """
    path, every = run.trajectory, EVERY if route == "passage" else MOTION_EVERY
    if path is None:
        raise EngineOutputError("it kept no path")
    expected = run_or_raise(run_inclines(reference, [case], route, every=every)[0])
    # a code that is judged by its samples may end between two looks
    rows = expected.path.time_s.size - LOOK // every
    if expected.motion is not Motion.UNDECIDED and expected.motion is not run.motion:
        raise EngineOutputError(f"it is {run.motion} where the reference DEM is {expected.motion}")
    late = path.time_s[:rows].size < rows or not np.allclose(
        path.time_s[:rows], expected.path.time_s[:rows], rtol=0.0, atol=0.5 * case.step
    )
    if late:
        raise EngineOutputError(
            f"its path of {path.time_s.size} samples does not have the {rows} times of the plan"
        )
    x, y, vx, vy = (
        getattr(path, column)[:rows] - getattr(expected.path, column)[:rows]
        for column in ("x_m", "y_m", "vx_m_per_s", "vy_m_per_s")
    )
    apart = float(np.hypot(x, y).max()) / case.diameter
    faster = float(np.hypot(vx, vy).max()) / math.sqrt(case.gravity * case.diameter)
    near, slow = levels.REFERENCE_PATH, levels.REFERENCE_SPEED
    if route == "passage":
        near = slow = levels.REFERENCE_PASSAGE
    judged = [
        judge(f"{name}, {HELD_PATH[0]}", Kind.CROSS_CODE, apart, 0.0, near),
        judge(f"{name}, {HELD_PATH[1]}", Kind.CROSS_CODE, faster, 0.0, slow),
        _told_energy(name, run, path),
        _energy_rise(name, run, path, expected.path),
    ]
    return judged, expected


def _energy_rise(name: str, run: InclineRun, path: Trajectory, expected_path: Trajectory) -> Check:
    """Hold the largest rise of energy along the whole path against that of the reference's.

    Contacts only take energy: a wrong sample of position or velocity shows in it, also where
    round-off has grown too much for the paths to be compared.
    """
    expected_rise, rise = (_rise(run.case, motion) for motion in (expected_path, path))
    name = f"{name}, {HELD_PATH[3]}"
    return judge(name, Kind.CROSS_CODE, rise, expected_rise, levels.ENERGY_RISE)


def _rise(case: Incline, path: Trajectory) -> float:
    """Return the largest rise of energy over its lowest value before, along a path [m g d]."""
    total = energy(case, path.x_m, path.y_m, path.vx_m_per_s, path.vy_m_per_s)
    return float((total - np.minimum.accumulate(total)).max()) / case.weight_energy


def _told_energy(name: str, run: InclineRun, path: Trajectory) -> Check:
    """Compare the energy that a run reports with that of the last sample of its path."""
    case = run.case
    well = max(1, run.crests.time_s.size + (run.motion is not Motion.MOVES_ON))
    x, y, vx, vy = (float(getattr(path, column)[-1]) for column in COLUMNS[1:])
    return judge(
        f"{name}, {HELD_PATH[2]}",
        Kind.CROSS_CODE,
        run.margin,
        margin(case, well, x, y, vx, vy) / case.weight_energy,
        levels.TOLD_ENERGY,
    )


def crests_rows(name: str, reference: Reference, recursion: Recursion) -> list[Check]:
    """Hold energy and time at every crest against the reference's."""
    run = recursion.run
    (expected,) = measured(reference, [run.case], "steady")
    count = expected.crests.time_s.size
    if run.crests.time_s.size != count:
        raise EngineOutputError(
            f"it passed {run.crests.time_s.size} crests, the reference DEM {count}"
        )
    held = [(FIRST_CRESTS, levels.REFERENCE_FIRST_CRESTS), (count, levels.REFERENCE_CRESTS)]
    return _at_crests(name, run, expected, held)


def _at_crests(
    name: str, run: InclineRun, expected: InclineRun, held: Sequence[tuple[int, Tolerance]]
) -> list[Check]:
    """Return the rows of the energy at so many crests as are held, and of the time at the most."""
    count = held[-1][0]
    if run.crests.time_s.size < count:
        raise EngineOutputError(f"it passed {run.crests.time_s.size} crests of {count}")
    ours, theirs = run.crests, expected.crests
    margins = np.abs(ours.margin_J[:count] - theirs.margin_J[:count]) / run.case.weight_energy
    time = np.abs(ours.time_s[:count] - theirs.time_s[:count]) / run.case.step
    step = Tolerance("steps", 0.5, 0.0, "the same steps in two codes, counted")
    rows = [(f"{CREST_ENERGY} {some}", margins[:some], width) for some, width in held]
    return [
        judge(f"{name}, {quantity}", Kind.CROSS_CODE, float(apart.max(initial=0.0)), 0.0, width)
        for quantity, apart, width in [*rows, (f"{CREST_TIME} {count}", time, step)]
    ]


Found = TypeVar("Found")

STIFFNESSES = (1e5, 1e6, 1e7)
STEPS = {SOURCE.name: 50.0, "clipped": 50.0, PLASTIC.name: 100.0}
"""Steps per contact time at which the contacts are compared."""

MOTIONS = tuple(SOURCE_CASE.replace(angle=angle, wells=20) for angle in (10.20, 10.22))
"""At the two angles of the source's velocity figure: trapped and moving."""

ENOUGH_DIGITS = 12
"""Digits of an output below which a path says no more than a critical angle does."""


def against_the_reference(verifying: Verifying) -> list[Check]:
    """Return the rows of an engine against the reference DEM in the scheme that it declares."""
    return rows_of_parts("incline", reference_parts(verifying))


def reference_parts(verifying: Verifying) -> list[Part]:
    """Return a part for each angle and path compared, where the output has enough digits."""
    engine, reference = verifying.engine, reference_for(verifying.engine.traits)
    if engine.name == OWN or reference is None:
        reason = "the reference DEM does not have the engine's scheme"
        if engine.name == OWN:
            reason = "this is the reference DEM"
        untested = not_tested("incline: against the reference DEM", Kind.CROSS_CODE, reason)
        return [Part(untested.name, lambda: [untested], (untested.name,))]
    parts = list(_reference_angle_parts(verifying, reference))
    if engine.traits.digits >= ENOUGH_DIGITS:
        parts += _path_parts(verifying, reference)
    if verifying.level.name == "full":
        compared = any(is_compared(case, SOURCE.name, 1e6) for case in _requested_cases(verifying))
        rows = (_worth_name(verifying.engine_title),) if compared else ()
        find = partial(_angle_at, verifying.evidence, SOURCE.name, 1e6)
        worth = partial(_worth_of_the_step, verifying.engine_title)
        parts.append(_held("what the step is worth", rows, find, worth))
    return parts


def _requested_cases(verifying: Verifying) -> list[Incline]:
    """Return the cases whose angles the engine measures over stiffness and step."""
    ladder = verifying.level.ladder.cases(Incline(contact=PLASTIC))
    return verifying.supported([*ladder, *verifying.level.other_angles()])


def _reference_angle_parts(verifying: Verifying, reference: Reference) -> Iterator[Part]:
    requested, level = _requested_cases(verifying), verifying.level
    for contact, stiffness in itertools.product(CONTACTS, STIFFNESSES):
        if any(is_compared(case, contact, stiffness) for case in requested):
            name = (
                f"incline: {verifying.engine_title} against the reference DEM, {contact} contact, "
                f"k = {stiffness:.3g} N/m"
            )
            phases = PHASES if contact == PLASTIC.name else level.phases_beside
            find = partial(_angle_at, verifying.evidence, contact, stiffness)
            yield _held(name, (name,), find, partial(_reference_angle, name, reference, phases))


def _path_parts(verifying: Verifying, reference: Reference) -> Iterator[Part]:
    evidence, pair = verifying.evidence, f"{verifying.engine_title} against the reference DEM"
    if not verifying.refusal(SOURCE_CASE, "steady"):
        for case in MOTIONS:
            name = f"incline: path at {case.angle:.2f} deg, {pair}"
            find = partial(_run_of, evidence.motions, case)
            rows = [f"{name}, {held}" for held in (*HELD_PATH, CREST_ENERGY, CREST_TIME)]
            yield _held(name, rows, find, partial(motion_rows, name, reference))
    for case in verifying.supported(CASES):
        name = f"{passage_row(case)}, {pair}"
        find = partial(_run_of, evidence.passages, case)
        rows = [f"{name}, {held}" for held in HELD_PATH]
        yield _held(name, rows, find, partial(passage_rows, name, reference))
    if not verifying.refusal(RECURSION_CASE, "steady"):
        name = f"incline: crests at {RECURSION_CASE.angle:g} deg, {pair}"
        rows = [f"{name}, {held}" for held in (CREST_ENERGY, CREST_ENERGY, CREST_TIME)]
        yield _held(name, rows, lambda: evidence.recursion, partial(crests_rows, name, reference))


def _held(
    name: str,
    rows: Sequence[str],
    find: Callable[[], Found | None],
    hold: Callable[[Found], list[Check]],
) -> Part:
    """Return the part that compares an engine's result; it has no rows where the run failed."""

    def run() -> list[Check]:
        result = find()
        return [] if result is None else hold(result)

    return Part(name, run, tuple(rows))


def _run_of(runs: Sequence[InclineRun], case: Incline) -> InclineRun | None:
    return next((run for run in runs if run.case == case), None)


def _angle_at(evidence: InclineEvidence, contact: str, stiffness: float) -> CriticalAngle | None:
    angles = evidence.by_contact.get(contact, [])
    return next((angle for angle in angles if is_compared(angle.case, contact, stiffness)), None)


def is_compared(case: Incline, contact: str, stiffness: float) -> bool:
    """Return whether a case is the one of a contact and stiffness that is compared."""
    same = math.isclose(case.stiffness, stiffness, rel_tol=1e-12)
    return same and case.contact.name == contact and case.steps_per_contact == STEPS[contact]


def _reference_angle(
    name: str, reference: Reference, phases: int, angle: CriticalAngle
) -> list[Check]:
    reference_angle = critical_angle(angle.case, engine=reference, phases=phases)
    values = angle.value_deg, reference_angle.value_deg
    row = judge(name, Kind.CROSS_CODE, *values, levels.REFERENCE_ANGLE, note=angle.phases_note)
    return [row]


def _worth_name(engine_name: str) -> str:
    return f"incline: the source's contact at k = 1e6 N/m, {engine_name} against no step at all"


def _worth_of_the_step(engine_name: str, angle: CriticalAngle) -> list[Check]:
    """Report what the source's step is worth: the same contact without a step."""
    name = _worth_name(engine_name)
    exact = critical_angle(angle.case, engine=Reference("adaptive"), phases=1)
    note = "held against the adaptive reference: 50 steps per contact skip the attractive tail"
    return [finding(name, angle.value_deg, exact.value_deg, "deg", note, angle.uncertainty_deg)]


TAILS = (SOURCE_CASE.replace(contact=SOURCE_CLIPPED), SOURCE_CASE)
"""The source's contact at its own step, tail clipped and kept."""

TAIL_NAMES = (
    "incline: the source's contact at k = 1e6 N/m, 50 steps",
    "incline: the same with the attractive tail clipped",
)
INTERVAL = "incline: the stated uncertainty holds the closed form"
MOTIONS_NAME = "incline: motion near the critical angle"
HEADLINE = "critical angle of the frictionless incline"


class InclineVerification(Verification):
    """Holds an engine against the closed form, the reference DEM and itself."""

    def planned(self, level: LevelName, engine: Engine) -> Sequence[Planned]:
        """Return the checks of a level for an engine; one for each run that it refuses."""
        evidence = InclineEvidence(engine.title, 0.0)
        plan = Verifying(engine, Study(level), Findings("incline"), evidence)
        return planned_in((*_angle_parts(plan), *_other_parts(plan), _last_part(plan)))

    def run(self, engine: Engine, study: Study) -> Findings:
        """Judge angles, paths, shocks and scales of the main engine.

        Of another engine the critical angles, against theory and the reference DEM.
        """
        if study.role == "other":
            angles: list[EngineAngle] = []
            run = partial(angle_checks, engine, study, angles)
            return _other_engine(engine.name, run, angles)
        evidence = InclineEvidence(engine.title, closed_form())
        findings = Findings("incline", engine.name, evidence=evidence)
        findings.checks += incline_checks(Verifying(engine, study, findings, evidence))
        findings.records[:] = {record.name: record for record in findings.records}.values()
        every = [angle for angles in evidence.by_contact.values() for angle in angles]
        extrapolated = evidence.extrapolated
        findings.published = {
            "closed_form_deg": evidence.closed_form_deg,
            "extrapolated": extrapolated.to_json() if extrapolated else None,
            "critical_angles": [angle.to_json() for angle in (*every, *evidence.routes)],
        }
        return findings

    def run_solvers(self, study: Study) -> Findings:
        """Hold the closed forms against second routes, and the adaptive reference DEM.

        At level full also the reference DEM with restitution against rigid spheres.
        """
        parts = [Part("closed forms", theory_checks), Part("restitution", restitution_checks)]
        stiffenings: list[Stiffening] = []
        if study.level == "full":
            parts.append(Part("rigid spheres", lambda: list(rigid_checks(stiffenings))))
        return Findings("incline", checks=rows_of_parts("theory", parts), evidence=stiffenings)

    def compare(self, engines: Mapping[str, Findings]) -> Sequence[Check]:
        """Hold the angles of engines against one another."""
        return across_engines([angle for each in engines.values() for angle in each.evidence])


def _other_engine(
    engine: str, run: Callable[[], Sequence[Check]], angles: list[EngineAngle]
) -> Findings:
    """Return the rows of an engine's angles, which ``run`` adds to ``angles``."""
    checks = rows_of_parts(engine, [Part("critical angle", run)], "deg")
    rows = [angle.to_json() for angle in angles]
    return Findings("incline", engine, checks, evidence=angles, published={"critical_angles": rows})


def incline_checks(verifying: Verifying) -> list[Check]:
    """Run the incline in an engine and return its checks; fill in findings and evidence.

    A part whose engine fails becomes a failed row; the other parts go on. The angles over stiffness
    and step fill the cores; the other runs, many of them sequential, go in parallel to them.
    """
    lanes = [replace(verifying, findings=Findings("incline")) for _ in range(2)]
    parts = [_angle_parts(lanes[0]), _other_parts(lanes[1])]
    rows = parallel_map(partial(rows_of_parts, "incline", unit="deg"), parts, len(lanes))
    for lane in lanes:
        verifying.findings.add(lane.findings)
    return [*rows[0], *rows[1], *rows_of_parts("incline", [_last_part(verifying)], "deg")]


def _angle_parts(verifying: Verifying) -> list[Part]:
    part, refusal = verifying.part, verifying.refusal
    angle = [_extrapolated_name(verifying.engine_title)]
    if not refusal(Incline(contact=PLASTIC)):
        angle.append(INTERVAL)
    refused = [_cell_name(case) for case in verifying.level.other_angles() if refusal(case)]
    return [
        part("extrapolation", _extrapolation, angle),
        part("source's and clipped contact", _other_angles, refused),
    ]


def _other_parts(verifying: Verifying) -> list[Part]:
    part, refusal = verifying.part, verifying.refusal
    tails = [_cell_name(case) for case in TAILS if refusal(case)][:1] or TAIL_NAMES
    shocks = [SHOCKS] if refusal(RECURSION_CASE, "steady") else [WELLS_PASSED, WORST_SHOCK]
    motions = [MOTIONS_NAME] if refusal(SOURCE_CASE, "steady") else []
    refused = [passage_row(case) for case in CASES if refusal(case)]
    return [
        part("the source's contact and its tail", _tails, tails),
        part("two routes", _routes, map(_route_name, verifying.level.routes)),
        part("energy after each shock", recursion, shocks),
        part("motion near the critical angle", _motions, motions),
        part("scale invariance", scales, SCALED),
        part("two ways to run it", two_ways, [WAYS_TO_RUN]),
        part("passages at a fixed angle", passages, refused),
    ]


def _last_part(verifying: Verifying) -> Part:
    rows = [name for part in reference_parts(verifying) for name in part.rows]
    return verifying.part("against the reference DEM", against_the_reference, rows)


def _extrapolated_name(engine_name: str) -> str:
    return f"incline: critical angle, {engine_name} extrapolated"


def _route_name(case: Incline) -> str:
    return f"incline: steady against passage, {case.contact.name} contact"


def _extrapolation(verifying: Verifying) -> list[Check]:
    name = _extrapolated_name(verifying.engine_title)
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
    evidence.extrapolated = extrapolated = extrapolate(angles)
    verifying.findings.records.append(extrapolated_case(extrapolated, angles))
    expected = evidence.closed_form_deg
    how = "plastic contact, step to zero, then stiffness to infinity"
    value, uncertainty = extrapolated.value_deg, extrapolated.uncertainty_deg
    headline = Row(HEADLINE, value, uncertainty, "deg", expected, verifying.engine_title, how)
    verifying.findings.headlines.append(headline)
    cap = EXTRAPOLATED.absolute
    why = "the stated interval contains the closed form and is no wider than the tolerance"
    return [
        judge(name, Kind.ANALYTIC, value, expected, EXTRAPOLATED, uncertainty=uncertainty),
        judge(
            INTERVAL,
            Kind.ANALYTIC,
            value,
            expected,
            Tolerance("deg", min(uncertainty, cap), 0.0, why),
            uncertainty=uncertainty,
        ),
    ]


def _other_angles(verifying: Verifying) -> list[Check]:
    level, requested = verifying.level, verifying.level.other_angles()
    rows = [row for case in requested for row in verifying.untested(_cell_name(case), case)]
    cases = verifying.supported(requested)
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
    verifying.findings.records += [
        angle_case(angle, in_phases(PHASES)) for angle in (clipped, kept)
    ]
    return [
        finding(
            TAIL_NAMES[0],
            kept.value_deg,
            verifying.evidence.closed_form_deg,
            "deg",
            "close by cancellation of step and stiffness bias, not by convergence",
            kept.uncertainty_deg,
        ),
        finding(
            TAIL_NAMES[1],
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
        name = _route_name(case)
        rows += verifying.untested(name, case) or [_route(verifying, name, case)]
        progress("passage against steady", number, len(cases))
    return rows


def _route(verifying: Verifying, name: str, case: Incline) -> Check:
    """Hold the critical angle by steady motion against that by passage."""
    resolution, engine = verifying.level.steady_tolerance_deg, verifying.engine
    passage = run_or_raise(verifying.angle(case))
    steady = critical_angle(case, method="steady", tolerance_deg=resolution, engine=engine)
    verifying.evidence.routes += [passage, steady]
    verifying.findings.records += [
        angle_case(passage, in_phases(PHASES)),
        angle_case(steady, f"{resolution:g}-deg"),
    ]
    uncertainty = steady.uncertainty_deg + passage.uncertainty_deg
    cap = resolution + MOST_ROUTE_JITTER
    why = (
        "passage and steady must agree within the sum of their uncertainties, and within the "
        f"resolution of the search and the jitter of a contact's begin, {cap:g} deg"
    )
    width = Tolerance("deg", min(uncertainty, cap), 0.0, why)
    value, expected = steady.value_deg, passage.value_deg
    note = f"passage: {passage.phases_note}"
    return judge(name, Kind.CROSS_CODE, value, expected, width, uncertainty=uncertainty, note=note)


def _motions(verifying: Verifying) -> list[Check]:
    untested = verifying.untested(MOTIONS_NAME, SOURCE_CASE, "steady", "")
    if untested:
        return untested
    for run in run_inclines(verifying.engine, MOTIONS, "steady", every=MOTION_EVERY):
        verifying.evidence.motions.append(run_or_raise(run))
    return []
