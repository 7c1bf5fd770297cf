"""Figures of the findings: the step of MFiX, and the restitution."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from harness.report.figures.style import (
    BLACK,
    COLOURS,
    MARKERS,
    STYLES,
    label,
    legend_below,
    panels,
    power,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from harness.reproduction.findings import Findings


def angle_against_mfix_step(findings: Findings) -> Figure:
    """Return the critical angle in MFiX's scheme against its step factor, for each stiffness."""
    figure = panels(1, 1, 7.4, 4.0)
    axes = figure.axes[0]
    limits = dict(
        zip(
            findings.limits["stiffness_N_per_m"], findings.limits["critical_angle_deg"], strict=True
        )
    )
    for number, (k, frame) in enumerate(findings.mfix.groupby("stiffness_N_per_m"), 1):
        colour = COLOURS[number]
        axes.errorbar(
            frame["factor"],
            frame["euler_deg"],
            frame["euler_uncertainty_deg"],
            color=colour,
            linestyle=STYLES[number - 1],
            capsize=2,
            label=f"k = {power(k)} N/m, reference DEM, Euler",
        )
        recorded = frame[frame["recorded_deg"].notna()]
        axes.plot(
            recorded["factor"],
            recorded["recorded_deg"],
            MARKERS[number - 1],
            color=colour,
            markerfacecolor="white",
            label=f"k = {power(k)} N/m, MFiX-DEM 21.3.2, recorded",
        )
        axes.annotate(
            f"no step: {limits[k]:.3f}", (5600, limits[k]), color=colour, fontsize=8.5, va="center"
        )
    axes.axhline(findings.closed_form_deg, color=BLACK, linewidth=1, linestyle=(0, (6, 3)))
    axes.annotate(
        f"closed form {findings.closed_form_deg:.4f} deg",
        (50, findings.closed_form_deg),
        xytext=(0, 3),
        textcoords="offset points",
        fontsize=8.5,
    )
    axes.set_xscale("log")
    axes.set_xlim(42, 14000)
    label(axes, "steps in a contact time of MFiX, f", "critical angle (deg)")
    legend_below(figure)
    return figure


def angle_against_restitution(findings: Findings, engine: str) -> Figure:
    """Return the critical angle against the restitution: two readings, two DEMs."""
    frame = findings.restitution
    figure = panels(1, 1, 6.4, 3.9)
    axes = figure.axes[0]
    e = frame["restitution"]
    axes.plot(e, frame["kept_deg"], STYLES[1], color=COLOURS[2], label="theory, velocity kept")
    axes.plot(e, frame["lost_deg"], STYLES[2], color=COLOURS[1], label="theory, velocity lost")
    _bars(axes, frame, "reference", "o-", BLACK, "reference DEM, steady motion, k = 1e6 N/m")
    _bars(axes, frame, "engine", "s", COLOURS[3], f"{engine}, the same")
    label(axes, "restitution e", "critical angle (deg)")
    axes.set_ylim(0, None)
    legend_below(figure)
    return figure


def _bars(axes: object, frame: pd.DataFrame, who: str, form: str, colour: str, name: str) -> None:
    from matplotlib.axes import Axes

    assert isinstance(axes, Axes)
    known = frame[frame[f"{who}_deg"].notna()]
    axes.errorbar(
        known["restitution"],
        known[f"{who}_deg"],
        known[f"{who}_uncertainty_deg"],
        fmt=form,
        color=colour,
        markerfacecolor="white" if form == "s" else colour,
        markersize=8 if form == "s" else 4,
        capsize=2,
        label=name,
    )
