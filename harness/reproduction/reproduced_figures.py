"""All figures of the source, recomputed: what agrees, and how each is drawn.

All figures of the source, recomputed: what agrees, and how each is drawn from our own runs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial
from typing import Any, NamedTuple

from matplotlib.figure import Figure

from harness.cases.tower import figures as impulse
from harness.cases.tower.figures import velocity_and_deformation
from harness.cases.tower.impulse import impulse_angles
from harness.engines.contract import Engine
from harness.observables.reference import PEYNEAU_ROUX, ReferencePoints, Trajectory
from harness.parameters.tower import Tower
from harness.reproduction import figure_data, schematics
from harness.reproduction import figures as drawn
from harness.reproduction.claims import Statement, untestable
from harness.reproduction.figure_data import (
    error_against_stiffness,
    recorded_motions,
    structure_window,
    two_and_three_particles,
    velocity_series,
    window_selection,
)
from harness.reproduction.schematics import collapse, force_and_contacts, separated
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
        (lambda: (True, figure_data.thin_layers(reference)),
         lambda _: drawn.thin_layers(PEYNEAU_ROUX, reference)),
        (schematics.quartier, drawn.quartier_system),
        (schematics.force_diagrams, drawn.force_diagrams),
        (lambda: velocity_series(engine, paths), drawn.velocity_series),
        (schematics.layers, drawn.layers),
        (two_and_three_particles, velocity_and_deformation),
        (error_against_stiffness, drawn.error_against_stiffness),
        (force_and_contacts, drawn.of_all_heights),
        (collapse, drawn.collapse),
        (lambda: (True, figure_data.impulse_ratio(runs())),
         lambda _: impulse.ratio_against_height(runs(), SOLVER)),
        (lambda: (True, figure_data.critical_angles(runs(), reference)),
         lambda _: impulse.critical_angle_against_height(
            runs(), solver=SOLVER, published=PEYNEAU_ROUX, reference=reference)),
        (lambda: ((), untestable("fig-12")), None),
        (figure_data.energy_scaling,
         lambda data: impulse.energy_scaling(data, PEYNEAU_ROUX, reference=reference)),
        (separated, drawn.separation),
        (structure_window, lambda data: drawn.structure_window(data, PEYNEAU_ROUX, reference)),
        (window_selection, drawn.window_selection),
    )  # fmt: skip
    made = []
    for done, (compute, draw) in enumerate(figures, 1):
        data, statement = compute()
        nothing = isinstance(data, tuple) and not data  # no runs, or a figure of others
        drawing = None if draw is None or nothing else partial(draw, data)
        made.append(SourceFigure(statement, drawing))
        progress("figures of the source", done, len(figures))
    return tuple(made)
