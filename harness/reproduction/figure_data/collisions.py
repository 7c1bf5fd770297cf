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
from harness.reproduction.claims import Statement
from harness.reproduction.facts import all_hold, claim_of_facts
from harness.reproduction.source import SOURCES

STIFFNESSES = [10.0**exponent for exponent in np.arange(2.0, 7.5, 0.5)]
"""[N/m] two decades either side of what the source's claim names, and its runs."""

CLAIMED_ERROR, CLAIMED_STIFFNESS = 0.005, 1e4
_ROUNDING = 1e-9
"""Of a velocity or deformation over its largest: the exact propagator leaves about 1e-12."""


Slope = tuple[float, tuple[float, float]]
"""Of log error against log stiffness, with its 95 % interval."""

FIXED_STEP = "RK4, one step, 1e-4 s"
SCALED_STEP = "RK4, 50 steps per contact time"
SHRINKING_STEP = "RK4, step that shrinks as 1/k, 1e-5 s at 1e5 N/m"
GRAVITY = "exact, gravity on, but left out of the prediction"


def two_and_three_particles() -> tuple[tuple[TowerRun, ...], Statement]:
    """Run the source's collisions and judge what it reads off them."""
    two, three = (
        tower(PAIR.replace(height=n), solver="exact", duration=PARTED, profiles=True)
        for n in (1, 2)
    )
    joins = next(time for time, contacts in contact_changes(three) if contacts == 2)
    apart, soon = _deformations_about(three, joins)
    totals = [float(run.deformations.sum(axis=1).max()) for run in (two, three)]
    energies = [float(run.elastic_energy.max()) for run in (two, three)]
    first, last = two.final_velocity[0], three.final_velocity[0]
    more = [big / small - 1 for small, big in (totals, energies)]
    facts = [
        (
            abs(first) < _ROUNDING * two.tower.speed,
            f"of two particles the grain ends at {abs(first):.3f} m/s",
        ),
        (last < 0, f"of three it ends at {last:.3f} m/s"),
        (
            apart < _ROUNDING and soon[1] > soon[0] > soon[2],
            f"grain and second deform alike until the third joins at {joins:.3f} t0, then the "
            "second most and the third least",
        ),
        (more[0] > 0, f"the largest total deformation changes by {100 * more[0]:+.1f} %"),
        (more[1] > 0, f"the largest energy stored changes by {100 * more[1]:+.1f} %"),
    ]
    return (two, three), claim_of_facts(SOURCES["fig-6"], facts)


def _deformations_about(run: TowerRun, joins: float) -> tuple[float, list[float]]:
    """Return the largest difference of grain and second before ``joins`` [t0], and all soon after.

    The difference is over the largest deformation; soon is a hundredth of t0.
    """
    deformations = run.deformations / run.deformations.max()
    before = run.time_over_t0 < joins
    apart = float(np.abs(deformations[before, 0] - deformations[before, 1]).max())
    soon = int(np.searchsorted(run.time_over_t0, joins + 0.01))
    return apart, [float(d) for d in deformations[soon]]


FALLS = -0.01
"""Power of the stiffness below which an error falls; at it, by a tenth over ten decades."""


def error_against_stiffness() -> tuple[Mapping[str, Curve], Statement]:
    """Measure the error of the peak deformation over k, by rules for the step, and judge its trend.

    The source does not say how it chose the step. Beside the error of RK4 stands
    that of a prediction without gravity for a run with it, which does fall.
    """
    curves = {
        SCALED_STEP: error_over_stiffness(STIFFNESSES, lambda _: 50.0),
        FIXED_STEP: error_over_stiffness(STIFFNESSES, lambda case: case.contact_period / 1e-4),
        SHRINKING_STEP: error_over_stiffness(STIFFNESSES, _shrinking),
        GRAVITY: (STIFFNESSES, [_gravity_left_out(k) for k in STIFFNESSES]),
    }
    slopes = {name: slope_order(*curve) for name, curve in curves.items()}
    at_claim = {name: float(np.interp(CLAIMED_STIFFNESS, *curve)) for name, curve in curves.items()}

    facts = []
    for name in (SCALED_STEP, FIXED_STEP):
        _, (_, high) = slopes[name]
        facts.append((high < FALLS, f"the error goes as k^{_n(slopes, name)} ({name})"))
        said = f"at 1e4 N/m it is {100 * at_claim[name]:.2g} % ({name})"
        facts.append((at_claim[name] < CLAIMED_ERROR, said))
    return curves, claim_of_facts(
        SOURCES["fig-7"],
        facts,
        _what_falls(slopes, at_claim),
        holds=all_hold(facts[:2]) or all_hold(facts[2:]),
    )


def _what_falls(slopes: Mapping[str, Slope], at_claim: Mapping[str, float]) -> str:
    """Return which other readings of the error decrease with the stiffness."""
    said = [
        f"{name} (k^{_n(slopes, name)}, {100 * at_claim[name]:.2g} % at 1e4 N/m)"
        for name in (SHRINKING_STEP, GRAVITY)
        if slopes[name][1][1] < FALLS
    ]
    return f"What falls with k: {'; '.join(said)}." if said else "No other reading falls with k."


def _n(slopes: Mapping[str, Slope], name: str) -> str:
    return f"{slopes[name][0]:.2f}".replace("-0.00", "0.00")


def _shrinking(case: Tower) -> float:
    stiffness = case.each("stiffness")[0]
    return case.contact_period / (1e-5 * 1e5 / stiffness)


def _gravity_left_out(stiffness: float) -> float:
    """Return by how much gravity deepens the peak of a grain on a fixed particle, relative."""
    case = Tower(height=1, stiffness=stiffness)
    run = tower(case, solver="exact", duration=1.0)
    predicted = case.speed * math.sqrt(1.0 / stiffness)
    return float(run.compression.max()) / predicted - 1.0
