"""The tower: LAMMPS and RK4 against the exact propagator, law by law, and law against law.

Same law, different code must agree to the integration error. Different law,
same code is a finding.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

from harness import __version__
from harness.cases.tower.chain_checks import bessel
from harness.cases.tower.comparison import SeriesComparison, compare
from harness.cases.tower.impulse_angles import (
    WAYS,
    energy_scaling_angles,
    impulse_angles,
    impulse_by_gamma,
)
from harness.cases.tower.records import force_comparison, tower_case, tower_name
from harness.cases.tower.run import tower
from harness.cases.tower.step_convergence import step_convergence
from harness.comparison.evidence import TowerEvidence
from harness.comparison.tolerances import TOLERANCES
from harness.comparison.triage import of_divergence
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
from harness.errors import EngineError, EngineOutputError, RequestError
from harness.observables.impulse import impulse
from harness.observables.tower import TowerRun
from harness.parameters.tower import LAWS, Law, Tower
from harness.workflows.progress import Progress
from harness.workflows.verification.baseline_rows import ratio_cases
from harness.workflows.verification.levels import Level

SHOWN = 2
"""Height whose force series the report shows: three particles, the source's example."""

COLLAPSED = (1, 2, 3, 5, 10)
"""Heights whose impulse ratio is shown to depend on Gamma alone."""

LEAST_FORCE = 1e-6
"""Contacts that press with less, over the peak, are not compared: rounding decides on them."""

STEPS = tuple(250.0 * 2.0 ** (i / 2) for i in range(7))
CODES = ("lammps", "rk4")


def tower_checks(
    engine: Engine, level: Level, evidence: TowerEvidence, progress: Progress
) -> list[Check]:
    """Run the towers and return their checks; fill in the evidence.

    A part whose engine dies becomes a failed row; the other parts go on.
    """
    if not engine.states_towers:
        reason = f"engine {engine.name!r} states the incline only"
        return [not_tested("tower: engine against the exact propagator", Kind.CROSS_CODE, reason)]
    own = engine.identify().how == "in-process"
    laws = LAWS if own else ("overlap",)
    parts: list[tuple[str, Callable[[], list[Check]]]] = [
        (f"{law} law", partial(_same_law, law, engine, level, evidence, progress)) for law in laws
    ]
    parts += [
        ("tall tower", lambda: [bessel("lammps", TOLERANCES["tall tower in LAMMPS"], engine)]),
        ("laws apart", lambda: _different_law(evidence)),
        ("impulse table", lambda: _impulses(engine, level, evidence)),
    ]
    checks: list[Check] = []
    if not own:
        reason = "an external force on LAMMPS's particles needs LAMMPS in-process"
        checks.append(not_tested("tower: lammps, deformable law", Kind.CROSS_CODE, reason))
    for name, part in parts:
        try:
            checks += part()
        except EngineError as error:
            checks.append(failed_run(f"tower: {name}", Kind.CROSS_CODE, error))
        except RequestError as error:
            # the cases are ours: a run that does not show its window is the engine's doing
            bad = EngineOutputError(str(error))
            checks.append(failed_run(f"tower: {name}", Kind.CROSS_CODE, bad))
    return checks


def _same_law(
    law: Law, engine: Engine, level: Level, evidence: TowerEvidence, progress: Progress
) -> list[Check]:
    """Hold force series and impulse of LAMMPS and RK4 against exact, and measure their orders."""
    stage = f"tower, {law} law"
    rows: list[Check] = []
    for number, height in enumerate(level.heights, 1):
        case = Tower(height=height, law=law)
        try:
            lammps = tower(case, solver="lammps", profiles=True, engine=engine)
        except EngineError as error:
            evidence.errors[tower_name(case, engine.name)] = error
            raise
        # samples at the same times: nothing needs to be interpolated
        exact = tower(case, solver="exact", samples=lammps.time.size - 1, profiles=True)
        rk4 = tower(case, solver="rk4", profiles=True)
        evidence.measured += [tower_case(run, __version__) for run in (lammps, exact, rk4)]
        for run in (lammps, rk4):
            rows += _against_exact(run, exact, evidence)
        progress(stage, number, len(level.heights) + 1)
    rows += [_order(law, code, engine, evidence) for code in CODES]
    progress(stage, len(level.heights) + 1, len(level.heights) + 1)
    return rows


def _against_exact(run: TowerRun, exact: TowerRun, evidence: TowerEvidence) -> list[Check]:
    found = compare(run, exact, least_force=LEAST_FORCE)
    if run.tower.height == SHOWN:
        evidence.same_law.setdefault(run.tower.law, []).append(found)
    name = f"tower: {run.solver}, {run.tower.law} law, n = {run.tower.height}"
    width = TOLERANCES[f"tower force, {run.tower.law} law"]
    triage = _divergence(name, found, width.width(0.0), evidence)
    return [
        judge(
            f"{name}: force, largest difference over the peak",
            Kind.CROSS_CODE,
            found.force.peak,
            0.0,
            width,
            triage=triage,
        ),
        judge(
            f"{name}: impulse to the turnaround",
            Kind.CROSS_CODE,
            impulse(run),
            impulse(exact),
            TOLERANCES["tower impulse"],
            triage=triage,
        ),
        _events(name, found, triage),
    ]


