"""The look of figures: colours, markers, panels, legends and axes.

Colours differ for colour-blind readers and in grey print; so do line styles and markers. A function
that draws a figure makes it by :func:`panels`, labels its axes by :func:`label`, and returns it:

    figure = panels(1, 2)
    left, right = figure.axes
    left.loglog(steps, errors, MARKERS[0], color=COLOURS[1], label="LAMMPS")
    label(left, axis("time step", "s"), axis("error", "deg"))
    legend_below(figure)
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
from matplotlib import figure as mpl_figure
from matplotlib.axes import Axes

from harness.report.text import power as power

# Okabe and Ito (2008), ordered so that neighbours differ in grey too
BLACK, RED, BLUE, GREEN = "#000000", "#D55E00", "#0072B2", "#009E73"
PURPLE, ORANGE, SKY = "#CC79A7", "#E69F00", "#56B4E9"
COLOURS = (BLACK, RED, BLUE, GREEN, PURPLE, ORANGE, SKY)
STYLES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)))
MARKERS = ("o", "s", "^", "D", "v", "x")
FONTS = ("DejaVu Sans", "Verdana")  # the second is as wide, where the first is not installed

LOOK: Mapping[Any, Any] = {
    "figure.dpi": 110,
    "savefig.dpi": 150,
    "figure.constrained_layout.use": True,
    "font.size": 10.5,
    "font.sans-serif": list(FONTS),
    "axes.titlesize": 11,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.formatter.useoffset": False,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "lines.linewidth": 1.5,
    "lines.markersize": 5.5,
    "svg.hashsalt": "dem-harness",  # the same figure is the same file
    "svg.fonttype": "none",  # text stays text: a third of the size of outlines
}


class Figure(mpl_figure.Figure):
    """A figure that a notebook shows without pyplot and without settings of the notebook."""

    def _repr_png_(self) -> bytes:
        target = io.BytesIO()
        with house_style():
            self.savefig(target, format="png")
        return target.getvalue()


@contextmanager
def house_style() -> Iterator[None]:
    """Apply the look within a block; no display is needed."""
    with mpl.rc_context(dict(LOOK)):
        yield


def panels(rows: int, columns: int, width: float = 4.2, height: float = 3.0) -> Figure:
    """Return a figure of ``rows`` by ``columns`` axes, each of ``width`` by ``height`` [inch]."""
    figure = Figure(figsize=(width * columns, height * rows), layout="constrained")
    figure.subplots(rows, columns, squeeze=False)
    return figure


def axis(name: str, unit: str = "") -> str:
    """Return the label of an axis, with its unit in round brackets unless it is a pure number.

    >>> axis("peak force", "N"), axis("restitution", "1")
    ('peak force (N)', 'restitution')
    """
    return name if unit in ("", "1") else f"{name} ({unit})"


def label(axes: Axes, x: str, y: str, title: str = "") -> None:
    """Label the axes, as :func:`axis` writes them, and set the title."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if title:
        axes.set_title(title, fontsize="medium")
    axes.grid(visible=True, alpha=0.25)


def legend_below(
    figure: mpl_figure.Figure, columns: int = 2, axes: Sequence[Axes] | None = None
) -> None:
    """Put one legend below all panels, each name once: within a panel it would hide lines."""
    handles: dict[str, Any] = {}
    for panel in axes or figure.axes:
        for handle, name in zip(*panel.get_legend_handles_labels(), strict=True):
            handles.setdefault(name, handle)
    figure.legends.clear()
    if handles:
        place: dict[str, Any] = {"loc": "outside lower center", "fontsize": "small"}
        figure.legend([*handles.values()], [*handles], ncols=columns, **place)
