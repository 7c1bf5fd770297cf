"""The pictures: the source's figures drawn from our own runs, then those of the findings."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from harness.cases.tower.figures import impulse
from harness.cases.tower.figures import runs as chain_runs
from harness.observables.reference import PEYNEAU_ROUX
from harness.parameters.tower import Tower
from harness.report.gallery import Picture, picture
from harness.reproduction.figure_data.compute import FigureData
from harness.reproduction.figures import curves, schematics, towers
from harness.reproduction.figures.findings import angle_against_mfix_step, angle_against_restitution

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from harness.reproduction.run import Reproduction

SOLVER = "exact"
"""What made the tables over height."""


def all_pictures(found: Reproduction) -> list[Picture]:
    """Return the source's figures in their order, then two of the findings."""
    findings, engine = found.findings, found.provenance.engine.upper()
    return [
        *source_pictures(found.figure_data),
        picture(
            "finding-mfix-step",
            "Finding: the step of MFiX's scheme",
            "Critical angle of the source's contact with m/2, by our integrator in MFiX's scheme "
            "and as recorded with MFiX. The curves cross the closed form on their way to limits "
            "that only a stiffer contact brings down. Bars: resolution of the search, and where "
            "in a step a contact begins.",
            lambda: angle_against_mfix_step(findings),
        ),
        picture(
            "finding-restitution",
            "Finding: what a rebound does to the angle",
            "The two readings of the source's shock, and what a DEM does.",
            lambda: angle_against_restitution(findings, engine),
        ),
    ]


def source_pictures(data: FigureData) -> list[Picture]:
    """Return a picture for each figure of the source but those that cannot be drawn again.

    Its title names the figure that it answers, its caption is the sentence of the
    statement. There is none of the velocity series when no run of it is there.
    """
    told = {row.source.key: row for row in data.statements}
    return [
        picture(
            told[key].source.picture,
            f"{told[key].source.where.capitalize()} of the source: {told[key].source.title}",
            told[key].computed,
            draw,
        )
        for key, draw in drawings(data).items()
    ]


def drawings(data: FigureData) -> dict[str, Callable[[], Figure]]:
    """Return how to draw each figure that can be drawn, by its key."""
    reference = data.reference
    own_law = data.impulses[data.impulses["law"] == Tower().law]
    drawn: dict[str, Callable[[], Figure]] = {
        "fig-1": lambda: curves.thin_layers(PEYNEAU_ROUX, reference),
        "fig-2": lambda: schematics.quartier_system(data.quartier),
        "fig-3": lambda: schematics.force_diagrams(data.shock),
        "fig-4": lambda: curves.velocity_series(data.motions),
        "fig-5": lambda: schematics.layers(data.layers),
        "fig-6": lambda: chain_runs.velocity_and_deformation(data.collisions),
        "fig-7": lambda: curves.error_against_stiffness(data.peak_errors),
        "fig-8": lambda: towers.of_all_heights(data.towers),
        "fig-9": lambda: towers.collapse(data.collapsed),
        "fig-10": lambda: impulse.ratio_against_height(own_law, SOLVER),
        "fig-11": lambda: impulse.critical_angle_against_height(
            own_law, solver=SOLVER, published=PEYNEAU_ROUX, reference=reference
        ),
        "fig-13": lambda: impulse.energy_scaling(data.scaling, PEYNEAU_ROUX, reference=reference),
        "fig-14": lambda: towers.separation(data.towers),
        "fig-15": lambda: curves.structure_window(data.structure, PEYNEAU_ROUX, reference),
        "fig-16": lambda: towers.window_selection(data.windows),
    }
    if not data.motions:
        del drawn["fig-4"]
    return drawn