def _divergence(name: str, found: SeriesComparison, band: float, evidence: TowerEvidence) -> str:
    """Return the class of a force that left the tolerance about the reference, empty if none."""
    series = force_comparison(name, found, band)
    divergence = series.divergence
    if divergence is None:
        return ""
    evidence.parted.append(series)
    return of_divergence(divergence)


def _events(name: str, found: SeriesComparison, triage: str) -> Check:
    """Hold the onsets and breaks of contacts against those of the exact run, one by one."""
    t0 = found.run.tower.contact_time
    alone = len(found.unmatched)
    return judge(
        f"{name}: contact changes, largest time difference",
        Kind.CROSS_CODE,
        math.inf if alone else found.largest_event_difference / t0,
        0.0,
        TOLERANCES["contact changes"],
        note=f"{alone} of {len(found.events)} have no counterpart" if alone else "",
        triage=triage,
    )


def _order(law: Law, code: str, engine: Engine, evidence: TowerEvidence) -> Check:
    """Measure how the force error falls with the step, against second order across onsets."""
    case = Tower(height=SHOWN + 1, law=law)
    exact = tower(case, solver="exact", samples=12_000)
    found = step_convergence(
        lambda steps: tower(case, solver=code, steps_per_contact=steps, engine=engine),
        exact,
        STEPS,
    )
    evidence.convergence.append(found)
    low, high = found.l2_order.interval
    return judge_within_uncertainty(
        f"tower: {code}, {law} law: order of the force error in the step, n = {case.height}",
        Kind.CROSS_CODE,
        found.l2_order.value,
        2.0,
        (high - low) / 2,
        "",
        "a change of contacts falls anywhere within a step, which costs second order: it must "
        "lie in the 95 % interval of the measured slope",
    )


def _different_law(evidence: TowerEvidence) -> list[Check]:
    """Report how far the laws are apart, both by the exact propagator."""
    rows = []
    for height in (1, 2, 9, 19):
        runs = {
            law: tower(Tower(height=height, law=law), solver="exact", profiles=True) for law in LAWS
        }
        found = compare(runs["deformable"], runs["overlap"], across_laws=True)
        evidence.different_law.append(found)
        rows.append(
            finding(
                f"laws: largest difference of the force over the peak, n = {height}",
                found.force.peak,
                0.0,
                "",
                "deformable against overlap law, exact; equal for one contact by construction",
            )
        )
    return rows


def _impulses(engine: Engine, level: Level, evidence: TowerEvidence) -> list[Check]:
    """Compare alpha(n) of LAMMPS with exact, and report what the law does to the angle."""
    evidence.impulses = impulse_angles(solver="exact")
    if level.gammas:
        evidence.by_gamma = impulse_by_gamma(level.gammas, solver="exact")
        evidence.ways = impulse_by_gamma(
            level.gammas[::2], heights=COLLAPSED, ways=WAYS, solver="exact"
        )
    evidence.scaling = energy_scaling_angles()
    heights = level.heights
    one_run = partial(
        impulse_angles, heights=heights, stiffnesses=(1e6,), speeds=(2.0,), laws=("overlap",)
    )
    lammps, exact = one_run(solver="lammps", engine=engine), one_run(solver="exact")
    evidence.measured += ratio_cases(lammps, engine.identify(), heights)
    evidence.measured += ratio_cases(evidence.impulses, None, heights)
    rows = [
        judge(
            f"tower: impulse ratio alpha({height}), overlap law, lammps",
            Kind.CROSS_CODE,
            float(ours),
            float(theirs),
            TOLERANCES["impulse ratio"],
        )
        for height, ours, theirs in zip(
            heights, lammps["impulse_ratio"], exact["impulse_ratio"], strict=True
        )
    ]
    return rows + [_law_and_angle(evidence, height) for height in (2, 3, 19)]


def _law_and_angle(evidence: TowerEvidence, height: int) -> Check:
    """Report the critical angle of both laws at one height, k = 1e6 N/m and 2 m/s."""
    assert evidence.impulses is not None
    frame = evidence.impulses
    chosen = frame[
        (frame["height"] == height)
        & (frame["stiffness_N_per_m"] == 1e6)
        & (frame["speed_m_per_s"] == 2.0)
    ].set_index("law")
    angles, ratios = chosen["critical_angle_deg"], chosen["impulse_ratio"]
    return finding(
        f"laws: critical angle at height {height}, deformable against overlap",
        float(angles["deformable"]),
        float(angles["overlap"]),
        "deg",
        f"alpha = {ratios['deformable']:.4f} (deformable), {ratios['overlap']:.4f} (overlap); "
        "turnaround window, velocity lost rescaled",
    )
