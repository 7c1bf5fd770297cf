"""The figure of the head-on collisions."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from harness.cases.drop.checks import DropTest
from harness.cases.drop.runs import DropRun
from harness.report.figures.style import BLACK, COLOURS, MARKERS, STYLES, legend_below

SHOWN = 4.0
"""[contact times] of the motion that are drawn: later only the source's contact still changes."""


def speeds_of_collisions(made: Sequence[tuple[DropTest, DropRun]], who: str) -> Figure:
    """Draw the normal speed against time of each collision, with the expected rebound."""
    figure = Figure(figsize=(8.0, 4.2))
    axes = figure.add_subplot()
    for number, (test, run) in enumerate(
        (test, run) for test, run in made if test.quantity == "restitution"
    ):
        time = run.path.time_s / run.case.contact_time
        axes.plot(
            time,
            run.path.vy_m_per_s / run.case.speed,
            color=COLOURS[number % 7],
            ls=STYLES[number % 6],
            marker=MARKERS[number % 6],
            markevery=(number, 9),
            mfc="none",
            lw=1.1,
            label=run.case.contact.name,
        )
        axes.plot(SHOWN, test.expected, "_", color=BLACK, ms=16, clip_on=False)
    axes.set(xlabel="time (contact times)", ylabel="normal velocity over the first speed")
    axes.set_xlim(0.0, SHOWN)
    axes.set_title(f"{who}; bars: expected after the rebound")
    legend_below(figure, 3)
    return figure
