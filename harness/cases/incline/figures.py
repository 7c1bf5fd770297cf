"""Draw the incline: angles over step and stiffness, paths, shocks, engines beside theory."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator

from harness.cases.incline.levels import ENGINES_PLASTIC
from harness.cases.incline.system import InclineRun, Motion
from harness.report import style
from harness.report.style import BLACK, BLUE, RED, label, legend_below, power

if TYPE_CHECKING:
    from harness.cases.incline.angle import CriticalAngle, ExtrapolatedAngle
    from harness.cases.incline.checks import Recursion
    from harness.cases.incline.engine_checks import EngineAngle


FATES = {Motion.MOVES_ON: "keeps moving", Motion.TRAPPED: "trapped", Motion.UNDECIDED: "undecided"}


def speed_against_time(runs: Sequence[InclineRun], engine_name: str) -> style.Figure:
    """Draw speed against time below and above the critical angle (the source's velocity figure)."""
    figure = style.Figure(figsize=(8.0, 3.6))
    axes = figure.add_subplot()
    for run, colour, line in zip(runs, (style.ORANGE, style.BLUE), ("--", "-"), strict=False):
        path = run.path
        name = f"{run.case.angle:.2f} deg: {FATES[run.motion]}"
        axes.plot(path.time_s, path.speed_m_per_s, line, color=colour, lw=1.1, label=name)
    axes.set(xlabel="time (s)", ylabel="speed of the grain (m/s)", ylim=(0, None))
    axes.set_title(_conditions(runs[0], engine_name))
    axes.margins(x=0.01)
    style.legend_below(figure)
    return figure


BUMPS = 6
"""Spheres of the row in the figure of a path."""


def path_over_the_bumps(runs: Sequence[InclineRun]) -> style.Figure:
    """Draw the path of the grain's centre over the row of fixed spheres, to scale."""
    figure = style.Figure(figsize=(8.0, 3.0))
    axes = figure.add_subplot()
    diameter = runs[0].case.diameter
    start = _last_well(runs) - BUMPS / 2
    for index in range(int(start) - 1, int(start) + BUMPS + 2):
        axes.add_patch(
            Circle((index, 0), 0.5, facecolor="#e8e8e8", edgecolor="#888888", lw=0.8, zorder=1)
        )
    styles = zip(reversed(runs), (style.SKY, style.BLACK), ("-", "--"), (4.0, 1.3), strict=False)
    for run, colour, line, width in styles:
        path = run.path
        name = f"{run.case.angle:.2f} deg: {FATES[run.motion]}"
        axes.plot(
            path.x_m / diameter, path.y_m / diameter, ls=line, lw=width, color=colour, label=name
        )
        if run.motion is Motion.TRAPPED:
            end = (path.x_m[-1] / diameter, path.y_m[-1] / diameter)
            axes.plot(*end, "o", color=colour, ms=6, zorder=3)
            axes.annotate("turns back", end, xytext=(0, 9), textcoords="offset points", ha="center")
    _draw_gravity(axes, start + 0.45, runs[0].case.angle)
    axes.set(
        xlim=(start, start + BUMPS),
        ylim=(-0.15, 1.42),
        aspect="equal",
        xlabel="along the row (diameters)",
        ylabel="above it (diameters)",
    )
    axes.grid(visible=False)
    axes.set_title("path of the grain's centre; drawn with the row level, gravity tilted")
    style.legend_below(figure)
    return figure


def _draw_gravity(axes: Axes, x: float, angle_deg: float) -> None:
    """Draw the direction of gravity as an arrow between the grain's path and the row."""
    tilt = np.radians(angle_deg)
    axes.annotate(
        "",
        (x + 0.3 * np.sin(tilt), 1.35 - 0.3 * np.cos(tilt)),
        xytext=(x, 1.35),
        arrowprops={"arrowstyle": "-|>", "color": style.BLACK},
    )
    axes.text(x - 0.06, 1.2, "g", ha="right", va="center", style="italic")


def extrapolation(
    extrapolated: ExtrapolatedAngle, closed_form: float, engine_name: str
) -> style.Figure:
    """Draw the critical angle against the step, and its limits against the stiffness."""
    figure = style.Figure(figsize=(7.2, 4.1))
    step_axes, stiffness_axes = figure.subplots(1, 2)
    for number, (stiffness, limit) in enumerate(extrapolated.at_stiffness.items()):
        colour, marker = style.COLOURS[number % 6], style.MARKERS[number % 6]
        name = f"k = {style.power(stiffness)} N/m"
        step_axes.errorbar(
            limit.h, limit.y, limit.errors, fmt=marker, color=colour, label=name, capsize=2
        )
        fine = np.linspace(0, limit.h.max(), 50)
        step_axes.plot(fine, limit.curve(fine), color=colour, lw=0.9)
        step_axes.plot(0, limit.value, marker, color=colour, mfc="white", clip_on=False)
    step_axes.axhline(closed_form, color=style.BLACK, ls="--", lw=1)
    step_axes.set(xlabel="1 / steps per contact time", ylabel="critical angle (deg)")
    step_axes.set_title("step to zero")
    _stiffness_panel(stiffness_axes, extrapolated, closed_form, engine_name)
    step_axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    style.legend_below(figure, 3)
    return figure


def _stiffness_panel(
    axes: Axes, extrapolated: ExtrapolatedAngle, closed_form: float, engine_name: str
) -> None:
    rigid = extrapolated.rigid
    axes.errorbar(
        1 / rigid.h,
        rigid.y,
        rigid.errors,
        fmt="o",
        color=style.BLUE,
        capsize=2,
        label=f"{engine_name}, step to zero",
    )
    fine = np.geomspace(rigid.h.min() / 30, rigid.h.max(), 100)
    order = f"observed order {rigid.order:.2f}"
    axes.plot(1 / fine, rigid.curve(fine), color=style.BLUE, lw=0.9, label=f"fit, {order}")
    axes.axhspan(
        rigid.value - rigid.uncertainty,
        rigid.value + rigid.uncertainty,
        color=style.GREEN,
        alpha=0.25,
        label=f"limit {rigid.value:.5f} ± {rigid.uncertainty:.5f} deg",
    )
    axes.axhline(
        closed_form, color=style.BLACK, ls="--", lw=1, label=f"theory {closed_form:.5f} deg"
    )
    axes.set(xscale="log", xlabel="stiffness k (N/m)", ylabel="critical angle (deg)")
    axes.set_title("then stiffness to infinity")


def contacts_side_by_side(
    by_contact: dict[str, list[CriticalAngle]], closed_form: float
) -> style.Figure:
    """Draw the critical angle over step and stiffness, one panel a contact."""
    titles = {
        "source": "source: e = 1e-20, tail kept",
        "clipped": "clipped: critical damping",
        "plastic": "plastic: overdamped, clipped",
    }
    names = [name for name in titles if name in by_contact]
    figure = style.Figure(figsize=(9.6, 3.9))
    panels = figure.subplots(1, len(names), squeeze=False)[0]
    stiffnesses = sorted({a.case.stiffness for name in names for a in by_contact[name]})
    decades = [k for k in stiffnesses if abs(np.log10(k) - round(np.log10(k))) < 1e-9]
    for axes, name in zip(panels, names, strict=True):
        for number, stiffness in enumerate(decades):
            angles = sorted(
                (a for a in by_contact[name] if a.case.stiffness == stiffness),
                key=lambda a: a.case.steps_per_contact,
            )
            if not angles:
                continue
            axes.errorbar(
                [a.case.steps_per_contact for a in angles],
                [a.value_deg for a in angles],
                [a.uncertainty_deg for a in angles],
                color=style.COLOURS[number % 6],
                marker=style.MARKERS[number % 6],
                ls=style.STYLES[number % 6],
                lw=1,
                capsize=2,
                label=f"k = {style.power(stiffness)} N/m",
            )
        axes.axhline(closed_form, color=style.BLACK, ls="--", lw=1, label="theory")
        axes.set(xscale="log", xlabel="steps per contact time")
        axes.set_title(titles[name], fontsize=10)
        axes.set_xticks([25, 50, 100, 200, 400], ["25", "50", "100", "200", "400"])
        axes.minorticks_off()
        axes.margins(x=0.12)
    panels[0].set_ylabel("critical angle (deg)")
    style.legend_below(figure, 4)
    return figure


def energy_after_each_shock(recursion: Recursion, engine_name: str) -> style.Figure:
    """Draw the energy after each shock against the recursion, with the difference below."""
    figure = style.Figure(figsize=(6.6, 4.2))
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    shocks = np.arange(1, len(recursion.measured) + 1)
    case = recursion.run.case
    top.plot(shocks, recursion.predicted, "--", color=style.BLACK, label="E[j+1] = (E[j] + dE) / 4")
    top.plot(
        shocks,
        recursion.measured,
        "o",
        color=style.BLUE,
        label=_conditions(recursion.run, engine_name),
    )
    top.set_ylabel("energy after the shock\n(m g d)")
    top.set_title(f"{case.angle:g} deg, above the critical angle")
    bottom.plot(shocks, 1e6 * (recursion.measured - recursion.predicted), "o", color=style.BLUE)
    bottom.axhline(0, color=style.BLACK, ls="--", lw=1)
    bottom.set(xlabel="shock", ylabel="difference\n(1e-6 m g d)")
    bottom.set_xticks(shocks)
    style.legend_below(figure)
    return figure


def runs_of_an_angle(angle: CriticalAngle) -> style.Figure:
    """Draw the margin of each run against its angle, or its fate where it has no margin."""
    figure = style.Figure(figsize=(6.4, 3.9), layout="constrained")
    axes = figure.add_subplot()
    margins = np.array([sample.margin for sample in angle.samples])
    fates = [Motion(sample.motion) for sample in angle.samples]
    angles = [sample.angle_deg for sample in angle.samples]
    if np.isfinite(margins).all():
        axes.plot(angles, margins, "o", color=style.BLUE, mfc="none", label="runs")
        axes.axhline(0, color="0.6", lw=0.8)
        y = "energy left over the next crest (m g d)"
    else:
        kinds = [*FATES]
        axes.plot(
            angles, [kinds.index(f) for f in fates], "o", color=style.BLUE, mfc="none", label="runs"
        )
        axes.set_yticks(range(len(kinds)), [*FATES.values()])
        y = "what became of the grain"
    low, high = angle.value_deg - angle.uncertainty_deg, angle.value_deg + angle.uncertainty_deg
    axes.axvspan(low, high, color=style.GREEN, alpha=0.25, label="uncertainty")
    axes.axvline(angle.value_deg, color=style.BLACK, ls="--", lw=1, label="critical angle")
    style.label(axes, "angle (deg)", y, f"{angle.provenance.label}, {angle.method}")
    style.legend_below(figure, 3)
    return figure


def _last_well(runs: Sequence[InclineRun]) -> float:
    """Return where the trapped run ends, in diameters; else the end of the first run."""
    run = next((r for r in runs if r.motion is Motion.TRAPPED), runs[0])
    return float(run.path.x_m[-1] / run.case.diameter)


def _conditions(run: InclineRun, engine_name: str) -> str:
    case = run.case
    return (
        f"{engine_name}, {case.contact.name} contact, k = {style.power(case.stiffness)} N/m, "
        f"{case.steps_per_contact:g} steps per contact"
    )


WIDTH_DEG = ENGINES_PLASTIC.absolute
"""Half the shaded band: what the plastic contact may be off the closed form."""

LOOKS = {"clipped": (BLUE, "o"), "attractive": (RED, "s")}
"""Colour and marker of a tail."""


def angles_of_engines(angles: Sequence[EngineAngle], closed_form: float) -> Figure:
    """Draw one row for each engine and contact: its angle, the reference's, and theory.

    All at the stiffness and step of the first angle. Left all of them; right those near the closed
    form, whose band can be seen there.
    """
    angles = _comparable(angles)
    figure = Figure(figsize=(9.6, 1.5 + 0.34 * len(angles)), layout="constrained")
    full, near = figure.subplots(1, 2, sharey=True, width_ratios=(1.15, 1))
    for axes in (full, near):
        axes.axvspan(
            closed_form - WIDTH_DEG,
            closed_form + WIDTH_DEG,
            color="0.82",
            label=f"± {WIDTH_DEG:g} deg",
        )
        axes.axvline(closed_form, color=BLACK, ls="--", lw=1, label="closed form")
        _rows(axes, angles)
        axes.grid(visible=True, axis="x", alpha=0.4)
    full.set_yticks(range(len(angles)), [_row_name(angle) for angle in angles])
    full.invert_yaxis()
    first = angles[0]
    at = f"k = {power(first.stiffness)} N/m, {first.steps_per_contact:.3g} steps per contact"
    label(full, "critical angle (deg)", "", at)
    label(near, "off the closed form (1e-3 deg)", "", "near the closed form")
    span = 3.0 * WIDTH_DEG
    near.set_xlim(closed_form - span, closed_form + span)
    ticks = np.array([-9, -6, -3, 0, 3, 6, 9])
    near.set_xticks(closed_form + 1e-3 * ticks, [f"{tick:+d}" if tick else "0" for tick in ticks])
    _beyond(near, angles, closed_form, span)
    legend_below(figure, 5)
    return figure


def _comparable(angles: Sequence[EngineAngle]) -> list[EngineAngle]:
    """Return the angles at the first one's stiffness and step, contact by contact."""
    first = angles[0]
    at = (first.stiffness, first.steps_per_contact)
    chosen = [a for a in angles if (a.stiffness, a.steps_per_contact) == at]
    contacts = list(dict.fromkeys(a.contact.name for a in chosen))
    return sorted(chosen, key=lambda a: contacts.index(a.contact.name))


def _rows(axes: Axes, angles: Sequence[EngineAngle]) -> None:
    for row, angle in enumerate(angles):
        colour, marker = LOOKS[angle.contact.tail]
        if not math.isnan(angle.reference_deg):
            axes.plot(
                angle.reference_deg,
                row,
                "D",
                ms=10,
                mfc="none",
                mec=BLACK,
                mew=0.9,
                zorder=2,
                label="reference DEM, same rules",
            )
        axes.errorbar(
            angle.value,
            row,
            xerr=angle.uncertainty,
            fmt=marker,
            color=colour,
            ms=5,
            capsize=3,
            zorder=3,
            label=f"engine, {angle.contact.tail} tail",
        )


def _beyond(axes: Axes, angles: Sequence[EngineAngle], closed_form: float, span: float) -> None:
    """Say at the edge where an angle is that the narrow panel does not hold."""
    for row, angle in enumerate(angles):
        off = angle.value - closed_form
        if abs(off) > span:
            right = off > 0
            axes.annotate(
                f"{1e3 * off:+.0f} →" if right else f"← {1e3 * off:+.0f}",
                (closed_form + math.copysign(0.97 * span, off), row),
                ha="right" if right else "left",
                va="center",
                fontsize=8.5,
                color="0.25",
            )


def _row_name(angle: EngineAngle) -> str:
    return f"{angle.who}: {angle.contact.name}"
