"""The figures of the source, each drawn from our own runs, with what agrees and what does not."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from harness.cases.tower.figures import impulse
from harness.cases.tower.figures import runs as chain_runs
from harness.observables.reference import PEYNEAU_ROUX
from harness.parameters.tower import Tower
from harness.report.gallery import Picture, picture
from harness.reproduction.figure_data import Exhibits
from harness.reproduction.figures import heights, peak_error, schematics, towers, velocity_series
from harness.reproduction.source_figures import FIGURES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SOLVER = "exact"
"""What made the tables over height."""

SOURCE_LAW = Tower().law


def source_pictures(exhibits: Exhibits) -> list[Picture]:
    """Return a picture for each figure of the source but those that cannot be drawn again.

    Its title names the figure that it answers, its caption is the sentence of the
    statement. There is none of the velocity series when no run of it is there.
    """
    told = {statement.source.key: statement for statement in exhibits.statements}
    return [
        picture(
            FIGURES[key].picture,
            f"Figure {FIGURES[key].number} of the source: {FIGURES[key].title}",
            told[key].computed,
            draw,
        )
        for key, draw in drawings(exhibits).items()
    ]


def drawings(exhibits: Exhibits) -> dict[str, Callable[[], Figure]]:
    """Return how to draw each figure that can be drawn, by its key."""
    over, reference = exhibits.heights, exhibits.heights.reference
    own_law = over.impulses[over.impulses["law"] == SOURCE_LAW]
    drawn: dict[str, Callable[[], Figure]] = {
        "fig-1": lambda: heights.thin_layers(PEYNEAU_ROUX, reference),
        "fig-2": lambda: schematics.quartier_system(exhibits.quartier),
        "fig-3": lambda: schematics.force_diagrams(exhibits.shock),
        "fig-4": lambda: velocity_series.velocity_series(exhibits.motions),
        "fig-5": lambda: schematics.layers(exhibits.layers),
        "fig-6": lambda: chain_runs.velocity_and_deformation(exhibits.collisions),
        "fig-7": lambda: peak_error.error_against_stiffness(exhibits.peak_errors),
        "fig-8": lambda: towers.of_all_heights(exhibits.towers),
        "fig-9": lambda: towers.collapse(exhibits.collapsed),
        "fig-10": lambda: impulse.ratio_against_height(own_law, SOLVER),
        "fig-11": lambda: impulse.critical_angle_against_height(
            own_law, solver=SOLVER, published=PEYNEAU_ROUX, reference=reference
        ),
        "fig-13": lambda: impulse.energy_scaling(over.scaling, PEYNEAU_ROUX, reference=reference),
        "fig-14": lambda: towers.separation(exhibits.towers),
        "fig-15": lambda: heights.structure_window(over.structure, PEYNEAU_ROUX, reference),
        "fig-16": lambda: towers.window_selection(exhibits.windows),
    }
    if not exhibits.motions:
        del drawn["fig-4"]
    return drawn
