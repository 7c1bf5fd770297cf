"""How the figures look: colours that survive colour blindness, line styles that survive grey."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

# Okabe and Ito (2008), ordered so that neighbours differ in grey too
BLACK, RED, BLUE, GREEN, PURPLE, ORANGE, SKY = (
    "#000000",
    "#D55E00",
    "#0072B2",
    "#009E73",
    "#CC79A7",
    "#E69F00",
    "#56B4E9",
)
COLOURS = (BLACK, RED, BLUE, GREEN, PURPLE, ORANGE, SKY)
STYLES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)))
MARKERS = ("o", "s", "^", "D", "v", "x")

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


@contextmanager
def house_style() -> Iterator[None]:
    """Apply the look within a block, without a display."""
    import matplotlib as mpl

    with mpl.rc_context(_RC):
        yield


def panels(rows: int, columns: int, width: float = 4.2, height: float = 3.0) -> Figure:
    """Return a figure with ``rows`` by ``columns`` axes, sizes in inches for each."""
    figure = Figure(figsize=(width * columns, height * rows), layout="constrained")
    figure.subplots(rows, columns, squeeze=False)
    return figure


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


def legend_below(figure: Figure, columns: int = 2, axes: Sequence[Axes] | None = None) -> None:
    """Put one legend below all panels, each name once: inside a panel it would hide lines."""
    found: dict[str, Any] = {}
    for one in axes or figure.axes:
        for handle, name in zip(*one.get_legend_handles_labels(), strict=True):
            found.setdefault(name, handle)
    figure.legends.clear()
    if found:
        place: dict[str, Any] = {"loc": "outside lower center", "fontsize": "small"}
        figure.legend([*found.values()], [*found], ncols=columns, **place)


def few_ticks(axes: Axes, values: Sequence[float], most: int = 6) -> None:
    """Mark about ``most`` of sorted values on a logarithmic axis x, written in full."""
    chosen = list(values)[:: max(1, -(-len(values) // most))]
    axes.set_xticks(chosen, [f"{value:.0f}" for value in chosen])
    axes.minorticks_off()


def named(law: str, solver: str) -> str:
    """Return model and solver for a legend."""
    return f"{law} law, {solver}"


def power(value: Any) -> str:
    """Return a number for a legend: ``1e6``, and ``3.2e5`` between the powers of ten."""
    mantissa, exponent = f"{value:.1e}".split("e")
    return f"{float(mantissa):g}e{int(exponent)}"
