"""What the tower shows without an engine: chain solvers, the laws apart, impulse tables."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from scipy.special import jn_zeros

from harness.cases.contract import Study
from harness.cases.parts import Part, rows_of_parts
from harness.cases.tower import tolerances
from harness.cases.tower.against_exact import against_exact, exact_run, order
from harness.cases.tower.chain_evidence import chain_evidence
from harness.cases.tower.comparison import compare
from harness.cases.tower.evidence import OwnEvidence
from harness.cases.tower.impulse_angles import (
    WAYS,
    energy_scaling_angles,
    impulse_angles,
    impulse_by_gamma,
)
from harness.cases.tower.levels import LEVELS, OWN_LADDER, Level
from harness.cases.tower.records import NAME, of_ratio, ratio_records, tower_record
from harness.cases.tower.run import DURATION, tower
from harness.cases.tower.timing import timing_of
from harness.comparison.findings import Findings
from harness.comparison.tolerances import Tolerance
from harness.comparison.verdicts import Check, Kind, finding, judge
from harness.engines.contract import Engine
from harness.observables.impulse import impulse_until
from harness.observables.tower import TowerRun
from harness.observables.windows import first_contact_end
from harness.parameters.tower import LAWS, Law, Tower
from harness.theory.free_chain import final_velocities
from harness.theory.semi_infinite_chain import grain_velocity
from harness.theory.two_spheres import contact_time_on_fixed, impulse_on_fixed

FREE: tuple[tuple[int, Law], ...] = (
    (2, "overlap"),
    (3, "overlap"),
    (4, "overlap"),
    (3, "deformable"),
)
"""Particles and law of the free chains."""

COLLAPSED = (1, 2, 3, 5, 10)
"""Heights whose impulse ratio is shown to depend on Gamma alone."""

APART = (1, 2, 9, 19)
"""Heights at which the laws are held against each other."""

ANGLES = (2, 3, 19)
"""Heights whose critical angle is told under both laws."""


def own_findings(study: Study) -> Findings:
    """Return the rows, records and evidence of the harness's own solvers.

    A part that goes wrong becomes a failed row; the other parts go on.
    """
    level, found = LEVELS[study.level], Findings(NAME, evidence=OwnEvidence("RK4"))
    parts = [Part("chain solvers", chain_checks)]
    if level.chain_figures:
        parts.append(Part("chain figures", partial(chain_evidence, found.evidence)))
    parts += [Part(f"rk4, {law} law", partial(_same_law, law, study, found)) for law in LAWS]
    parts += [
        Part("laws apart", partial(_laws_apart, found.evidence)),
        Part("impulse table, exact", partial(_impulses, level, found)),
    ]
    found.checks += rows_of_parts(NAME, parts)
    return found


def _same_law(law: Law, study: Study, found: Findings) -> list[Check]:
    """Hold RK4 against the exact propagator, and keep the records of both."""
    rows: list[Check] = []
    for height in LEVELS[study.level].heights:
        case = Tower(height=height, law=law)
        timing = timing_of(case, DURATION, None, None)
        # samples where an engine has them by default
        exact = exact_run(case, timing.steps // timing.every, study)
        rk4 = tower(case, solver="rk4", profiles=True)
        found.records += [tower_record(exact), tower_record(rk4)]
        rows += against_exact(rk4, exact, found.evidence, found.divergences)

    def stepped(case: Tower, steps: float) -> TowerRun:
        return tower(case, solver="rk4", steps_per_contact=steps)

    return [*rows, order(law, "rk4", stepped, OWN_LADDER, found.evidence, study)]


def _laws_apart(evidence: OwnEvidence) -> list[Check]:
    """Report how far the laws are apart, both by the exact propagator."""
    rows = []
    for height in APART:
        deformable, overlap = (
            tower(Tower(height=height, law=law), solver="exact", profiles=True)
            for law in ("deformable", "overlap")
        )
        found = compare(deformable, overlap, across_laws=True)
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


def _impulses(level: Level, found: Findings) -> list[Check]:
    """Make the tables of alpha(n), and report what the law does to the critical angle."""
    evidence: OwnEvidence = found.evidence
    evidence.impulses = impulse_angles(solver="exact")
    evidence.scaling = energy_scaling_angles()
    if level.gammas:
        evidence.by_gamma = impulse_by_gamma(level.gammas, solver="exact")
        evidence.ways = impulse_by_gamma(
            level.gammas[::2], heights=COLLAPSED, ways=WAYS, solver="exact"
        )
    found.records += ratio_records(evidence.impulses, None, level.heights)
    return [_law_and_angle(evidence.impulses, height) for height in ANGLES]


def _law_and_angle(frame: Any, height: int) -> Check:
    """Report the critical angle of both laws at one height, k = 1e6 N/m and 2 m/s."""
    chosen = of_ratio(frame[frame["height"] == height]).set_index("law")
    angles, ratios = chosen["critical_angle_deg"], chosen["impulse_ratio"]
    return finding(
        f"laws: critical angle at height {height}, deformable against overlap",
        float(angles["deformable"]),
        float(angles["overlap"]),
        "deg",
        f"alpha = {ratios['deformable']:.4f} (deformable), {ratios['overlap']:.4f} (overlap); "
        "turnaround window, velocity lost rescaled",
    )


def chain_checks() -> list[Check]:
    """Return the checks of the exact propagator against closed forms."""
    free = (_free_chain(n, law) for n, law in FREE)
    return [*_grain_on_one(), *free, bessel(tolerances.CLOSED_FORM)]


def _grain_on_one() -> list[Check]:
    case = Tower(height=1)
    own = (1.0, 1e6, case.speed, case.gravity)
    run = tower(case, solver="exact")
    end = first_contact_end(run)
    rows = [
        ("contact time of a grain on one particle, s", end, contact_time_on_fixed(*own)),
        ("its impulse, N s", impulse_until(run, end), impulse_on_fixed(*own)),
    ]
    width = tolerances.CLOSED_FORM
    return [
        judge(f"chain: {name}", Kind.ANALYTIC, value, expected, width)
        for name, value, expected in rows
    ]


def _free_chain(particles: int, law: Law) -> Check:
    """Hold final velocities against matrix exponentials; report the one that is furthest off."""
    case = Tower(height=particles - 1, law=law, base="free", gravity=0.0, speed=1.0)
    run = tower(case, solver="exact", duration=float(4 * particles))
    expected = final_velocities(particles, deformable=law == "deformable")
    worst = int(np.argmax(np.abs(run.final_velocity - expected)))
    return judge(
        f"chain: {particles} free particles, {law} law, final velocity of particle {worst + 1}",
        Kind.ANALYTIC,
        float(run.final_velocity[worst]),
        float(expected[worst]),
        tolerances.FINAL_VELOCITY,
    )


def bessel(width: Tolerance, engine: Engine | None = None) -> Check:
    """Hold the first-contact impulse ratio of a tall tower against the semi-infinite chain.

    By the exact propagator unless an engine is given. The wave takes about a contact to pass one
    particle, so that a base forty particles away is not felt before the grain leaves.
    """
    case = Tower(height=40, law="overlap", gravity=0.0)
    solver = "exact" if engine is None else engine.name
    run = tower(case, solver=solver, samples=6000, engine=engine)
    ratio = impulse_until(run, first_contact_end(run)) / (2.0 * case.speed)
    leaves = float(jn_zeros(2, 1)[0])
    expected = (1.0 - float(grain_velocity(leaves))) / 2.0
    return judge(
        f"chain: first-contact impulse ratio of a tall tower, {solver}",
        Kind.ANALYTIC,
        ratio,
        expected,
        width,
    )
