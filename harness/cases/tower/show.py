"""How the tower is shown: its sections of a report with figures, and a film."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import TYPE_CHECKING

import numpy as np

from harness.cases.bench import OWN, Bench
from harness.cases.tower.checks import setup
from harness.cases.tower.impulse import impulse_angles, source_angles
from harness.cases.tower.parameters import LAWS, Law
from harness.cases.tower.runs import TowerRun
from harness.cases.tower.windows import WINDOWS, impulse, peak_force
from harness.errors import EngineError
from harness.report.content import Discs, Drawing, Opening, Section, Table

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from harness.theory.chain import Reading

SHOWN = 2  # height of the tower whose force is drawn: three particles, the source's example
TALLEST = 19
TABLE_HEIGHTS = (2, 3, 10, 19)
QUASI_STATIC = (5.76, 0.22)  # [deg] frictionless spheres, Peyneau and Roux (2008), PRE 78, 011307
LARGEST_DRAWN = 0.32  # [diameters] the largest compression in a film

OPENING = """\
In a well the velocity turns; what is left after the shock decides from which angle on the motion
persists. The source asks how a column of grains below the well changes that. Without friction the
answer rests on the impulse alone, and on how its formula is read."""

ENGINES = """\
A tower has no dissipation, so that every engine with a linear spring runs the same physics. Each is
compared with the exact propagator, and at equal steps against an independent program. Under the
overlap law, which DEM codes use, every contact presses with its own overlap. Under the deformable
law of the source a particle pressed on both sides gives way on both: a contact behind a compressed
one opens or closes at another time. They are the same law for one contact only."""


def sections(benches: Mapping[str, Bench]) -> list[Section]:
    """Return what a tower does to the critical angle, and the force on the grain by engines."""
    return [
        Section(
            "What does a column of grains below do to that angle?",
            OPENING,
            tables=(
                Table(
                    "Both laws",
                    angle_table(),
                    "Impulse ratio in the turnaround window and critical angle, k = 1e6 N/m, "
                    "2 m/s; exact.",
                ),
            ),
            drawings=(
                Drawing(
                    "critical-angle-over-contacts",
                    "The critical angle over the contacts below",
                    "k = 1e6 N/m, 2 m/s, exact propagator, turnaround window. Solid: the impulse "
                    "rescales the velocity lost; dashed: the velocity run. The band is measured "
                    "in other work.",
                    lambda: angle_figure(_angles()),
                ),
                Drawing(
                    "impulse-ratio",
                    "Impulse against height",
                    "alpha(n) = J(n)/J(1) at k = 1e6 N/m and 2 m/s by the exact propagator, in "
                    "three windows; crosses: engines, turnaround window.",
                    lambda: ratio_figure(_angles(), benches),
                ),
            ),
            opening=_opening(),
        ),
        Section(
            "Towers of the engines",
            ENGINES,
            drawings=tuple(_force_drawing(law, benches) for law in LAWS),
        ),
    ]


def _opening() -> Opening:
    first = source_angles(1, "overlap")["lost"]
    last = {law: source_angles(TALLEST, law)["lost"] for law in LAWS}
    return Opening(
        title="What does a column of grains below do to that angle?",
        sketch=files(__package__).joinpath("sketch.svg").read_text(encoding="utf-8"),
        steps=(
            "A grain that falls on n contacts in a row takes the impulse J(n) from them; "
            "alpha = J(n) / J(1).",
            "The velocity lost in a well is rescaled by alpha: after it 1 - alpha / 2 of the "
            "velocity is left, in place of 1/2.",
            "So θ_c(n) = 2 atan(tan(15 deg) alpha / (4 - alpha)): "
            f"{first:.2f} deg for one contact, {last['overlap']:.2f} (overlap law) and "
            f"{last['deformable']:.2f} deg (deformable law) for {TALLEST}. "
            "Read the other way, as velocity kept, the same alpha makes it rise.",
        ),
        source="Harper, Dufek and Breard (arXiv:2409.13633)",
        terms=(
            ("overlap law", "each contact presses with its own overlap, as DEM codes have it"),
            (
                "deformable law",
                "the source's: a particle pressed on both sides gives way on both",
            ),
            (
                "window",
                "the time over which the force is summed; turnaround: twice the time of the "
                "largest compression",
            ),
            ("t0", "the time that a contact with one fixed particle lasts"),
        ),
        figure="critical-angle-over-contacts",
    )


def angle_table() -> pd.DataFrame:
    """Return alpha and the critical angle of both readings [deg] over height and law."""
    frame = _angles(TABLE_HEIGHTS)
    names = {
        "height": "height", "law": "law", "impulse_ratio": "alpha",
        "critical_angle_lost_deg": "velocity lost (deg)",
        "critical_angle_kept_deg": "velocity kept (deg)",
    }  # fmt: skip
    frame = frame[frame["window"] == "turnaround"][[*names]].rename(columns=names)
    return frame.round({"alpha": 6, "velocity lost (deg)": 4, "velocity kept (deg)": 4})


def _angles(heights: Sequence[int] = tuple(range(1, TALLEST + 1))) -> pd.DataFrame:
    return impulse_angles(
        heights=heights, stiffnesses=(1e6,), speeds=(2.0,), windows=WINDOWS, solver="exact"
    )


# ---- figures


def angle_figure(
    frame: pd.DataFrame,
    *,
    readings: Sequence[Reading] = ("lost", "kept"),
    measured: tuple[Sequence[float], Sequence[float]] | None = None,
) -> Figure:
    """Draw critical angles of a table of ``impulse_angles`` against height, a panel a law.

    ``measured`` are heights in diameters and angles [deg] from elsewhere.
    """
    from harness.report.style import BLACK, COLOURS, STYLES, label, legend_below, panels, power

    laws = list(dict.fromkeys(frame["law"]))
    figure = panels(1, len(laws))
    for axes, law in zip(figure.axes, laws, strict=True):
        part = frame[(frame["law"] == law) & (frame["window"] == frame["window"].iloc[0])]
        groups = part.groupby(["stiffness_N_per_m", "speed_m_per_s"], sort=False)
        for colour, ((k, speed), run) in enumerate(groups, 1):
            for style, reading in zip(STYLES, readings, strict=False):
                axes.plot(
                    run["height"],
                    run[f"critical_angle_{reading}_deg"],
                    color=COLOURS[colour % len(COLOURS)],
                    linestyle=style,
                    marker=".",
                    label=f"velocity {reading}, k = {power(k)} N/m, {speed:g} m/s",
                )
        middle, half = QUASI_STATIC
        axes.axhspan(
            middle - half, middle + half, color="0.85", label="quasi-static, Peyneau and Roux 2008"
        )
        if measured is not None:
            axes.plot(*measured, "x", color=BLACK, label="measured")
        label(axes, "height (contacts)", "critical angle (deg)", f"{law} law")
    legend_below(figure)
    return figure


def ratio_figure(frame: pd.DataFrame, benches: Mapping[str, Bench]) -> Figure:
    """Draw alpha against height in each window, a panel a law, with points of engines."""
    from harness.report.style import COLOURS, MARKERS, label, legend_below, panels

    figure = panels(1, len(LAWS))
    for axes, law in zip(figure.axes, LAWS, strict=True):
        part = frame[frame["law"] == law]
        for i, (window, rows) in enumerate(part.groupby("window", sort=False)):
            axes.plot(rows["height"], rows["impulse_ratio"], color=COLOURS[i], label=window)
        for i, name in enumerate(benches):
            runs = [_engine_run(benches[name], law, n) for n in (1, SHOWN)]
            if all(run is not None for run in runs):
                ratio = impulse(runs[1]) / impulse(runs[0])  # type: ignore[arg-type]
                marker = MARKERS[i % len(MARKERS)]
                axes.plot([SHOWN], [ratio], marker, color=COLOURS[3 + i % 4], label=name)
        label(axes, "height (contacts)", "impulse ratio alpha", f"{law} law")
    legend_below(figure, 3)
    return figure


def _force_drawing(law: Law, benches: Mapping[str, Bench]) -> Drawing:
    return Drawing(
        f"force-{law}",
        f"Force on the grain, {law} law",
        "Three particles, k = 1e6 N/m, 2 m/s, 1000 steps per contact: the exact force, and how far "
        "engines are from it, over its peak.",
        lambda: force_figure(law, benches),
    )


def force_figure(law: Law, benches: Mapping[str, Bench]) -> Figure:
    """Draw the exact force on the grain, and the differences of engines from it."""
    from harness.report.style import BLACK, COLOURS, STYLES, label, legend_below, panels

    figure = panels(2, 1, width=6.0, height=2.2)
    top, bottom = figure.axes
    exact = setup(law, SHOWN).exact()
    peak = peak_force(exact)
    top.plot(exact.time_over_t0, exact.grain_force / 1e3, color=BLACK, label="exact propagator")
    for i, (name, bench) in enumerate(benches.items(), 1):
        run = _engine_run(bench, law, SHOWN)
        if run is not None:
            wanted = np.interp(run.time, exact.time, exact.grain_force)
            (line,) = bottom.plot(run.time_over_t0, (run.grain_force - wanted) / peak, label=name)
            line.set(color=COLOURS[i % len(COLOURS)], linestyle=STYLES[i % len(STYLES)])
    label(top, "", "force (kN)", f"{law} law")
    label(bottom, "time (t0)", "difference over the peak")
    legend_below(figure, 3)
    return figure


def _engine_run(bench: Bench, law: Law, height: int) -> TowerRun | None:
    """Return the run that the checks made, None where there is none."""
    one = setup(law, height)
    if bench.name == OWN or not bench.has_run([one.job]):
        return None
    try:
        return one.run(bench)
    except EngineError:
        return None


# ---- film


def discs(run: TowerRun) -> Discs:
    """Return the particles of a run, with displacements and deformations drawn larger.

    All by one factor, so that the drawn boundaries touch where the particles do. Under the
    deformable law particles are drawn shortened; under the overlap law they overlap.
    """
    case = run.tower
    diameter = np.array(case.each("diameter"))
    largest = max(float(run.deformations.max()), 1e-300)
    factor = LARGEST_DRAWN * float(diameter.min()) / largest
    shortened = factor * run.deformations if case.law == "deformable" else 0.0
    touching = np.cumsum(diameter) - (diameter + diameter[0]) / 2
    force = np.pad(run.forces, ((0, 0), (1, 1)))
    x = touching + factor * run.displacements
    return Discs(
        title=f"tower of height {case.height}, {case.law} law, displacements {factor:.3g} times",
        time=run.time,
        x=x,
        y=np.zeros_like(x),
        radius=np.broadcast_to(0.5 * (diameter - shortened), x.shape),
        value=np.maximum(force[:, 1:], force[:, :-1]),
        value_label="largest force on a particle (N)",
    )
