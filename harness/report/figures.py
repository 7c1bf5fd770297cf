"""Figures: their look, their files, and films of discs.

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
import math
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from subprocess import CalledProcessError
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib import figure as mpl_figure
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.collections import EllipseCollection
from matplotlib.colors import Normalize
from matplotlib.ticker import EngFormatter, FuncFormatter
from numpy.typing import NDArray

from harness.errors import RequestError
from harness.files import Writer, held_folder

if TYPE_CHECKING:
    from harness.report.content import Discs

Floats = NDArray[np.float64]
Range = tuple[float, float]

# Okabe and Ito (2008), ordered so that neighbours differ in grey too
BLACK, RED, BLUE, GREEN = "#000000", "#D55E00", "#0072B2", "#009E73"
PURPLE, ORANGE, SKY = "#CC79A7", "#E69F00", "#56B4E9"
COLOURS = (BLACK, RED, BLUE, GREEN, PURPLE, ORANGE, SKY)
STYLES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)))
MARKERS = ("o", "s", "^", "D", "v", "x")
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
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
    for line in (axes.xaxis, axes.yaxis):
        if line.get_scale() == "log":
            line.set_major_formatter(FuncFormatter(_decade))
    if title:
        axes.set_title(title, fontsize="medium")
    axes.grid(visible=True, alpha=0.25)


def _decade(value: float, _: int) -> str:
    """Return the text of a tick: typeset as mathematics it would take 15 ms, each."""
    exponent = f"{math.log10(value):.9g}"
    return f"{value:g}" if "." in exponent else f"10{exponent.translate(SUPERSCRIPTS)}"


def legend_below(figure: mpl_figure.Figure, columns: int = 2) -> None:
    """Put one legend below all panels, each name once: within a panel it would hide lines."""
    handles: dict[str, Any] = {}
    for panel in figure.axes:
        for handle, name in zip(*panel.get_legend_handles_labels(), strict=True):
            handles.setdefault(name, handle)
    figure.legends.clear()
    if handles:
        place: dict[str, Any] = {"loc": "outside lower center", "fontsize": "small"}
        figure.legend([*handles.values()], [*handles], ncols=columns, **place)


# ---- files of figures, the same bytes for the same content

VARYING = {"svg": "Date", "png": "Software", "pdf": "CreationDate"}  # metadata, by kind
LONG_LINE = 1000  # characters, of which most are of places
REPLACEMENTS = (  # parts of matplotlib's SVG that a browser does not need
    (r"<\?xml.*?\?>|<!DOCTYPE.*?>|<metadata>.*?</metadata>|<!--.*?-->", ""),
    (r"font-family: [^;\"]*(?:; ?)?", ""),
    (r' style="" ?', ""),
    (r' transform="rotate\(-0[^"]*\)"', ""),
    (r' id="(?:figure|axes|axis|patch|line2d|text|xtick|ytick|legend|matplotlib)[^"]*"', ""),
    (r"(?<=[;:]) (?=[^<>]*>)", ""),  # in styles, not in text
    (r"\s*\n\s*", "\n"),
    (r">\n<", "><"),
)


def figure_files(draw: Callable[[], mpl_figure.Figure], *, png: bool = False) -> tuple[str, bytes]:
    """Return a figure in the house style as SVG, and as PNG where it is requested."""
    with house_style():
        figure = draw()
        _lay_out(figure)
        svg = _compact(_file(figure, "svg").decode())
        return svg, _file(figure, "png") if png else b""


def _lay_out(figure: mpl_figure.Figure) -> None:
    """Place the parts of a figure once, by the widths of texts in SVG: saving would draw twice."""
    FigureCanvasSVG(figure)
    if (layout := figure.get_layout_engine()) is not None:
        layout.execute(figure)
        figure.set_layout_engine("none")  # None is the engine of the house style


def figure_writer(draw: Callable[[], mpl_figure.Figure]) -> Writer:
    """Return a function that writes a figure in the house style to a path, by its suffix."""

    def write(path: Path) -> None:
        with house_style():
            path.write_bytes(_file(draw(), path.suffix.lower().removeprefix(".")))

    return write


def _file(figure: mpl_figure.Figure, kind: str) -> bytes:
    target = io.BytesIO()
    figure.savefig(target, format=kind, metadata={VARYING[kind]: None})
    return target.getvalue()


def _compact(svg: str) -> str:
    """Return an SVG of matplotlib without metadata, each style once, to hundredths of a point."""
    for pattern, replacement in REPLACEMENTS:
        svg = re.sub(pattern, replacement, svg, flags=re.DOTALL)
    svg = re.sub(r"<[^>]*>", lambda match: _with_short_numbers(match[0]), svg)
    styles = dict.fromkeys(re.findall(r' style="([^"]*)"', svg))
    names = {style: f"s{number}" for number, style in enumerate(styles)}
    svg = re.sub(r' style="([^"]*)"', lambda match: f' class="{names[match[1]]}"', svg)
    fonts = ",".join(f"'{name}'" for name in FONTS)
    sheet = [f"text{{font-family:{fonts},sans-serif}}", *(f".{n}{{{s}}}" for s, n in names.items())]
    return svg.replace("</style>", " ".join(["", *sheet, "</style>"]), 1).strip()


def _with_short_numbers(tag: str) -> str:
    if len(tag) > LONG_LINE and not re.search(r' d="[^"]*[CQ]', tag):
        tag = re.sub(r"M ([-\d. \nL]+)", _by_steps, tag)
    tag = re.sub(r"(-?\d+\.\d\d)\d+", r"\1", tag)  # 1/7200 inch
    return re.sub(r"(\d)\.0+(?!\d)", r"\1", tag)


def _by_steps(line: re.Match[str]) -> str:
    """Return a long line in tenths of a point, each place by its step from the one before."""
    tenths = [round(10.0 * float(word)) for word in line[1].replace("L", " ").split()]
    steps = (end - start for start, end in zip(tenths, tenths[2:], strict=False))
    numbers = " ".join(f"{step / 10.0:g}" for step in steps)
    return f"M{tenths[0] / 10.0:g} {tenths[1] / 10.0:g}l{numbers}"


# ---- films: GIF by pillow, MP4 by ffmpeg where it is on the path, PNG for one picture

SUFFIXES = (".gif", ".mp4", ".png")
FRAMES_PER_SECOND = 20
MOST_FRAMES = 600  # half a minute: a longer GIF is too large for a page or a mail
EDGE, FIXED = "#333333", "#d5d9de"  # of discs, and within fixed ones
LONGEST_SIDE = 7.2  # inch
MARGIN = 0.03  # of the longer side


def check_film(path: Path, frames: int) -> None:
    """Raise RequestError, before any run, for a film that cannot be written to a path."""
    from matplotlib.animation import FFMpegWriter  # slow to load

    suffix = path.suffix.lower()
    reason = ""
    if suffix not in SUFFIXES:
        reason = f"must end in {', '.join(SUFFIXES)}"
    elif not path.parent.is_dir():
        reason = f"there is no folder {path.parent}"
    elif path.exists() and not path.is_file():
        reason = "is not a file"
    elif not 2 <= frames <= MOST_FRAMES:
        reason = f"{frames} frames: must be from 2 to {MOST_FRAMES}"
    elif suffix == ".mp4" and not FFMpegWriter.isAvailable():
        reason = ("MP4 needs ffmpeg, which is not on the path; install it, or name a .gif, which "
                  "needs no other program")  # fmt: skip
    if reason:
        raise RequestError(f"--film {path}: {reason}")


def write_film(discs: Discs, path: Path, frames: int) -> None:
    """Write a film of so many samples at equal times, or a PNG of the middle one.

    No half-written file remains. Raise RequestError as :func:`check_film` does, and where ffmpeg
    fails.
    """
    from matplotlib.animation import FFMpegWriter, FuncAnimation, PillowWriter

    check_film(path, frames)
    samples = film_samples(discs.time, frames).tolist()
    with house_style(), held_folder(path.parent) as folder:
        part = folder / f"film{path.suffix.lower()}"
        figure, show = disc_figure(discs)
        try:
            if part.suffix == ".png":
                show(samples[len(samples) // 2])
                figure.savefig(part, dpi=150)
            else:
                writer = FFMpegWriter if part.suffix == ".mp4" else PillowWriter
                film = FuncAnimation(figure, show, samples)
                film.save(part, writer=writer(FRAMES_PER_SECOND), dpi=100)
        except CalledProcessError as error:
            text = " ".join(str(error.stderr or "").split())[-200:]
            raise RequestError(
                f"--film {path}: ffmpeg failed with {error.returncode} {text}".rstrip()
            ) from None
        part.replace(path)


def film_samples(time: Floats, frames: int) -> NDArray[np.int64]:
    """Return the samples (at most ``frames``) nearest to equal steps of time."""
    moments = np.linspace(time[0], time[-1], min(frames, time.size))
    middles = (time[1:] + time[:-1]) / 2.0
    return np.unique(np.searchsorted(middles, moments))


def disc_figure(discs: Discs) -> tuple[Figure, Callable[[int], Any]]:
    """Return the figure of a film, and the function that moves its discs to those of a sample."""
    fixed, walls = np.reshape(discs.fixed, (-1, 3)), np.reshape(discs.lines, (-1, 2, 2))

    def joined(column: Any, moving: Any) -> Floats:
        still = np.broadcast_to(column, (len(discs.x), len(fixed)))
        return np.hstack([still, np.broadcast_to(moving, discs.x.shape)])

    x, y = joined(fixed[:, 0], discs.x), joined(fixed[:, 1], discs.y)
    radius, value = joined(fixed[:, 2], discs.radius), discs.value
    figure, axes = _film_axes(*_limits(x, y, radius, walls))
    for wall in walls:
        axes.plot(*wall.T, color=BLACK, lw=1.5)
    axes.set_title(discs.title, loc="left")
    clock = axes.set_title("", loc="right")
    zeros, colours = np.zeros(x.shape[1]), [FIXED] * len(fixed) + [SKY] * discs.x.shape[1]
    ellipses: Any = EllipseCollection(
        zeros, zeros, zeros, units="xy", offsets=np.zeros((x.shape[1], 2)), facecolors=colours,
        offset_transform=axes.transData, edgecolors=EDGE, linewidths=0.4,
    )  # fmt: skip
    axes.add_collection(ellipses)
    if value is not None:
        look = mpl.colormaps["viridis"].with_extremes(bad=FIXED)  # fixed discs have no value
        ellipses.set(cmap=look, norm=Normalize(np.nanmin(value), np.nanmax(value)))
        figure.colorbar(ellipses, ax=axes, label=discs.value_label)
        value = joined(math.nan, value)

    def show(sample: int) -> None:
        sizes = 2.0 * radius[sample]
        offsets = np.column_stack([x[sample], y[sample]])
        ellipses.set(offsets=offsets, widths=sizes, heights=sizes)
        if value is not None:
            ellipses.set_array(value[sample])
        clock.set_text(f"t = {EngFormatter('s', places=2)(discs.time[sample])}")

    show(0)
    figure.draw_without_rendering()  # lays out once; each frame would again
    figure.set_layout_engine("none")
    return figure, show


def _film_axes(x_range: Range, y_range: Range) -> tuple[Figure, Axes]:
    """Return a figure, even in pixels as films need it, and its axes with equal scales."""
    width, height = x_range[1] - x_range[0], y_range[1] - y_range[0]
    wide, tall = LONGEST_SIDE * min(1.0, width / height), LONGEST_SIDE * min(1.0, height / width)
    size = max(4.0, round(wide + 1.0, 1)), max(2.6, round(tall + 0.9, 1))
    figure = Figure(figsize=size, layout="compressed")
    axes = figure.add_subplot()
    label(axes, "x", "y")
    axes.grid(visible=False)
    axes.set(aspect="equal", xlim=x_range, ylim=y_range)
    for line in (axes.xaxis, axes.yaxis):
        line.set_major_formatter(EngFormatter("m"))
    return figure, axes


def _limits(x: Floats, y: Floats, radius: Floats, walls: Floats) -> tuple[Range, Range]:
    """Return the ranges of x and y [m] of discs and walls, with a margin."""
    edges = [
        np.concatenate([(c - radius).ravel(), (c + radius).ravel(), walls[..., n].ravel()])
        for n, c in enumerate((x, y))
    ]
    (first, last), (low, high) = [(float(np.nanmin(e)), float(np.nanmax(e))) for e in edges]
    margin = MARGIN * max(last - first, high - low)
    return (first - margin, last + margin), (low - margin, high + margin)
