"""Which figures a verification has, with what is to be seen in each."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from harness.cases.incline import figures as incline
from harness.cases.tower.figures import comparison as tower_comparison
from harness.cases.tower.figures import impulse
from harness.cases.tower.figures import peak_error as chain_peak_error
from harness.cases.tower.figures import runs as chain_runs
from harness.comparison.divergence import Comparison
from harness.comparison.engine_evidence import EngineEvidence
from harness.comparison.evidence import TowerEvidence
from harness.comparison.verification import Verification
from harness.observables.reference import PEYNEAU_ROUX
from harness.report.figures import divergence, engines
from harness.report.figures.style import house_style
from harness.report.vector import compact

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Picture:
    """A figure as SVG and PNG, with its title and one sentence on what it shows."""

    name: str
    title: str
    caption: str
    svg: str
    png: bytes


def pictures(found: Verification) -> Iterator[Picture]:
    """Yield the figures for which there is evidence."""
    evidence = found.incline
    closed = evidence.closed_form_deg
    if found.engines is not None:
        yield from _engine_pictures(found.engines)
    if evidence.extrapolated is not None:
        extrapolated = evidence.extrapolated
        yield picture(
            "critical-angle-extrapolation",
            "Critical angle, extrapolated",
            "Plastic contact, passage route. Left: first order in the step; open symbols are the "
            "limits. Right: those limits against the stiffness. Dashed: the closed form.",
            lambda: incline.extrapolation(extrapolated, closed),
        )
    if evidence.by_contact:
        yield picture(
            "contacts-side-by-side",
            "Three contacts side by side",
            "Bars are the range over where in a step a contact begins. The source's contact "
            "crosses the closed form on its way to a higher angle: agreement at 50 steps is a "
            "cancellation.",
            lambda: incline.contacts_side_by_side(evidence.by_contact, closed),
        )
    if evidence.motions:
        yield picture(
            "speed-against-time",
            "Speed below and above the critical angle",
            "The source's velocity figure, from LAMMPS with the source's contact.",
            lambda: incline.speed_against_time(evidence.motions),
        )
        yield picture(
            "path-over-the-bumps",
            "Path over the bumps",
            "Where the grain below the critical angle turns back.",
            lambda: incline.path_over_the_bumps(evidence.motions),
        )
    if evidence.recursion is not None:
        recursion = evidence.recursion
        yield picture(
            "energy-after-each-shock",
            "Energy after each shock",
            "Kinetic energy that survives each shock, taken from the energy at the next crest, "
            "against the recursion started from the first.",
            lambda: incline.energy_after_each_shock(recursion),
        )
    yield from _divergence_pictures(found)
    yield from _comparison_pictures(found.tower)
    yield from _impulse_pictures(found.tower)
    yield from _tower_pictures(found.tower)


def _engine_pictures(evidence: EngineEvidence) -> Iterator[Picture]:
    if evidence.angles:
        yield picture(
            "engines-critical-angle",
            "Every engine's critical angle",
            "One row for each engine and contact, with the range over where in a step a contact "
            "begins. Filled: the engine; open: the reference DEM under the same rules. The closed "
            "form belongs to the plastic contact; a kept tail lies above it by its own law.",
            lambda: engines.angles_of_engines(evidence.angles, evidence.closed_form_deg),
        )
    if evidence.convergence:
        yield picture(
            "engines-tower-error",
            "Every engine's tower error against the step",
            "Error of the grain's force against the exact propagator, overlap law; dotted lines "
            "are guides to first and second order.",
            lambda: engines.tower_error_against_step(evidence.convergence),
        )


MOST_DIVERGENCES = 6
"""Figures of divergences that a report shows; the rows name them all."""


def _divergence_pictures(found: Verification) -> Iterator[Picture]:
    for number, series in enumerate(_first_to_part(found.parted)[:MOST_DIVERGENCES], 1):
        yield picture(
            f"divergence-{number}",
            f"Where it parts: {series.case}",
            f"{series.run_label} against {series.reference_label} around the moment at which they "
            "part, and their difference over the whole record with its tolerance.",
            partial(divergence.divergence, series),
        )


def _first_to_part(parted: Sequence[Comparison]) -> list[Comparison]:
    """Return of each case the column that left its band first."""
    first: dict[str, tuple[float, Comparison]] = {}
    for series in parted:
        moment = series.divergence
        if moment is not None and moment.time < first.get(series.case, (math.inf, series))[0]:
            first[series.case] = moment.time, series
    return [series for _, series in first.values()]


def _tower_pictures(evidence: TowerEvidence) -> Iterator[Picture]:
    if evidence.collisions:
        yield picture(
            "two-and-three-particles",
            "Velocity and deformation of two and three particles",
            "The source's figure: two particles exchange their velocities; with three, the grain "
            "is thrown back, and the two others deform most, both as far, while it is away.",
            lambda: chain_runs.velocity_and_deformation(evidence.collisions),
        )
    for law, runs in evidence.by_law.items():
        yield picture(
            f"force-and-contacts-{law}",
            f"Force and contacts of the grain, {law} law",
            "A grain dropped on a tower, k = 1e6 N/m, 2 m/s. The force is in units of the largest "
            "of all four; contacts are those of the chain that begins at the grain.",
            partial(chain_runs.force_and_contacts, runs),
        )
    if evidence.collapse:
        yield picture(
            "collapse",
            "Collapse across stiffnesses",
            "Time in contact times and force in v0 sqrt(k m): what is left differs by Gamma alone.",
            lambda: chain_runs.collapse(evidence.collapse),
        )
    if evidence.peak_by_step:
        yield picture(
            "peak-deformation-error",
            "Error of the peak deformation",
            "Two free particles by RK4. At the time of the peak the error is of fifth order, since "
            "the peak is flat; read off the largest sample, it is that of the sampling, "
            "(omega h)^2 / 4. The source's error falls with the stiffness: in contact times it "
            "does not depend on k, and with one step in seconds it grows.",
            lambda: chain_peak_error.peak_error(evidence.peak_by_step, evidence.peak_by_stiffness),
        )
    if evidence.drifts:
        yield picture(
            "energy-drift",
            "Energy drift",
            "RK4 loses energy where contacts change; the exact propagator keeps it to round-off.",
            lambda: chain_runs.energy_drift_in_time(evidence.drifts),
        )


def _comparison_pictures(evidence: TowerEvidence) -> Iterator[Picture]:
    for law, comparisons in evidence.same_law.items():
        yield picture(
            f"same-law-{law}",
            f"Same law, different codes: {law}",
            "Force on the grain by LAMMPS, RK4 and the exact propagator under one law, and how "
            "far each is from the exact one.",
            partial(tower_comparison.same_law, comparisons),
        )
    if evidence.convergence:
        yield picture(
            "error-against-step",
            "Error against the step",
            "Four particles. A contact that changes within a step costs second order, in "
            "velocity Verlet and in RK4 alike.",
            lambda: tower_comparison.error_against_step(evidence.convergence),
        )
    if evidence.different_law:
        yield picture(
            "different-law",
            "Where the laws differ",
            "Overlap against deformable law, both by the exact propagator: a difference of "
            "models, not an error. They are the same law for one contact only.",
            lambda: tower_comparison.different_law(evidence.different_law),
        )


def _impulse_pictures(evidence: TowerEvidence) -> Iterator[Picture]:
    if evidence.impulses is None or evidence.scaling is None:
        return
    frame, by_gamma, scaling = evidence.impulses, evidence.by_gamma, evidence.scaling
    yield picture(
        "impulse-ratio",
        "Impulse against height",
        "alpha(n) = J(n)/J(1) of the source's six runs, turnaround window.",
        lambda: impulse.ratio_against_height(frame, "exact"),
    )
    yield picture(
        "critical-angle-against-height",
        "What it does to the critical angle",
        "The two formulas that the source prints for the rescaled shock have opposite trends: "
        "velocity lost (falling, its figure) and velocity kept (rising).",
        lambda: impulse.critical_angle_against_height(
            frame, solver="exact", published=PEYNEAU_ROUX
        ),
    )
    if evidence.ways is not None:
        ways = evidence.ways
        heights = sorted({int(n) for n in ways["height"]})
        yield picture(
            "collapse-on-gamma",
            "Impulse ratio on Gamma",
            "Three ways to the same Gamma, with other masses, stiffnesses and gravities, give the "
            "same alpha: Gamma alone matters, and alpha jumps where the window does.",
            lambda: impulse.collapse_on_gamma(ways, "exact", heights),
        )
    if by_gamma is not None:
        yield picture(
            "impulse-map",
            "Impulse ratio over height and Gamma",
            "Gamma = m g / (v0 sqrt(k m)) is the one parameter; the source's runs are marked.",
            lambda: impulse.map_over_gamma(by_gamma, "exact", sorted(set(frame["gamma"]))),
        )
    yield picture(
        "energy-scaling",
        "Energy scaling",
        "The source's estimate alpha = 1/sqrt(n), up to ten particles.",
        lambda: impulse.energy_scaling(scaling, PEYNEAU_ROUX),
    )


def picture(name: str, title: str, caption: str, draw: Callable[[], Figure]) -> Picture:
    """Return what ``draw`` draws in the house style, the same bytes for the same figure."""
    import io

    with house_style():
        figure = draw()
        # the layout is most of the work: once for both formats
        figure.draw_without_rendering()
        figure.set_layout_engine("none")
        svg, png = io.StringIO(), io.BytesIO()
        figure.savefig(svg, format="svg", metadata={"Date": None})
        figure.savefig(png, format="png", metadata={"Software": None})
    return Picture(name, title, caption, compact(svg.getvalue()), png.getvalue())
