"""All figures of the source, recomputed: what agrees, and how each is drawn from our own runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

from harness.cases.tower.figures import impulse
from harness.cases.tower.figures.runs import velocity_and_deformation
from harness.cases.tower.impulse_angles import impulse_angles
from harness.engines.contract import Engine
from harness.observables.reference import PEYNEAU_ROUX, ReferencePoints
from harness.observables.trajectory import Trajectory
from harness.parameters.tower import Tower
from harness.reproduction.claims import Statement, untestable
from harness.reproduction.figure_data import heights, schematics
from harness.reproduction.figure_data.collapse import collapse
from harness.reproduction.figure_data.collisions import (
    error_against_stiffness,
    two_and_three_particles,
)
from harness.reproduction.figure_data.towers_in_time import towers_in_time
from harness.reproduction.figure_data.velocity_series import recorded_motions, velocity_series
from harness.reproduction.figure_data.windows import structure_window, window_selection
from harness.reproduction.figures import curves, towers
from harness.reproduction.figures import schematics as drawn
from harness.workflows.progress import Progress, silent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SOLVER = "exact"
"""What made the tables over height."""


class SourceFigure(NamedTuple):
    """A figure of the source: its statement, and how to draw it; None where it cannot be."""

    statement: Statement
    draw: Callable[[], Figure] | None


Recorded = Mapping[tuple[int, float], Trajectory]


def source_figures(
    engine: Engine | None,
    progress: Progress = silent,
    *,
    recorded: Recorded | None = None,
    reference: ReferencePoints | None = None,
) -> tuple[SourceFigure, ...]:
    """Recompute the source's figures, in their order.

    ``engine`` runs the incline; without it, or if it fails, that figure cannot be
    tested and keeps the recorded runs. ``recorded`` are MFiX runs by (steps per
    contact time, angle [deg]), those of the harness if not given. ``reference``
    are measured angles of the user's, for what the source compares with others.
    """
    parts = (
        _schematics(),
        _motions(engine, recorded_motions() if recorded is None else recorded),
        _collisions(),
        _towers(),
        _over_height(reference),
        _windows(reference),
    )
    made: list[SourceFigure] = []
    for done, part in enumerate(parts, 1):
        made += part
        progress("figures of the source", done, len(parts))
    return tuple(sorted(made, key=lambda one: int(one.statement.source.key.removeprefix("fig-"))))


def _schematics() -> Iterator[SourceFigure]:
    system, row = schematics.quartier()
    yield SourceFigure(row, lambda: drawn.quartier_system(system))
    shock, row = schematics.force_diagrams()
    yield SourceFigure(row, lambda: drawn.force_diagrams(shock))
    layers, row = schematics.layers()
    yield SourceFigure(row, lambda: drawn.layers(layers))


def _motions(engine: Engine | None, recorded: Recorded) -> Iterator[SourceFigure]:
    motions, row = velocity_series(engine, recorded)
    yield SourceFigure(row, (lambda: curves.velocity_series(motions)) if motions else None)


def _collisions() -> Iterator[SourceFigure]:
    collisions, row = two_and_three_particles()
    yield SourceFigure(row, lambda: velocity_and_deformation(collisions))
    errors, row = error_against_stiffness()
    yield SourceFigure(row, lambda: curves.error_against_stiffness(errors))


def _towers() -> Iterator[SourceFigure]:
    found, (in_time, separation) = towers_in_time()
    yield SourceFigure(in_time, lambda: towers.of_all_heights(found))
    yield SourceFigure(separation, lambda: towers.separation(found))
    collapsed, row = collapse()
    yield SourceFigure(row, lambda: towers.collapse(collapsed))


def _over_height(reference: ReferencePoints | None) -> Iterator[SourceFigure]:
    yield SourceFigure(
        heights.thin_layers(reference), lambda: curves.thin_layers(PEYNEAU_ROUX, reference)
    )
    table = impulse_angles(solver=SOLVER, laws=(Tower().law,))
    yield SourceFigure(
        heights.impulse_ratio(table), lambda: impulse.ratio_against_height(table, SOLVER)
    )
    yield SourceFigure(
        heights.critical_angles(table, reference),
        lambda: impulse.critical_angle_against_height(
            table, solver=SOLVER, published=PEYNEAU_ROUX, reference=reference
        ),
    )
    yield SourceFigure(untestable("fig-12"), None)
    scaling, row = heights.energy_scaling()
    yield SourceFigure(
        row, lambda: impulse.energy_scaling(scaling, PEYNEAU_ROUX, reference=reference)
    )


def _windows(reference: ReferencePoints | None) -> Iterator[SourceFigure]:
    structure, row = structure_window()
    yield SourceFigure(row, lambda: curves.structure_window(structure, PEYNEAU_ROUX, reference))
    windows, row = window_selection()
    yield SourceFigure(row, lambda: towers.window_selection(windows))
