"""Runs of the chain solvers for the report's figures."""

from __future__ import annotations

from collections.abc import Callable

from harness.cases.tower.evidence import Curve, OwnEvidence
from harness.cases.tower.run import tower
from harness.comparison.verdicts import Check
from harness.observables.tower import TowerRun
from harness.parameters.tower import LAWS, Tower
from harness.theory.two_spheres import contact_time, peak_overlap

PARTICLES = (2, 3, 10, 20)
"""The towers of the source's figure."""

STIFFNESSES = (1e5, 1e6, 1e7)
PAIR = Tower(height=1, base="free", gravity=0.0)
"""Two free particles: harmonic, so that every error is the integrator's."""

PARTED = 1.6  # [t0] by then two and three free particles have parted for good


def chain_evidence(evidence: OwnEvidence) -> list[Check]:
    """Fill in what the chain solvers alone can show; return no rows."""
    evidence.collisions = [
        tower(PAIR.replace(height=n), solver="exact", duration=PARTED, profiles=True)
        for n in (1, 2)
    ]
    evidence.by_law = {
        law: [tower(Tower(height=n - 1, law=law), solver="exact", profiles=True) for n in PARTICLES]
        for law in LAWS
    }
    evidence.collapse = [
        tower(Tower(height=9, stiffness=k), solver="exact", samples=1500) for k in STIFFNESSES
    ]
    evidence.drifts = [
        tower(Tower(height=9, law=law), solver="rk4", steps_per_contact=steps)
        for law in LAWS
        for steps in (1000.0, 4000.0)
    ] + [tower(Tower(height=9), solver="exact")]
    _peak_errors(evidence)
    return []


def _peak_errors(evidence: OwnEvidence) -> None:
    """Measure the peak deformation of two particles by RK4, at its time and off the samples."""
    counts = [20.0 * 2.0 ** (i / 2) for i in range(9)]
    evidence.peak_by_step = {
        "at the time of the peak": _transposed([_at_the_peak(PAIR, n) for n in counts]),
        "largest sample": _transposed([_largest_sample(PAIR, n) for n in counts]),
    }
    stiffnesses = [10.0**exponent for exponent in (2.0, 3.0, 4.0, 5.0, 6.0)]
    evidence.peak_by_stiffness = {
        "step in contact times (50)": error_over_stiffness(stiffnesses, lambda _: 50.0),
        "one step for all, 1e-4 s": error_over_stiffness(
            stiffnesses, lambda case: case.contact_period / 1e-4
        ),
    }


def _transposed(points: list[tuple[float, float]]) -> Curve:
    return [x for x, _ in points], [y for _, y in points]


def error_over_stiffness(
    stiffnesses: list[float], steps_per_contact: Callable[[Tower], float]
) -> Curve:
    """Return the relative error [1] of the largest sample of two free particles over k [N/m]."""
    cases = [PAIR.replace(stiffness=stiffness) for stiffness in stiffnesses]
    return stiffnesses, [_largest_sample(case, steps_per_contact(case))[1] for case in cases]


def _at_the_peak(case: Tower, steps_per_contact: float) -> tuple[float, float]:
    """Return omega h and the relative error after half the contact, at the largest overlap."""
    half = contact_time(_one(case, "mass"), _one(case, "stiffness")) / 2
    run = tower(
        case, solver="rk4", duration=half / case.contact_time, steps_per_contact=steps_per_contact
    )
    return _omega_h(run), abs(float(run.compression[-1]) / _peak(case) - 1.0)


def _largest_sample(case: Tower, steps_per_contact: float) -> tuple[float, float]:
    """Return omega h and the relative error of the largest of all steps."""
    run = tower(
        case, solver="rk4", duration=1.0, steps_per_contact=steps_per_contact, samples=100_000
    )
    return _omega_h(run), abs(float(run.compression.max()) / _peak(case) - 1.0)


def _omega_h(run: TowerRun) -> float:
    """Return the step in 1/omega; it was made to divide the duration."""
    assert run.step is not None
    return run.step * run.tower.omega


def _peak(case: Tower) -> float:
    return peak_overlap(_one(case, "mass"), _one(case, "stiffness"), case.speed)


def _one(case: Tower, name: str) -> float:
    value = getattr(case, name)
    return float(value)
