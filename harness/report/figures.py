"""Figures as files: drawings of sections to SVG and PNG, the same bytes for the same content."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING
from urllib.parse import quote

from markupsafe import Markup

from harness.report.content import Drawing

if TYPE_CHECKING:
    from matplotlib import figure as mpl_figure

VIEW_BOX = re.compile(r'<svg[^>]*? viewBox="0 0 ([\d.]+) ([\d.]+)"', re.DOTALL)
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


@dataclass(frozen=True)
class Picture:
    """A drawn figure: SVG, PNG where it was requested, or the error of its function."""

    drawing: Drawing
    svg: str = ""
    png: bytes = b""
    error: str = ""

    @property
    def size(self) -> tuple[float, float]:
        """Return width and height [pt]. Raise ValueError for an SVG without a view box."""
        if (match := VIEW_BOX.search(self.svg)) is None:
            raise ValueError(f"figure {self.drawing.name!r} has no view box")
        return float(match[1]), float(match[2])

    @property
    def uri(self) -> Markup:
        """Return the SVG as a data URI."""
        return svg_uri(self.svg)


def draw(drawing: Drawing, *, png: bool = False) -> Picture:
    """Return a figure in the house style; an error of its function is stored in the picture."""
    from harness.report.style import house_style  # slow to load: matplotlib

    try:
        with house_style():
            figure = drawing.draw()
            svg = compact(_file(figure, "svg", "Date").decode())
            return Picture(drawing, svg, _file(figure, "png", "Software") if png else b"")
    except Exception as error:  # the function may be a plug-in's
        return Picture(drawing, error=" ".join(f"{type(error).__name__}: {error}".split()))


def svg_uri(svg: str) -> Markup:
    """Return an SVG as a data URI, percent-encoded: a quarter shorter than base64.

    It needs no escapes in an attribute: double quotes and ampersands are encoded.
    """
    text = quote(svg, safe=" /:;=,'()!*+-._~?@$<>{}\n").replace("\n", " ")
    return Markup(f"data:image/svg+xml,{text}")


def compact(svg: str) -> str:
    """Return an SVG of matplotlib without metadata, each style once, to hundredths of a point."""
    from harness.report.style import FONTS

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
    tag = re.sub(r"(-?\d+\.\d\d)\d+", r"\1", tag)  # 1/7200 inch
    return re.sub(r"(\d)\.0+(?!\d)", r"\1", tag)


def _file(figure: mpl_figure.Figure, kind: str, varying_key: str) -> bytes:
    target = io.BytesIO()
    figure.savefig(target, format=kind, metadata={varying_key: None})
    return target.getvalue()
