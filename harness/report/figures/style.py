"""What the figures share: colours that survive colour blindness and grey, line styles."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

# Okabe and Ito (2008), ordered so that neighbours differ in grey too
COLOURS = ("#000000", "#D55E00", "#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
STYLES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)))
MARKERS = ("o", "s", "^", "D", "v", "x")


def panels(rows: int, columns: int, width: float = 4.2, height: float = 3.0) -> Figure:
    """Return a figure with ``rows`` by ``columns`` axes, sizes in inches for each."""
    figure = Figure(figsize=(width * columns, height * rows), layout="constrained")
    figure.subplots(rows, columns, squeeze=False)
    return figure


def label(axes: Axes, x: str, y: str, title: str = "") -> None:
    """Name the axes, units in brackets."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if title:
        axes.set_title(title, fontsize="medium")
    axes.grid(visible=True, alpha=0.25)


def named(law: str, solver: str) -> str:
    """Return model and solver for a legend."""
    return f"{law} law, {solver}"
