"""LAMMPS on the incline, held against the closed form and against itself."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.critical_angles import complete, critical_angle, critical_angles
from harness.cases.incline.extrapolation import extrapolate
from harness.cases.incline.parameters import Incline
from harness.cases.incline.passage import PHASES
from harness.cases.incline.passages import passages
from harness.cases.incline.records import angle_case
from harness.comparison.evidence import InclineEvidence, Recursion
from harness.comparison.tolerances import TOLERANCES, Tolerance
from harness.comparison.verdicts import (
    Check,
    Kind,
    failed_run,
    finding,
    judge,
    judge_within_uncertainty,
    not_tested,
)
from harness.engines.contract import Engine
from harness.engines.lammps.engine import Lammps
from harness.errors import EngineError, RequestError
from harness.parameters.contact import PLASTIC
from harness.theory import energy_map
from harness.theory.shock import SHOCK_WITHOUT_REBOUND
from harness.workflows.progress import Progress
from harness.workflows.verification.baseline_rows import in_phases, keep_errors
from harness.workflows.verification.levels import SOURCE_CASE, SOURCE_CLIPPED, Level

RECURSION_CASE = Incline(contact=PLASTIC, stiffness=1e6, steps_per_contact=200.0, angle=10.6)
NEAR_CRITICAL_DEG = (10.20, 10.22)
"""The two angles of the source's velocity figure: trapped and moving."""


def incline_checks(
    engine: Engine, level: Level, evidence: InclineEvidence, progress: Progress
) -> list[Check]:
    """Run the incline and return its checks; fill in the evidence.

    A part whose engine dies becomes a failed row; the other parts go on.
    """
    parts: list[tuple[str, Callable[[], list[Check]]]] = [
        ("extrapolation", lambda: _extrapolation(engine, level, evidence, progress)),
        ("source's and clipped contact", lambda: _beside(engine, level, evidence, progress)),
        ("two routes", lambda: _routes(engine, level, evidence, progress)),
        ("energy after each shock", lambda: _recursion(engine, evidence)),
        ("motion near the critical angle", lambda: _motions(engine, evidence)),
        ("scale invariance", lambda: _scales(engine, progress)),
        ("two ways to run LAMMPS", lambda: _two_ways(engine)),
        ("passages at a fixed angle", lambda: passages(engine, evidence)),
    ]
    checks: list[Check] = []
    for name, part in parts:
        try:
            checks += part()
        except EngineError as error:
            checks.append(failed_run(f"incline: {name}", Kind.CROSS_CODE, error, "deg"))
    return checks


def _extrapolation(
    engine: Engine, level: Level, evidence: InclineEvidence, progress: Progress
) -> list[Check]:
    cases = level.ladder.cases(Incline(contact=PLASTIC))
    found_or_died = critical_angles(
        cases, engine, stage="plastic contact, extrapolation", progress=progress
    )
    keep_errors(evidence, engine.name, cases, found_or_died, PHASES)
    angles = complete(found_or_died)
    evidence.by_contact[PLASTIC.name] = angles
    evidence.extrapolated = found = extrapolate(angles)
    expected = evidence.closed_form_deg
    return [
        judge(
            "incline: critical angle, LAMMPS extrapolated",
            Kind.ANALYTIC,
            found.value_deg,
            expected,
            TOLERANCES["critical angle, extrapolated"],
            uncertainty=found.uncertainty_deg,
        ),
        judge_within_uncertainty(
            "incline: the stated uncertainty holds the closed form",
            Kind.ANALYTIC,
            found.value_deg,
            expected,
            found.uncertainty_deg,
            "deg",
            "an honest uncertainty contains the truth",
        ),
    ]


def _beside(
    engine: Engine, level: Level, evidence: InclineEvidence, progress: Progress
) -> list[Check]:
    cases = level.beside()
    angles = critical_angles(
        cases,
        engine,
        phases=level.phases_beside,
        stage="source's and clipped contact",
        progress=progress,
    )
    keep_errors(evidence, engine.name, cases, angles, level.phases_beside)
    rows: list[Check] = []
    for case, angle in zip(cases, angles, strict=True):
        if isinstance(angle, EngineError):
            name = f"incline: {case.contact.name}, k = {case.stiffness:g} N/m"
            rows.append(failed_run(name, Kind.CROSS_CODE, angle, "deg"))
        else:
            evidence.by_contact.setdefault(case.contact.name, []).append(angle)
    clipped = critical_angle(
        SOURCE_CASE.replace(contact=SOURCE_CLIPPED), engine=engine, method="passage"
    )
    kept = critical_angle(SOURCE_CASE, engine=engine, method="passage")
    evidence.measured += [angle_case(angle, in_phases(PHASES)) for angle in (clipped, kept)]
    rows += [_bias(kept, evidence.closed_form_deg), _clipping(clipped, kept)]
    return rows


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


