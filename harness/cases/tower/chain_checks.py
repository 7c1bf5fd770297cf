"""The chain solvers held against closed forms."""

from __future__ import annotations

import numpy as np
from scipy.special import jn_zeros

from harness.cases.tower.chain_evidence import chain_evidence
from harness.cases.tower.run import tower
from harness.comparison.evidence import TowerEvidence
from harness.comparison.tolerances import TOLERANCES, Tolerance
from harness.comparison.verdicts import Check, Kind, judge
from harness.engines.contract import Engine
from harness.observables.impulse import impulse_until
from harness.observables.windows import first_contact_end
from harness.parameters.tower import Law, Tower
from harness.theory.free_chain import final_velocities
from harness.theory.semi_infinite_chain import grain_velocity
from harness.theory.two_spheres import contact_time_on_fixed, impulse_on_fixed
from harness.workflows.verification.levels import Level

WIDTH = TOLERANCES["chain, closed form"]
FREE: tuple[tuple[int, Law], ...] = (
    (2, "overlap"),
    (3, "overlap"),
    (4, "overlap"),
    (3, "deformable"),
)


def chain_checks(level: Level, evidence: TowerEvidence) -> list[Check]:
    """Return the checks of the exact propagator against closed forms; fill in the evidence."""
    if level.chain_figures:
        chain_evidence(evidence)
    return [*_grain_on_one(), *(_free_chain(n, law) for n, law in FREE), bessel("exact", WIDTH)]


def _grain_on_one() -> list[Check]:
    case = Tower(height=1)
    own = (1.0, 1e6, case.speed, case.gravity)
    run = tower(case, solver="exact")
    end = first_contact_end(run)
    pairs = [
        ("chain: contact time of a grain on one particle, s", end, contact_time_on_fixed(*own)),
        ("chain: its impulse, N s", impulse_until(run, end), impulse_on_fixed(*own)),
    ]
    return [judge(name, Kind.ANALYTIC, value, expected, WIDTH) for name, value, expected in pairs]


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
        TOLERANCES["chain, final velocity"],
    )


def bessel(solver: str, width: Tolerance, engine: Engine | None = None) -> Check:
    """Return the check of the first-contact impulse ratio against the semi-infinite chain.

    The wave takes about a contact to pass one particle, so that a base forty
    particles away is not felt before the grain leaves.
    """
    case = Tower(height=40, law="overlap", gravity=0.0)
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
