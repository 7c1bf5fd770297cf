"""The figures of a verification of the tower, with what is to be seen in each."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from harness.cases.case_text import Words
from harness.cases.tower.comparison import SeriesComparison
from harness.cases.tower.evidence import CodeEvidence, OwnEvidence
from harness.cases.tower.figures import comparison, impulse, runs
from harness.cases.tower.figures.peak_error import peak_error
from harness.observables.reference import PEYNEAU_ROUX
from harness.report.figures.style import power
from harness.report.sections import Drawing

WORDS = Words(__file__)


def drawings(main: CodeEvidence | None, own: OwnEvidence) -> Iterator[Drawing]:
    """Yield the figures for which there is evidence."""
    yield from _comparisons(main, own)
    yield from _impulses(own)
    yield from _towers(own)


def _comparisons(main: CodeEvidence | None, own: OwnEvidence) -> Iterator[Drawing]:
    """Yield codes against the exact propagator, and law against law."""
    codes = [one for one in (main, own) if one is not None]
    for law in own.same_law:
        by_law: list[SeriesComparison] = [c for one in codes for c in one.same_law.get(law, [])]
        names = " and ".join(one.who for one in codes if law in one.same_law)
        yield WORDS.drawing(
            "same-law-{law}", partial(comparison.same_law, by_law), law=law, names=names
        )
    convergence = [found for one in codes for found in one.convergence]
    if convergence:
        yield WORDS.drawing(
            "error-against-step",
            lambda: comparison.error_against_step(convergence),
            particles=convergence[0].reference.tower.particles,
        )
    if own.different_law:
        yield WORDS.drawing("different-law", lambda: comparison.different_law(own.different_law))


def _impulses(own: OwnEvidence) -> Iterator[Drawing]:
    """Yield alpha(n) and the critical angle that it leads to."""
    if own.impulses is None or own.scaling is None:
        return
    frame, by_gamma, scaling = own.impulses, own.by_gamma, own.scaling
    yield WORDS.drawing("impulse-ratio", lambda: impulse.ratio_against_height(frame, "exact"))
    yield WORDS.drawing(
        "critical-angle-against-height",
        lambda: impulse.critical_angle_against_height(
            frame, solver="exact", published=PEYNEAU_ROUX
        ),
    )
    if own.ways is not None:
        ways = own.ways
        heights = sorted({int(n) for n in ways["height"]})
        yield WORDS.drawing(
            "collapse-on-gamma", lambda: impulse.collapse_on_gamma(ways, "exact", heights)
        )
    if by_gamma is not None:
        yield WORDS.drawing(
            "impulse-map",
            lambda: impulse.map_over_gamma(by_gamma, "exact", sorted(set(frame["gamma"]))),
        )
    yield WORDS.drawing("energy-scaling", lambda: impulse.energy_scaling(scaling, PEYNEAU_ROUX))


def _towers(own: OwnEvidence) -> Iterator[Drawing]:
    """Yield single runs in time, and the errors of RK4."""
    if own.collisions:
        yield WORDS.drawing(
            "two-and-three-particles", lambda: runs.velocity_and_deformation(own.collisions)
        )
    for law, towers in own.by_law.items():
        case = towers[0].tower
        yield WORDS.drawing(
            "force-and-contacts-{law}",
            partial(runs.force_and_contacts, towers),
            law=law,
            stiffness=power(case.stiffness),
            speed=case.speed,
        )
    if own.collapse:
        yield WORDS.drawing("collapse", lambda: runs.collapse(own.collapse))
    if own.peak_by_step:
        yield WORDS.drawing(
            "peak-deformation-error", lambda: peak_error(own.peak_by_step, own.peak_by_stiffness)
        )
    if own.drifts:
        yield WORDS.drawing("energy-drift", lambda: runs.energy_drift_in_time(own.drifts))