def _routes(
    engine: Engine, level: Level, evidence: InclineEvidence, progress: Progress
) -> list[Check]:
    rows = []
    for number, case in enumerate(level.routes, 1):
        progress("passage against steady", number - 1, len(level.routes))
        passage = critical_angle(case, method="passage", engine=engine)
        steady = critical_angle(
            case, method="steady", tolerance_deg=level.steady_tolerance_deg, engine=engine
        )
        evidence.routes += [passage, steady]
        evidence.measured += [
            angle_case(passage, in_phases(PHASES)),
            angle_case(steady, f"{level.steady_tolerance_deg:g}-deg"),
        ]
        rows.append(
            judge_within_uncertainty(
                f"incline: steady against passage, {case.contact.name} contact",
                Kind.CROSS_CODE,
                steady.value_deg,
                passage.value_deg,
                steady.uncertainty_deg + passage.uncertainty_deg,
                "deg",
                TOLERANCES["two routes"].reason,
            )
        )
        progress("passage against steady", number, len(level.routes))
    return rows


def _recursion(engine: Engine, evidence: InclineEvidence) -> list[Check]:
    """Hold the energy after each shock against E[j+1] = (E[j] + dE) / 4 from the first one."""
    case = RECURSION_CASE
    run = engine.measured([case], "steady")[0]
    measured = run.crests.margin_J / case.weight_energy + energy_map.well_depth(case.angle)
    if len(measured) < 2:
        return [not_tested("incline: energy after each shock", Kind.ANALYTIC, "it was trapped")]
    predicted = np.concatenate(
        [
            measured[:1],
            energy_map.energies(
                float(measured[0]), len(measured) - 1, case.angle, SHOCK_WITHOUT_REBOUND
            ),
        ]
    )
    evidence.recursion = Recursion(run, measured, predicted)
    worst = int(np.argmax(np.abs(measured - predicted)))
    return [
        judge(
            f"incline: energy after shock {worst + 1}, the worst of {len(measured)}",
            Kind.ANALYTIC,
            float(measured[worst]),
            float(predicted[worst]),
            _recursion_tolerance(engine, evidence.closed_form_deg),
        )
    ]


def _recursion_tolerance(engine: Engine, closed_form: float) -> Tolerance:
    """Return what stiffness and step are worth in energy, by the passage route at the same ones."""
    angle = critical_angle(RECURSION_CASE, engine=engine)
    off = abs(angle.value_deg - closed_form) + angle.uncertainty_deg
    slope = energy_map.passage_margin_slope(closed_form, SHOCK_WITHOUT_REBOUND)
    # a geometric sum of such errors, each passed on with 1/4, is 4/3 of one; the shock
    # at this angle is up to half as strong again as at the critical one
    return Tolerance(
        "m g d",
        2.0 * off * slope,
        0.0,
        "bias and jitter of the passage route at this stiffness and step, as an energy, times 2",
    )


def _motions(engine: Engine, evidence: InclineEvidence) -> list[Check]:
    cases = [SOURCE_CASE.replace(angle=angle, wells=20) for angle in NEAR_CRITICAL_DEG]
    for run in engine.inclines(cases, "steady", every=100):
        if isinstance(run, EngineError):
            raise run
        evidence.motions.append(run)
    return []


def _scales(engine: Engine, progress: Progress) -> list[Check]:
    base = SOURCE_CASE
    glass = base.replace(diameter=3e-3, density=2500.0, stiffness=1.0e6)
    others = {
        "3 mm glass": _same_rigidity(glass, base),
        "lunar gravity": _same_rigidity(base.replace(gravity=1.62), base),
    }
    reference = critical_angle(base, engine=engine)
    rows = []
    for number, (name, case) in enumerate(others.items(), 1):
        angle = critical_angle(case, engine=engine)
        rows.append(
            judge(
                f"incline: scale invariance, {name}",
                Kind.CROSS_CODE,
                angle.value_deg,
                reference.value_deg,
                TOLERANCES["scale invariance"],
                uncertainty=angle.uncertainty_deg,
            )
        )
        progress("scale invariance", number, len(others))
    return rows


def _same_rigidity(case: Incline, base: Incline) -> Incline:
    """Return a case with the stiffness that keeps k d / (m g) of the base."""
    return case.replace(stiffness=case.mass * case.gravity / (base.static_overlap * case.diameter))


def _two_ways(engine: Engine) -> list[Check]:
    """Hold an in-process run against the executable of the same installation."""
    name = "incline: in-process against executable, energy margin"
    if engine.name != "lammps":
        return [not_tested(name, Kind.CROSS_CODE, f"this is {engine.name!r}, not LAMMPS", "J")]
    if engine.identify().how != "in-process":
        return [not_tested(name, Kind.CROSS_CODE, "an executable was asked for", "J")]
    case = SOURCE_CASE.replace(angle=10.0)
    try:
        with Lammps(lmp="lmp") as executable:
            other = executable.measured([case], "passage")[0]
    except RequestError as error:
        return [not_tested(name, Kind.CROSS_CODE, str(error), "J")]
    own = engine.measured([case], "passage")[0]
    return [
        judge(
            name,
            Kind.CROSS_CODE,
            own.margin_J,
            other.margin_J,
            TOLERANCES["same script, two ways to run it"],
        )
    ]
