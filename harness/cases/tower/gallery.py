"""The figures of a verification of the tower, with what is to be seen in each."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from harness.cases.tower.comparison import SeriesComparison
from harness.cases.tower.evidence import CodeEvidence, OwnEvidence
from harness.cases.tower.figures import comparison, impulse, runs
from harness.cases.tower.figures.peak_error import peak_error
from harness.observables.reference import PEYNEAU_ROUX
from harness.report.figures.style import power
from harness.report.sections import Drawing


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
        yield Drawing(
            f"same-law-{law}",
            f"Same law, different codes: {law}",
            f"Force on the grain by {names} and the exact propagator under one law, and how far "
            "each is from the exact one.",
            partial(comparison.same_law, by_law),
        )
    convergence = [found for one in codes for found in one.convergence]
    if convergence:
        yield Drawing(
            "error-against-step",
            "Error against the step",
            f"{convergence[0].reference.tower.particles} particles. A contact that changes within "
            "a step costs second order, whatever the order of the scheme.",
            lambda: comparison.error_against_step(convergence),
        )
    if own.different_law:
        yield Drawing(
            "different-law",
            "Where the laws differ",
            "Overlap against deformable law, both by the exact propagator: a difference of "
            "models, not an error. They are the same law for one contact only.",
            lambda: comparison.different_law(own.different_law),
        )


def _impulses(own: OwnEvidence) -> Iterator[Drawing]:
    """Yield alpha(n) and the critical angle that it leads to."""
    if own.impulses is None or own.scaling is None:
        return
    frame, by_gamma, scaling = own.impulses, own.by_gamma, own.scaling
    yield Drawing(
        "impulse-ratio",
        "Impulse against height",
        "alpha(n) = J(n)/J(1) of the source's six runs, turnaround window.",
        lambda: impulse.ratio_against_height(frame, "exact"),
    )
    yield Drawing(
        "critical-angle-against-height",
        "What it does to the critical angle",
        "The two formulas that the source prints for the rescaled shock have opposite trends: "
        "velocity lost (falling, its figure) and velocity kept (rising).",
        lambda: impulse.critical_angle_against_height(
            frame, solver="exact", published=PEYNEAU_ROUX
        ),
    )
    if own.ways is not None:
        ways = own.ways
        heights = sorted({int(n) for n in ways["height"]})
        yield Drawing(
            "collapse-on-gamma",
            "Impulse ratio on Gamma",
            "Three ways to the same Gamma, with other masses, stiffnesses and gravities, give the "
            "same alpha: Gamma alone matters, and alpha jumps where the window does.",
            lambda: impulse.collapse_on_gamma(ways, "exact", heights),
        )
    if by_gamma is not None:
        yield Drawing(
            "impulse-map",
            "Impulse ratio over height and Gamma",
            "Gamma = m g / (v0 sqrt(k m)) is the one parameter; the source's runs are marked.",
            lambda: impulse.map_over_gamma(by_gamma, "exact", sorted(set(frame["gamma"]))),
        )
    yield Drawing(
        "energy-scaling",
        "Energy scaling",
        "The source's estimate alpha = 1/sqrt(n), up to ten particles.",
        lambda: impulse.energy_scaling(scaling, PEYNEAU_ROUX),
    )


def _towers(own: OwnEvidence) -> Iterator[Drawing]:
    """Yield single runs in time, and the errors of RK4."""
    if own.collisions:
        yield Drawing(
            "two-and-three-particles",
            "Velocity and deformation of two and three particles",
            "The source's figure: two particles exchange their velocities; with three, the grain "
            "is thrown back, and the two others deform most, both as far, while it is away.",
            lambda: runs.velocity_and_deformation(own.collisions),
        )
    for law, towers in own.by_law.items():
        case = towers[0].tower
        yield Drawing(
            f"force-and-contacts-{law}",
            f"Force and contacts of the grain, {law} law",
            f"A grain dropped on a tower, k = {power(case.stiffness)} N/m, {case.speed:g} m/s. The "
            "force is in units of the largest of all; contacts are those of the chain that begins "
            "at the grain, felt above 1e-6 of the peak.",
            partial(runs.force_and_contacts, towers),
        )
    if own.collapse:
        yield Drawing(
            "collapse",
            "Collapse across stiffnesses",
            "Time in contact times and force in v0 sqrt(k m): what is left differs by Gamma alone.",
            lambda: runs.collapse(own.collapse),
        )
    if own.peak_by_step:
        yield Drawing(
            "peak-deformation-error",
            "Error of the peak deformation",
            "Two free particles by RK4, with the measured orders. At the time of the peak the "
            "order is one higher, since the peak is flat; read off the largest sample, the error "
            "is that of the sampling, (omega h)^2 / 4. The source's error falls with the "
            "stiffness: in contact times it does not depend on k, and with one step in seconds it "
            "grows.",
            lambda: peak_error(own.peak_by_step, own.peak_by_stiffness),
        )
    if own.drifts:
        yield Drawing(
            "energy-drift",
            "Energy drift",
            "RK4 loses energy where contacts change; the exact propagator keeps it to round-off.",
            lambda: runs.energy_drift_in_time(own.drifts),
        )
