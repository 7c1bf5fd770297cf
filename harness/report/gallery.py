"""Draw the figures of a report, over the cores: the same bytes for the same content.

Their SVG is compacted: fewer digits, each style once.
"""

from __future__ import annotations

import io
import multiprocessing
import os
import re
import sys
from collections import Counter
from collections.abc import Callable, Sequence
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
from harness.report.plain import one_line, safe_path
from harness.report.sections import Drawing, Section
from harness.report.style import house_style, lay_out, plain_powers

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_SVG = "http://www.w3.org/2000/svg"
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
class Drawn:
    """A section with its figures drawn; ``failures`` says which could not be, and why."""

    section: Section
    pictures: tuple[Picture, ...]
    failures: tuple[str, ...] = ()


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
    outcomes = iter(_all_drawn(drawings, png=png))
    drawn = []
    for section in sections:
        of_section = [next(outcomes) for _ in section.drawings]
        pictures = tuple(outcome for outcome in of_section if isinstance(outcome, Picture))
        failures = tuple(outcome for outcome in of_section if isinstance(outcome, str))
        drawn.append(Drawn(section, pictures, failures))
    return drawn


def write_drawn(drawn: Sequence[Drawn], folder: Path) -> None:
    """Write the figures of sections into ``figures`` below a folder."""
    (folder / "figures").mkdir()
    for picture in (picture for part in drawn for picture in part.pictures):
        (folder / "figures" / f"{picture.name}.svg").write_text(picture.svg, encoding="utf-8")
        if picture.png:
            (folder / "figures" / f"{picture.name}.png").write_bytes(picture.png)


Named = tuple[str, Drawing]
"""A figure and the name of its file."""


def _all_drawn(drawings: Sequence[Named], *, png: bool) -> list[Picture | str]:
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


_of_workers: list[Callable[[], Picture | str]] = []
"""What draws each figure, as a forked process finds them."""


def _drawn_in_worker(index: int) -> Picture | str:
    return _of_workers[index]()


def _begin_worker(parent: int) -> None:
    """Write past progress bars, whose lock a thread may have held when the process forked."""
    end_with(parent)
    sys.stdout, sys.stderr = sys.__stdout__, sys.__stderr__


def _drawn(named: Named, *, png: bool) -> Picture | str:
    name, drawing = named
    try:
        return picture(name, drawing.title, drawing.caption, drawing.draw, png=png)
    except Exception as error:  # code of a plug-in, anything can go wrong in it
        reason = one_line(f"{type(error).__name__}: {error}")
        return f"Figure {drawing.title!r} could not be drawn: {reason}"


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
