"""How the tower is shown: sections of a report, the figure of angles, and a film."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import TYPE_CHECKING

import numpy as np

from harness.cases.bench import Bench
from harness.cases.tower.impulse import impulse_angles, source_angles
from harness.cases.tower.parameters import LAWS
from harness.cases.tower.runs import TowerRun
from harness.report.content import Discs, Drawing, Opening, Section, power

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from harness.theory.chain import Reading

TALLEST = 19
QUASI_STATIC = (5.76, 0.22)  # [deg] frictionless spheres, Peyneau and Roux (2008), PRE 78, 011307
LARGEST_DRAWN = 0.32  # [diameters] the largest compression in a film
FIGURE = "critical-angle-over-contacts"
TITLE = "What does a column of grains below do to that angle?"

OPENING = """\
In a well the velocity turns; what is left after the shock decides from which angle on the motion
persists. The source asks how a column of grains below the well changes that. Without friction the
answer rests on the impulse alone, and on how its formula is read.

A tower has no dissipation, so that every engine with a linear spring runs the same physics. Each is
compared with the exact propagator, and at equal steps against an independent program. Under the
overlap law, which DEM codes use, every contact presses with its own overlap. Under the deformable
law of the source a particle pressed on both sides gives way on both: a contact behind a compressed
one opens or closes at another time. They are the same law for one contact only."""


def sections(benches: Mapping[str, Bench]) -> list[Section]:  # noqa: ARG001 - as of every case
    """Return what a tower does to the critical angle."""
    drawing = Drawing(
        FIGURE,
        "The critical angle over the contacts below",
        "k = 1e6 N/m, 2 m/s, exact propagator, turnaround window. Solid: the impulse rescales the "
        "velocity lost; dashed: the velocity run. The band is measured in other work.",
        lambda: angle_figure(
            impulse_angles(
                heights=range(1, TALLEST + 1), stiffnesses=(1e6,), speeds=(2.0,), solver="exact"
            )
        ),
    )
    return [Section(TITLE, OPENING, drawings=(drawing,), opening=_opening())]


def _opening() -> Opening:
    first = source_angles(1, "overlap")["lost"]
    last = {law: source_angles(TALLEST, law)["lost"] for law in LAWS}
    return Opening(
        title=TITLE,
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
        figure=FIGURE,
    )


def angle_figure(
    frame: pd.DataFrame,
    *,
    readings: Sequence[Reading] = ("lost", "kept"),
    measured: tuple[Sequence[float], Sequence[float]] | None = None,
) -> Figure:
    """Draw critical angles of a table of ``impulse_angles`` against height, a panel a law.

    ``measured`` are heights in diameters and angles [deg] from elsewhere.
    """
    from harness.report.figures import BLACK, COLOURS, STYLES, label, legend_below, panels

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
