"""The look of figures, and those that several kinds of result share."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from matplotlib import figure as mpl_figure
from matplotlib.axes import Axes

_RC: dict[Any, Any] = {
    "figure.dpi": 110,
    "savefig.dpi": 150,
    "figure.constrained_layout.use": True,
    "font.size": 10.5,
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
    # the same figure is the same file; its text is text, a third of the bytes of drawn letters,
    # and Verdana, which is as wide, stands in where there is no DejaVu
    "svg.hashsalt": "dem-harness",
    "svg.fonttype": "none",
    "font.sans-serif": ["DejaVu Sans", "Verdana"],
}


class Figure(mpl_figure.Figure):
    """A figure that a notebook shows by itself, without pyplot or a setting of the notebook."""

    def _repr_png_(self) -> bytes:
        target = io.BytesIO()
        with house_style():
            self.savefig(target, format="png")
        return target.getvalue()


@contextmanager
def house_style() -> Iterator[None]:
    """Apply the look within a block, without a display."""
    import matplotlib as mpl

    with mpl.rc_context(_RC):
        yield


def quantity(name: str, unit: str = "") -> str:
    """Return the name of an axis with its unit in round brackets; a pure number has none.

    >>> quantity("peak force", "N"), quantity("restitution", "1")
    ('peak force (N)', 'restitution')
    """
    return f"{name} ({unit})" if unit not in ("", "1") else name


def label(axes: Axes, x: str, y: str, title: str = "") -> None:
    """Name the axes, as :func:`quantity` writes them."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if title:
        axes.set_title(title, fontsize="medium")
    axes.grid(visible=True, alpha=0.25)


def beside_tolerance(groups: Mapping[str, Sequence[float]], x: str) -> Figure:
    """Draw how far rows are off in units of what they may be, a line for each group.

    ``groups`` maps a name to differences over tolerances [1]; the dashed line is the limit. What
    is not off at all stands at the left edge, what is NaN is left out.
    """
    figure = Figure(figsize=(7.0, 1.4 + 0.5 * max(1, len(groups))), layout="constrained")
    axes = figure.add_subplot()
    finite = {name: np.abs(_finite(values)) for name, values in groups.items()}
    every = np.concatenate([np.empty(0), *finite.values()])
    least = every[every > 0].min(initial=1.0) / 3
    for place, values in enumerate(finite.values()):
        spread = place + np.linspace(-0.3, 0.3, values.size)
        axes.plot(np.maximum(values, least), spread, "o", ms=3, mfc="none", color="#0072B2")
    axes.axvline(1.0, color="black", ls="--", lw=1)
    axes.set(xscale="log", ylim=(max(1, len(groups)) - 0.5, -0.5))
    axes.set_yticks(range(len(groups)), [f"{name} ({v.size})" for name, v in finite.items()])
    label(axes, x, "rows, counted")
    return figure


def _finite(values: Sequence[float]) -> np.ndarray:
    numbers = np.asarray(list(values), dtype=float)
    return np.asarray(numbers[np.isfinite(numbers)])
