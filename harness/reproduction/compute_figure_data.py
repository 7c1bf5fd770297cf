"""All figures of the source, recomputed: what to draw them from, and what agrees."""

from __future__ import annotations

from collections.abc import Mapping

from harness.cases.tower.impulse_angles import impulse_angles
from harness.engines.contract import Engine
from harness.observables.reference import ReferencePoints
from harness.observables.trajectory import Trajectory
from harness.reproduction import heights, schematics
from harness.reproduction.claims import Statement, untestable
from harness.reproduction.collapse import collapse
from harness.reproduction.collisions import error_against_stiffness, two_and_three_particles
from harness.reproduction.figure_data import AgainstHeight, Exhibits
from harness.reproduction.recorded_motion import recorded_motions
from harness.reproduction.source_figures import FIGURES
from harness.reproduction.towers_in_time import towers_in_time
from harness.reproduction.velocity_series import velocity_series
from harness.reproduction.window_choice import structure_window, window_selection
from harness.workflows.progress import Progress, silent

_STAGES = 6


def exhibits(
    engine: Engine | None,
    progress: Progress = silent,
    *,
    recorded: Mapping[tuple[int, float], Trajectory] | None = None,
    reference: ReferencePoints | None = None,
) -> Exhibits:
    """Recompute the source's figures; return evidence and statements in their order.

    ``engine`` runs the incline; without it, or if it fails, that figure cannot be
    tested and keeps the recorded runs. ``recorded`` are MFiX runs by (steps per
    contact time, angle [deg]), those of the harness if not given. ``reference``
    are measured angles of the user's, for what the source compares with others.
    """
    done = 0

    def tell() -> None:
        nonlocal done
        done += 1
        progress("figures of the source", done, _STAGES)

    quartier, fig_2 = schematics.quartier()
    shock, fig_3 = schematics.force_diagrams()
    layers, fig_5 = schematics.layers()
    tell()
    motions, fig_4 = velocity_series(engine, recorded_motions() if recorded is None else recorded)
    tell()
    collisions, fig_6 = two_and_three_particles()
    peak_errors, fig_7 = error_against_stiffness()
    tell()
    towers, (fig_8, fig_14) = towers_in_time()
    collapsed, fig_9 = collapse()
    tell()
    impulses = impulse_angles(solver="exact")
    scaling, fig_13 = heights.energy_scaling()
    tell()
    structure, fig_15 = structure_window()
    windows, fig_16 = window_selection()
    tell()
    statements = (
        heights.thin_layers(reference),
        fig_2,
        fig_3,
        fig_4,
        fig_5,
        fig_6,
        fig_7,
        fig_8,
        fig_9,
        heights.impulse_ratio(impulses),
        heights.critical_angles(impulses, reference),
        contact_network(),
        fig_13,
        fig_14,
        fig_15,
        fig_16,
    )
    return Exhibits(
        quartier,
        shock,
        layers,
        motions,
        collisions,
        peak_errors,
        towers,
        collapsed,
        AgainstHeight(impulses, scaling, structure, reference),
        windows,
        statements,
    )


def contact_network() -> Statement:
    """Return the row of the one figure that shows nothing of the source's own."""
    return untestable(
        FIGURES["fig-12"].source,
        "a figure of others (Papadopoulos et al. 2018), shown as an illustration: the source "
        "computes nothing from it, and towers and incline have no two-dimensional packing",
    )
