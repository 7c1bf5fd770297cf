"""Figures as files: drawings of sections to SVG and PNG, the same bytes for the same content."""

from __future__ import annotations

import io
import multiprocessing
import os
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from typing import TYPE_CHECKING
from urllib.parse import quote

from markupsafe import Markup

from harness.files import end_with
from harness.report.content import Drawing
from harness.report.style import FONTS, house_style, set_power_ticks

if TYPE_CHECKING:
    from matplotlib import figure as mpl_figure

_VIEW_BOX = re.compile(r'<svg[^>]*? viewBox="0 0 ([\d.]+) ([\d.]+)"', re.DOTALL)
_SHORTER = (  # pattern, replacement: what a browser does not need
    (r"<\?xml.*?\?>|<!DOCTYPE.*?>|<metadata>.*?</metadata>|<!--.*?-->", ""),
    (r"font-family: [^;\"]*(?:; ?)?", ""),
    (r' style="" ?', ""),
    (r' transform="rotate\(-0[^"]*\)"', ""),
    (r' id="(?:figure|axes|axis|patch|line2d|text|xtick|ytick|legend|matplotlib)[^"]*"', ""),
    (r"(?<=[;:]) ", ""),
    (r"\s*\n\s*", "\n"),
    (r">\n<", "><"),
)
_SHORTER_NUMBERS = (
    (r"(-?\d+\.\d\d)\d+", r"\1"),  # 1/7200 inch
    (r"(\d)\.0+(?!\d)", r"\1"),
)


@dataclass(frozen=True)
class Picture:
    """A figure that was drawn: SVG, PNG where it was requested, or the error of its function."""

    drawing: Drawing
    svg: str = ""
    png: bytes = b""
    error: str = ""

    @property
    def size(self) -> tuple[float, float]:
        """Return width and height [pt]. Raise ValueError for an SVG without a view box."""
        if (match := _VIEW_BOX.search(self.svg)) is None:
            raise ValueError(f"figure {self.drawing.name!r} has no view box")
        return float(match[1]), float(match[2])

    @property
    def uri(self) -> str:
        """Return the SVG as a data URI."""
        return svg_uri(self.svg)


def draw(drawing: Drawing, *, png: bool = False) -> Picture:
    """Return a figure in the house style; an error of its function is kept in the picture."""
    try:
        with house_style():
            figure = drawing.draw()
            set_power_ticks(figure)
            svg = compact(_saved(figure, "svg", {"Date": None}).decode())
            bitmap = _saved(figure, "png", {"Software": None}) if png else b""
        return Picture(drawing, svg, bitmap)
    except Exception as error:  # the function may be a plug-in's
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        return Picture(drawing, error=reason)


def draw_all(drawings: Sequence[Drawing], *, png: bool = False) -> list[Picture]:
    """Return the figures in order, drawn over the cores where a process can fork.

    A forked process has the runs that the figures are drawn from; another would need a copy.
    """
    if sys.platform != "linux" or len(drawings) < 2:
        return [draw(drawing, png=png) for drawing in drawings]
    import matplotlib.backends.backend_agg
    import matplotlib.backends.backend_svg  # noqa: F401 - once, before the fork

    _tasks[:] = [lambda drawing=drawing: draw(drawing, png=png) for drawing in drawings]  # type: ignore[misc]
    workers, fork = len(os.sched_getaffinity(0)), multiprocessing.get_context("fork")
    try:
        with ProcessPoolExecutor(workers, fork, _begin_worker, (os.getpid(),)) as pool:
            drawn = pool.map(_run_task, range(len(drawings)))
            return [
                Picture(drawing, *parts) for drawing, parts in zip(drawings, drawn, strict=True)
            ]
    except BrokenProcessPool:
        return [draw(drawing, png=png) for drawing in drawings]
    finally:
        _tasks.clear()


_tasks: list[Callable[[], Picture]] = []  # as forked processes find them: they cannot be pickled


def _run_task(index: int) -> tuple[str, bytes, str]:
    picture = _tasks[index]()
    return picture.svg, picture.png, picture.error


def _begin_worker(parent: int) -> None:
    end_with(parent)
    # a progress bar stands in their place, whose lock a thread may have held at the fork
    sys.stdout, sys.stderr = sys.__stdout__, sys.__stderr__


def _saved(figure: mpl_figure.Figure, kind: str, metadata: Mapping[str, None]) -> bytes:
    target = io.BytesIO()
    figure.savefig(target, format=kind, metadata=dict(metadata))
    return target.getvalue()


def svg_uri(svg: str) -> str:
    """Return an SVG as a data URI, percent-encoded: a quarter shorter than base64.

    It stands in an attribute as it is: double quotes and ampersands are encoded.
    """
    text = quote(svg, safe=" /:;=,'()!*+-._~?@$<>{}\n").replace("\n", " ")
    return Markup(f"data:image/svg+xml,{text}")


def compact(svg: str) -> str:
    """Return an SVG of matplotlib without metadata, each style once, to hundredths of a point."""
    for pattern, replacement in _SHORTER:
        svg = re.sub(pattern, replacement, svg, flags=re.DOTALL)
    svg = re.sub(r"<[^>]*>", lambda match: _with_short_numbers(match[0]), svg)
    fonts = ",".join(f"'{name}'" for name in FONTS)
    styles = dict.fromkeys(re.findall(r' style="([^"]*)"', svg))
    names = {style: f"s{number}" for number, style in enumerate(styles)}
    svg = re.sub(r' style="([^"]*)"', lambda match: f' class="{names[match[1]]}"', svg)
    sheet = [f"text{{font-family:{fonts},sans-serif}}", *(f".{n}{{{s}}}" for s, n in names.items())]
    return svg.replace("</style>", " ".join(["", *sheet, "</style>"]), 1).strip()


def _with_short_numbers(tag: str) -> str:
    """Return a tag with coordinates to hundredths; the text between tags keeps its digits."""
    for pattern, replacement in _SHORTER_NUMBERS:
        tag = re.sub(pattern, replacement, tag)
    return tag
