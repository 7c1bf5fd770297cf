"""Figures of the findings: the step of MFiX, and the restitution."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from harness.report.figures import style
from harness.reproduction.findings import Findings


def angle_against_mfix_step(findings: Findings) -> Figure:
    """Return the critical angle in MFiX's scheme against its step factor, for each stiffness."""
    figure = style.panels(1, 1, 7.4, 4.0)
    axes = figure.axes[0]
    limits = findings.limits.set_index("stiffness_N_per_m")["critical_angle_deg"]
    small: dict[str, Any] = {"fontsize": 8.5}
    for i, (k, frame) in enumerate(findings.mfix.groupby("stiffness_N_per_m")):
        look: dict[str, Any] = {"color": style.COLOURS[i + 1]}
        axes.errorbar(
            frame["factor"], frame["euler_deg"], frame["euler_uncertainty_deg"], ls=style.STYLES[i],
            capsize=2, label=f"k = {style.power(k)} N/m, reference DEM, Euler", **look,
        )  # fmt: skip
        recorded = frame[frame["recorded_deg"].notna()]
        axes.plot(
            recorded["factor"], recorded["recorded_deg"], style.MARKERS[i], mfc="white",
            label=f"k = {style.power(k)} N/m, MFiX-DEM 21.3.2, recorded", **look,
        )  # fmt: skip
        axes.annotate(f"no step: {limits[k]:.3f}", (5600, limits[k]), va="center", **look, **small)
    closed = findings.closed_form_deg
    axes.axhline(closed, color=style.BLACK, linewidth=1, linestyle=(0, (6, 3)))
    above: dict[str, Any] = {"xytext": (0, 3), "textcoords": "offset points"}
    axes.annotate(f"closed form {closed:.4f} deg", (50, closed), **above, **small)
    axes.set_xscale("log")
    axes.set_xlim(42, 14000)
    style.label(axes, "steps in a contact time of MFiX, f", "critical angle (deg)")
    style.legend_below(figure)
    return figure


def angle_against_restitution(findings: Findings, engine: str) -> Figure:
    """Return the critical angle against the restitution: two readings, two DEMs."""
    frame = findings.restitution
    figure = style.panels(1, 1, 6.4, 3.9)
    axes = figure.axes[0]
    e = frame["restitution"]
    axes.plot(
        e, frame["kept_deg"], style.STYLES[1], color=style.COLOURS[2], label="theory, velocity kept"
    )
    axes.plot(
        e, frame["lost_deg"], style.STYLES[2], color=style.COLOURS[1], label="theory, velocity lost"
    )
    reference: dict[str, Any] = {"fmt": "o-", "color": style.BLACK, "mfc": style.BLACK, "ms": 4}
    own: dict[str, Any] = {"fmt": "s", "color": style.COLOURS[3], "mfc": "white", "ms": 8}
    for who, name, look in (
        ("reference", "reference DEM, steady motion, k = 1e6 N/m", reference),
        ("engine", f"{engine}, the same", own),
    ):
        known = frame[frame[f"{who}_deg"].notna()]
        axes.errorbar(
            known["restitution"], known[f"{who}_deg"], known[f"{who}_uncertainty_deg"], capsize=2,
            label=name, **look,
        )  # fmt: skip
    style.label(axes, "restitution e", "critical angle (deg)")
    axes.set_ylim(0, None)
    style.legend_below(figure)
    return figure
