"""Figures 6 and 7: free chains of two and three particles, and the error of their peak."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from harness.cases.tower.chain_evidence import PAIR, PARTED, error_over_stiffness
from harness.cases.tower.evidence import Curve
from harness.cases.tower.run import tower
from harness.comparison.convergence import slope_order
from harness.observables.summary import contact_changes
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower
from harness.reproduction.claims import Statement, claim_of_facts

STIFFNESSES = [10.0**exponent for exponent in np.arange(2.0, 7.5, 0.5)]
"""[N/m] two decades either side of what the source's claim names, and its runs."""

CLAIMED_ERROR, CLAIMED_STIFFNESS = 0.005, 1e4

FALLS = -0.01
"""Power of the stiffness below which an error falls; at it, by a tenth over ten decades."""

FIXED_STEP = "RK4, one step, 1e-4 s"
SCALED_STEP = "RK4, 50 steps per contact time"
SHRINKING_STEP = "RK4, step that shrinks as 1/k, 1e-5 s at 1e5 N/m"
GRAVITY = "exact, gravity on, but left out of the prediction"


def two_and_three_particles() -> tuple[tuple[TowerRun, ...], Statement]:
    """Run the source's collisions and judge what it reads off them."""
    two, three = runs = tuple(
        tower(PAIR.replace(height=n), solver="exact", duration=PARTED, profiles=True)
        for n in (1, 2)
    )
    joins = next(time for time, contacts in contact_changes(three) if contacts == 2)
    deformations = three.deformations / three.deformations.max()
    before = three.time_over_t0 < joins
    soon = int(np.searchsorted(three.time_over_t0, joins + 0.01))
    more, stored = (
        100 * (float(of_three.max() / of_two.max()) - 1)
        for of_two, of_three in (
            [run.deformations.sum(axis=1) for run in runs],
            [run.elastic_energy for run in runs],
        )
    )
    return runs, claim_of_facts(
        "fig-6",
        speed=two.tower.speed,
        left=float(abs(two.final_velocity[0])),
        back=three.final_velocity[0],
        joins=joins,
        apart=float(np.abs(deformations[before, 0] - deformations[before, 1]).max()),
        soon=deformations[soon],
        more=more,
        stored=stored,
    )


def error_against_stiffness() -> tuple[Mapping[str, Curve], Statement]:
    """Measure the error of the peak deformation over k, by rules for the step, and judge its trend.

    The source does not say how it chose the step. Beside the error of RK4 stands
    that of a prediction without gravity for a run with it, which does fall.
    """
    steps = {
        SCALED_STEP: lambda _: 50.0,
        FIXED_STEP: lambda case: case.contact_period / 1e-4,
        SHRINKING_STEP: lambda case: case.contact_period / (1e-5 * 1e5 / case.each("stiffness")[0]),
    }
    curves = {name: error_over_stiffness(STIFFNESSES, rule) for name, rule in steps.items()}
    curves[GRAVITY] = STIFFNESSES, [_gravity_left_out(k) for k in STIFFNESSES]
    fits = {name: slope_order(*curve) for name, curve in curves.items()}
    powers = {name: f"{slope:.2f}".replace("-0.00", "0.00") for name, (slope, _) in fits.items()}
    falls = {name: high < FALLS for name, (_, (_, high)) in fits.items()}
    errors = {name: float(np.interp(CLAIMED_STIFFNESS, *curve)) for name, curve in curves.items()}
    facts = []
    for name in (SCALED_STEP, FIXED_STEP):
        facts.append((falls[name], f"the error goes as k^{powers[name]} ({name})"))
        small = errors[name] < CLAIMED_ERROR
        facts.append((small, f"at 1e4 N/m it is {100 * errors[name]:.2g} % ({name})"))
    others = [
        f"{name} (k^{powers[name]}, {100 * errors[name]:.2g} % at 1e4 N/m)"
        for name in (SHRINKING_STEP, GRAVITY)
        if falls[name]
    ]
    return curves, claim_of_facts(
        "fig-7",
        facts,
        holds=all(held for held, _ in facts[:2]) or all(held for held, _ in facts[2:]),
        remark=f"What falls with k: {'; '.join(others)}."
        if others
        else "No other reading falls with k.",
    )


def _gravity_left_out(stiffness: float) -> float:
    """Return by how much gravity deepens the peak of a grain on a fixed particle, relative."""
    case = Tower(height=1, stiffness=stiffness)
    run = tower(case, solver="exact", duration=1.0)
    predicted = case.speed * math.sqrt(1.0 / stiffness)
    return float(run.compression.max()) / predicted - 1.0
