"""Draw what a report shows: figures, small plots and films, the same bytes for the same content.

Figures are matplotlib's, over the cores, and their SVG is compacted: fewer digits, each style
once. The plots of cell pages come from a template, in milliseconds each. Films are GIFs of
:mod:`harness.report.film`.
"""

from __future__ import annotations

import io
import math
import multiprocessing
import os
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote
from xml.etree import ElementTree as Xml

from markupsafe import Markup

from harness.files import end_with
from harness.report.film import Film, base64_uri, gif, png
from harness.report.markdown import environment
from harness.report.plain import one_line, safe_path
from harness.report.sections import CellText, Drawing, Line, Plot, Section
from harness.report.style import COLOURS, house_style, lay_out, plain_powers

if TYPE_CHECKING:
    from matplotlib.figure import Figure


WIDTH, HEIGHT = 520.0, 330.0
LEFT, RIGHT, TOP, BOTTOM = 74.0, 12.0, 12.0, 48.0
DASHES = ("", "7 3", "2 3", "8 3 2 3")
MOST_DECADES = 6
"""Ticks of a logarithmic axis, about."""


@dataclass(frozen=True)
class Axis:
    """A scale from values to places in the picture, with its ticks: place and word."""

    place: Callable[[float], float]
    ticks: tuple[tuple[float, str], ...]


@dataclass(frozen=True)
class Shape:
    """A line as the template draws it: pieces of a polyline, or points."""

    name: str
    colour: str
    dash: str
    marked: bool
    pieces: tuple[tuple[tuple[float, float], ...], ...]


def svg(plot: Plot) -> str:
    """Return a plot as an SVG element with its legend's colours; empty without a finite point."""
    points = [point for line in plot.lines for point in _finite(line, plot.logarithmic)]
    if not points:
        return ""
    xs, ys = zip(*points, strict=True)
    axis = _logarithmic if plot.logarithmic else _linear
    x = axis(min(xs), max(xs), LEFT, WIDTH - RIGHT)
    y = axis(min(ys), max(ys), HEIGHT - BOTTOM, TOP)
    return (
        environment()
        .get_template("plot.svg.j2")
        .render(
            plot=plot,
            shapes=[_shape(number, line, plot, x, y) for number, line in enumerate(plot.lines)],
            x=x,
            y=y,
            frame=(LEFT, TOP, WIDTH - RIGHT, HEIGHT - BOTTOM),
            size=(WIDTH, HEIGHT),
        )
    )


def _shape(number: int, line: Line, plot: Plot, x: Axis, y: Axis) -> Shape:
    pieces: list[list[tuple[float, float]]] = [[]]
    for at_x, at_y in zip(line.x, line.y, strict=True):
        if _drawable(at_x, at_y, plot.logarithmic):
            pieces[-1].append((round(x.place(at_x), 1), round(y.place(at_y), 1)))
        elif pieces[-1]:
            pieces.append([])
    return Shape(
        line.name,
        COLOURS[number % len(COLOURS)],
        DASHES[number % len(DASHES)],
        line.marked,
        tuple(tuple(piece) for piece in pieces if piece),
    )


def _drawable(x: float, y: float, logarithmic: bool) -> bool:
    return math.isfinite(x) and math.isfinite(y) and not (logarithmic and min(x, y) <= 0.0)


def _finite(line: Line, logarithmic: bool) -> Iterator[tuple[float, float]]:
    for x, y in zip(line.x, line.y, strict=True):
        if _drawable(x, y, logarithmic):
            yield float(x), float(y)


def _linear(low: float, high: float, start: float, end: float) -> Axis:
    from matplotlib.ticker import MaxNLocator

    if high - low <= 1e-9 * max(abs(low), abs(high)):
        margin = 0.1 * abs(high) or 1.0
    else:
        margin = 0.04 * (high - low)
    low, high = low - margin, high + margin
    ticks = [
        t
        for t in MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
        if low <= t <= high
    ]
    apart = ticks[1] - ticks[0] if len(ticks) > 1 else 1.0

    def place(value: float) -> float:
        return start + (end - start) * (value - low) / (high - low)

    # a tick at 0 is 0, whatever round-off its steps have left
    words = (f"{0.0 if abs(t) < 1e-6 * apart else t:.6g}" for t in ticks)
    return Axis(place, tuple(zip(map(place, ticks), words, strict=True)))


