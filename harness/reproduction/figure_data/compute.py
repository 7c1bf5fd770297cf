"""All figures of the source, recomputed: what agrees, and how each is drawn from our own runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial
from typing import Any, NamedTuple

from matplotlib.figure import Figure

from harness.cases.tower.figures import impulse
from harness.cases.tower.figures.runs import velocity_and_deformation
from harness.cases.tower.impulse_angles import impulse_angles
from harness.engines.contract import Engine
from harness.observables.reference import PEYNEAU_ROUX, ReferencePoints
from harness.observables.trajectory import Trajectory
from harness.parameters.tower import Tower
from harness.reproduction.claims import Statement, untestable
from harness.reproduction.figure_data import heights, schematics
from harness.reproduction.figure_data.collisions import (
    error_against_stiffness,
    two_and_three_particles,
)
from harness.reproduction.figure_data.towers_in_time import collapse, force_and_contacts, separated
from harness.reproduction.figure_data.velocity_series import recorded_motions, velocity_series
from harness.reproduction.figure_data.windows import structure_window, window_selection
from harness.reproduction.figures import curves, towers
from harness.reproduction.figures import schematics as drawn
from harness.workflows.progress import Progress, silent

SOLVER = "exact"
"""What made the tables over height."""


Compute = Callable[[], tuple[Any, Statement]]
"""Return what a figure is drawn from, empty where there is nothing, and its statement."""

Draw = Callable[[Any], Figure] | None


class SourceFigure(NamedTuple):
    """A figure of the source: its statement, and how to draw it; None where it cannot be."""

    statement: Statement
    draw: Callable[[], Figure] | None


def source_figures(
    engine: Engine | None,
    progress: Progress = silent,
    *,
    recorded: Mapping[tuple[int, float], Trajectory] | None = None,
    reference: ReferencePoints | None = None,
) -> tuple[SourceFigure, ...]:
    """Recompute the source's figures, in their order.

    ``engine`` runs the incline; without it, or if it fails, that figure cannot be
    tested and keeps the recorded runs. ``recorded`` are MFiX runs by (steps per
    contact time, angle [deg]), those of the harness if not given. ``reference``
    are measured angles of the user's, for what the source compares with others.
    """
    runs = cache(lambda: impulse_angles(solver=SOLVER, laws=(Tower().law,)))
    paths = recorded_motions() if recorded is None else recorded
    # of each what it is drawn from with its statement, and how it is drawn from that
    figures: tuple[tuple[Compute, Draw], ...] = (
        (lambda: (True, heights.thin_layers(reference)),
         lambda _: curves.thin_layers(PEYNEAU_ROUX, reference)),
        (schematics.quartier, drawn.quartier_system),
        (schematics.force_diagrams, drawn.force_diagrams),
        (lambda: velocity_series(engine, paths), curves.velocity_series),
        (schematics.layers, drawn.layers),
        (two_and_three_particles, velocity_and_deformation),
        (error_against_stiffness, curves.error_against_stiffness),
        (force_and_contacts, towers.of_all_heights),
        (collapse, towers.collapse),
        (lambda: (True, heights.impulse_ratio(runs())),
         lambda _: impulse.ratio_against_height(runs(), SOLVER)),
        (lambda: (True, heights.critical_angles(runs(), reference)),
         lambda _: impulse.critical_angle_against_height(
            runs(), solver=SOLVER, published=PEYNEAU_ROUX, reference=reference)),
        (lambda: ((), untestable("fig-12")), None),
        (heights.energy_scaling,
         lambda data: impulse.energy_scaling(data, PEYNEAU_ROUX, reference=reference)),
        (separated, towers.separation),
        (structure_window, lambda data: curves.structure_window(data, PEYNEAU_ROUX, reference)),
        (window_selection, towers.window_selection),
    )  # fmt: skip
    made = []
    for done, (compute, draw) in enumerate(figures, 1):
        data, statement = compute()
        nothing = isinstance(data, tuple) and not data  # no runs, or a figure of others
        drawing = None if draw is None or nothing else partial(draw, data)
        made.append(SourceFigure(statement, drawing))
        progress("figures of the source", done, len(figures))
    return tuple(made)
