"""All figures of the source, recomputed: what to draw them from, and what agrees."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from harness.cases.tower.evidence import Curve
from harness.cases.tower.impulse_angles import impulse_angles
from harness.engines.contract import Engine
from harness.observables.reference import ReferencePoints
from harness.observables.tower import TowerRun
from harness.observables.trajectory import Trajectory
from harness.reproduction.claims import Statement, untestable
from harness.reproduction.figure_data import heights, schematics
from harness.reproduction.figure_data.collapse import collapse
from harness.reproduction.figure_data.collisions import (
    error_against_stiffness,
    two_and_three_particles,
)
from harness.reproduction.figure_data.towers_in_time import TowersInTime, towers_in_time
from harness.reproduction.figure_data.velocity_series import (
    VelocitySeries,
    recorded_motions,
    velocity_series,
)
from harness.reproduction.figure_data.windows import (
    WindowChoice,
    structure_window,
    window_selection,
)
from harness.reproduction.source import FIGURES
from harness.workflows.progress import Progress, silent

_STAGES = 6


@dataclass(frozen=True)
class FigureData:
    """What the source's figures are drawn from, and one statement a figure in their order.

    ``impulses``, ``scaling`` and ``structure`` are tables of alpha(n) and the critical angle;
    ``reference`` are a user's points of others.
    """

    quartier: schematics.QuartierSystem
    shock: tuple[schematics.ForceDiagram, ...]
    layers: tuple[schematics.Layers, ...]
    motions: tuple[VelocitySeries, ...]
    collisions: tuple[TowerRun, ...]
    peak_errors: Mapping[str, Curve]
    towers: TowersInTime
    collapsed: tuple[TowerRun, ...]
    impulses: pd.DataFrame
    scaling: pd.DataFrame
    structure: pd.DataFrame
    windows: tuple[WindowChoice, ...]
    reference: ReferencePoints | None
    statements: tuple[Statement, ...]


def figure_data(
    engine: Engine | None,
    progress: Progress = silent,
    *,
    recorded: Mapping[tuple[int, float], Trajectory] | None = None,
    reference: ReferencePoints | None = None,
) -> FigureData:
    """Recompute the source's figures; return what they are drawn from, and statements.

    ``engine`` runs the incline; without it, or if it fails, that figure cannot be
    tested and keeps the recorded runs. ``recorded`` are MFiX runs by (steps per
    contact time, angle [deg]), those of the harness if not given. ``reference``
    are measured angles of the user's, for what the source compares with others.
    """

    def tell(done: int) -> None:
        progress("figures of the source", done, _STAGES)

    rows: dict[int, Statement] = {1: heights.thin_layers(reference)}
    quartier, rows[2] = schematics.quartier()
    shock, rows[3] = schematics.force_diagrams()
    layers, rows[5] = schematics.layers()
    tell(1)
    motions, rows[4] = velocity_series(engine, recorded_motions() if recorded is None else recorded)
    tell(2)
    collisions, rows[6] = two_and_three_particles()
    peak_errors, rows[7] = error_against_stiffness()
    tell(3)
    towers, (rows[8], rows[14]) = towers_in_time()
    collapsed, rows[9] = collapse()
    tell(4)
    impulses = impulse_angles(solver="exact")
    rows[10] = heights.impulse_ratio(impulses)
    rows[11] = heights.critical_angles(impulses, reference)
    rows[12] = untestable(FIGURES["fig-12"])
    scaling, rows[13] = heights.energy_scaling()
    tell(5)
    structure, rows[15] = structure_window()
    windows, rows[16] = window_selection()
    tell(6)
    return FigureData(
        quartier,
        shock,
        layers,
        motions,
        collisions,
        peak_errors,
        towers,
        collapsed,
        impulses,
        scaling,
        structure,
        windows,
        reference,
        tuple(rows[number] for number in sorted(rows)),
    )