def _logarithmic(low: float, high: float, start: float, end: float) -> Axis:
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    last = max(last, first + 1)

    def place(value: float) -> float:
        return start + (end - start) * (math.log10(value) - first) / (last - first)

    every = -(-(last - first) // MOST_DECADES)
    decades: Sequence[int] = range(first, last + 1, every)
    return Axis(
        place, tuple((place(10.0**d), f"1e{d}" if abs(d) > 2 else f"{10.0**d:g}") for d in decades)
    )


_SVG = "http://www.w3.org/2000/svg"
_LINK = "{http://www.w3.org/1999/xlink}href"
_PLACES = ("d", "x", "y", "width", "height", "transform")
_NUMBER = re.compile(r"-?\d+\.\d{3,}")
_TURN = re.compile(r"rotate\(-?0 [^)]*\)")
_WORDS = ("}text", "}tspan", "}style", "}title")
_SCALE = "scale("
"""Of formulas and images, whose digits are kept."""
_SIZE = re.compile(r'<svg[^>]*? viewBox="0 0 ([\d.]+) ([\d.]+)"', re.DOTALL)


def compact(svg: str) -> str:
    """Return a figure without metadata, lengths to a hundredth of a point, each style said once.

    A hundredth of a point is 1/7200 inch: finer than a screen shows at eight times
    the size. Styles become classes, and groups that carry nothing are taken away.
    """
    Xml.register_namespace("", _SVG)
    Xml.register_namespace("xlink", "http://www.w3.org/1999/xlink")
    root = Xml.fromstring(svg)
    used = set(re.findall(r'(?:url\(|href=")#([^)"]+)', svg))
    classes: dict[str, str] = {}
    for parent in list(root.iter()):
        parent[:] = [child for child in parent if not child.tag.endswith("}metadata")]
        _shorten(parent, used, classes)
    _unwrap(root)
    sheet = Xml.Element(f"{{{_SVG}}}style")
    sheet.text = "".join(f".{name}{{{style}}}" for style, name in classes.items())
    root.insert(0, sheet)
    return Xml.tostring(root, encoding="unicode").replace(" />", "/>").strip()


def _shorten(node: Xml.Element, used: set[str], classes: dict[str, str]) -> None:
    """Round what has a place, name the style, and drop an id that nothing refers to."""
    node.tail = (node.tail or "").strip() or None
    if not node.tag.endswith(_WORDS):
        node.text = None
    if node.get("id") not in used:
        node.attrib.pop("id", None)
    for name in _PLACES:
        text = node.get(name)
        if text is None or (name == "transform" and _SCALE in text):
            continue
        text = _NUMBER.sub(_rounded, _TURN.sub("", " ".join(text.split()))).strip()
        if text:
            node.set(name, text)
        else:
            del node.attrib[name]
    style = node.attrib.pop("style", "")
    if style:
        tidy = re.sub(r"\s*([:;,])\s*", r"\1", style)
        node.set("class", classes.setdefault(tidy, f"s{len(classes)}"))


def _unwrap(node: Xml.Element) -> None:
    """Put the children of groups without attributes in their place."""
    children: list[Xml.Element] = []
    for child in node:
        _unwrap(child)
        plain = child.tag.endswith("}g") and not child.attrib
        children += list(child) if plain else [child]
    node[:] = children


def size(svg: str) -> tuple[float, float]:
    """Return width and height of a figure [pt]; raise ValueError for one without a size."""
    match = _SIZE.search(svg)
    if match is None:
        raise ValueError("a figure without a viewBox")
    return float(match[1]), float(match[2])


def data_uri(svg: str) -> str:
    """Return an SVG as a URI that stands in an attribute as it is.

    Percent-encoded, which is a quarter shorter than base64.
    """
    uri = "data:image/svg+xml," + quote(svg, safe=" /:;=,'()!*+-._~?@$<>{}\n").replace("\n", " ")
    return Markup(uri)


def _rounded(match: re.Match[str]) -> str:
    return f"{float(match[0]):.2f}".rstrip("0").rstrip(".")


@dataclass(frozen=True)
class Picture:
    """A figure as SVG, with its title and one sentence on what it shows; PNG where asked for."""

    name: str
    title: str
    caption: str
    svg: str
    png: bytes = b""


@dataclass(frozen=True)
class DrawnCell:
    """A cell of the matrix with its plots as SVG; ``failures`` says why there are none."""

    text: CellText
    plots: tuple[tuple[Plot, str], ...]
    failures: tuple[str, ...] = ()


@dataclass(frozen=True)
class Reel:
    """A film as GIF, and its poster as PNG."""

    name: str
    title: str
    caption: str
    gif: bytes
    still: bytes

    @property
    def gif_uri(self) -> str:
        """Return the film as an address that holds it."""
        return base64_uri(self.gif, "image/gif")

    @property
    def still_uri(self) -> str:
        """Return the poster as an address that holds it."""
        return base64_uri(self.still, "image/png")


@dataclass(frozen=True)
class Drawn:
    """A section with its figures drawn; ``failures`` says which could not be, and why."""

    section: Section
    pictures: tuple[Picture, ...]
    failures: tuple[str, ...] = ()
    cells: tuple[DrawnCell, ...] = ()
    reels: tuple[Reel, ...] = ()


def draw_sections(sections: Sequence[Section], *, png: bool = False) -> list[Drawn]:
    """Return the sections with their figures; names of figures are made unique file names.

    Figures are drawn as SVG, with ``png`` as PNG too, which costs as much again.

    A figure that cannot be drawn is named with the error: the others, and the report, do not
    depend on it.
    """
    seen: Counter[str] = Counter()
    drawings = []
    for drawing in (drawing for section in sections for drawing in section.drawings):
        name = safe_path(drawing.name).replace("/", "-")
        seen[name] += 1
        drawings.append((name if seen[name] == 1 else f"{name}-{seen[name]}", drawing))
    cells = [cell for section in sections for cell in section.cells]
    done = _all_drawn([*drawings, *cells], png=png)
    outcomes, plotted = iter(done[: len(drawings)]), iter(done[len(drawings) :])
    drawn = []
    for section in sections:
        drawn_here = [next(outcomes) for _ in section.drawings]
        pictures = tuple(outcome for outcome in drawn_here if isinstance(outcome, Picture))
        filmed = [_filmed(film) for film in section.films]
        failures = tuple(outcome for outcome in (*drawn_here, *filmed) if isinstance(outcome, str))
        cells_drawn = tuple(_cell(cell, next(plotted)) for cell in section.cells)
        reels = tuple(outcome for outcome in filmed if isinstance(outcome, Reel))
        drawn.append(Drawn(section, pictures, failures, cells_drawn, reels))
    return drawn


def write_drawn(drawn: Sequence[Drawn], folder: Path) -> None:
    """Write the figures of sections into ``figures`` below a folder, films into ``movies``."""
    (folder / "figures").mkdir()
    for picture in (picture for part in drawn for picture in part.pictures):
        (folder / "figures" / f"{picture.name}.svg").write_text(picture.svg, encoding="utf-8")
        if picture.png:
            (folder / "figures" / f"{picture.name}.png").write_bytes(picture.png)
    for reel in (reel for part in drawn for reel in part.reels):
        (folder / "movies").mkdir(exist_ok=True)
        (folder / "movies" / f"{reel.name}.gif").write_bytes(reel.gif)
        (folder / "movies" / f"{reel.name}.png").write_bytes(reel.still)


def titles(drawn: Sequence[Drawn]) -> dict[str, str]:
    """Return the titles of the engines of the matrix, by name."""
    return {cell.text.engine: cell.text.engine_title for part in drawn for cell in part.cells}


def commands(drawn: Sequence[Drawn]) -> dict[tuple[str, str, str], list[str]]:
    """Return what runs the first system of each cell again."""
    return {
        cell.text.place: [command for _, command in cell.text.commands[:2]]
        for part in drawn
        for cell in part.cells
    }


def _filmed(film: Film) -> Reel | str:
    try:
        name = safe_path(film.name).replace("/", "-")
        still = png(film.picture(film.poster))
        return Reel(name, film.title, film.caption, gif(film.picture, film.frames), still)
    except Exception as error:
        reason = one_line(f"{type(error).__name__}: {error}")
        return f"Film {film.title!r} could not be drawn: {reason}"


Named = tuple[str, Drawing]
"""A figure and the name of its file."""

Plots = tuple[tuple[Plot, str], ...]
"""Plots, and each as SVG."""


def _cell(text: CellText, plots: Picture | Plots | str) -> DrawnCell:
    if isinstance(plots, tuple):
        return DrawnCell(text, plots)
    return DrawnCell(text, (), (str(plots),))


def _all_drawn(drawings: Sequence[Named | CellText], *, png: bool) -> list[Picture | Plots | str]:
    """Return each figure, or why it could not be drawn, over the cores where a process can fork.

    A forked process has the runs that figures are drawn from; another would have to be sent them.
    """
    if sys.platform != "linux" or len(drawings) < 2:
        return [_drawn(drawing, png=png) for drawing in drawings]
    import matplotlib.backends.backend_agg
    import matplotlib.backends.backend_svg  # noqa: F401 - once, for all processes

    _of_workers[:] = [partial(_drawn, drawing, png=png) for drawing in drawings]
    workers, fork = len(os.sched_getaffinity(0)), multiprocessing.get_context("fork")
    try:
        with ProcessPoolExecutor(workers, fork, _begin_worker, (os.getpid(),)) as pool:
            return list(pool.map(_drawn_in_worker, range(len(drawings))))
    except BrokenProcessPool:
        return [_drawn(drawing, png=png) for drawing in drawings]
    finally:
        _of_workers.clear()


_of_workers: list[Callable[[], Picture | Plots | str]] = []
"""What draws each figure, as a forked process finds them."""


def _drawn_in_worker(index: int) -> Picture | Plots | str:
    return _of_workers[index]()


def _begin_worker(parent: int) -> None:
    """Write past progress bars, whose lock a thread may have held when the process forked."""
    end_with(parent)
    sys.stdout, sys.stderr = sys.__stdout__, sys.__stderr__


def _drawn(content: Named | CellText, *, png: bool) -> Picture | Plots | str:
    title = ", ".join(content.place) if isinstance(content, CellText) else content[1].title
    try:
        if isinstance(content, CellText):
            return tuple((plot, svg(plot)) for plot in content.plots())
        name, drawing = content
        return picture(name, drawing.title, drawing.caption, drawing.draw, png=png)
    except Exception as error:  # code of a plug-in, anything can go wrong in it
        reason = one_line(f"{type(error).__name__}: {error}")
        return f"Figure {title!r} could not be drawn: {reason}"


def picture(
    name: str, title: str, caption: str, draw: Callable[[], Figure], *, png: bool = False
) -> Picture:
    """Return what ``draw`` draws in the house style, the same bytes for the same figure.

    As SVG, with ``png`` as PNG too.
    """
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    with house_style():
        figure = draw()
        plain_powers(figure)
        lay_out(figure)
        vector, bitmap = io.StringIO(), io.BytesIO()
        # savefig would draw each of them twice, the first time for the layout
        canvas: Any = FigureCanvasSVG(figure)
        canvas.print_svg(vector, metadata={"Date": None})
        if png:
            figure.dpi = mpl.rcParams["savefig.dpi"]
            canvas = FigureCanvasAgg(figure)
            canvas.print_png(bitmap, metadata={"Software": None})
    return Picture(name, title, caption, compact(vector.getvalue()), bitmap.getvalue())
