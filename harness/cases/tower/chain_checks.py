"""The chain solvers held against closed forms."""

from __future__ import annotations

import numpy as np
from scipy.special import jn_zeros

from harness.cases.tower import tolerances
from harness.cases.tower.run import tower
from harness.comparison.tolerances import Tolerance
from harness.comparison.verdicts import Check, Kind, judge
from harness.engines.contract import Engine
from harness.observables.impulse import impulse_until
from harness.observables.windows import first_contact_end
from harness.parameters.tower import Law, Tower
from harness.theory.free_chain import final_velocities
from harness.theory.semi_infinite_chain import grain_velocity
from harness.theory.two_spheres import contact_time_on_fixed, impulse_on_fixed

FREE: tuple[tuple[int, Law], ...] = (
    (2, "overlap"),
    (3, "overlap"),
    (4, "overlap"),
    (3, "deformable"),
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
