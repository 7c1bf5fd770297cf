"""What results show: sections of reports, summaries in notebooks, and text of numbers and names.

Tables are DataFrames; figures are drawn when a page is written. One template renders the same
sections as HTML, another as Markdown.
"""

from __future__ import annotations

import html
import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike, NDArray

    from harness.report import figures

    Floats = NDArray[np.float64]

ROUND_OFF = 14  # decimals beyond which an uncertainty is round-off and is not shown
DIGITS = 8  # of a value in a table
SHORT = 2  # digits of a difference, an uncertainty or a tolerance
_ESCAPES = re.compile(
    r"\x1b\[[0-?]*[ -/]*[@-~]"  # colours, moves of the cursor
    r"|\x1b[\]PX^_].*?(?:\x07|\x1b\\|$)"  # titles, links, other strings
    r"|\x1b[ -/]*[0-~]",
    re.DOTALL,
)
# all but tab and newline, marks that reverse the direction of writing, halves of surrogate pairs
_CONTROLS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")


# ---- reports


class Badge(NamedTuple):
    """A cell of a table, or a part of one, in the colours of a verdict, with a link."""

    text: str
    verdict: str = ""
    address: str = ""


@dataclass(frozen=True)
class Table:
    """A table with its title and caption.

    Cells are numbers, text or badges. The name of a verdict has its colours on a page.
    """

    title: str
    frame: pd.DataFrame = field(repr=False)
    caption: str = ""


@dataclass(frozen=True)
class Drawing:
    """A figure: the name of its file, its title and caption, and the function that draws it."""

    name: str
    title: str
    caption: str
    draw: Callable[[], Figure] = field(repr=False)


@dataclass(frozen=True)
class Opening:
    """The answer of a case at the top of a report.

    ``sketch`` is the SVG of the system, ``steps`` the lines of the derivation from ``source``,
    ``terms`` words with their meanings.
    """

    title: str
    sketch: str = field(repr=False)
    steps: tuple[str, ...]
    source: str
    terms: tuple[tuple[str, str], ...]
    figure: Drawing | None = None


@dataclass(frozen=True)
class Section:
    """A part of a report: Markdown text, tables and figures, in this order."""

    title: str
    text: str = ""
    tables: tuple[Table, ...] = ()
    drawings: tuple[Drawing, ...] = ()
    opening: Opening | None = None


# ---- films


@dataclass(frozen=True)
class Discs:
    """The discs of a film: centres of M samples of N bodies [m], and fixed discs and walls.

    ``time`` [s] (M,), ``x`` and ``y`` (M, N), ``radius`` (N,) or (M, N); ``fixed`` are discs
    (K, 3) of x, y and radius, ``lines`` walls (L, 2, 2) of two points each. ``value`` (M, N)
    colours the bodies by a quantity named ``value_label``.
    """

    title: str
    time: Floats
    x: Floats
    y: Floats
    radius: Floats
    fixed: ArrayLike = ()
    lines: ArrayLike = ()
    value: Floats | None = None
    value_label: str = ""


# ---- notebooks


class Summarized(ABC):
    """A result that shows its summary as text or HTML; a dataclass is declared ``repr=False``."""

    @abstractmethod
    def summary(self) -> Mapping[str, str]:
        """Return the main values, at most five, by name."""

    def __repr__(self) -> str:
        return "\n".join(f"{name}: {text}" for name, text in self.summary().items())

    def _repr_html_(self) -> str:
        look = "style='text-align:left'"
        texts = [map(html.escape, item) for item in self.summary().items()]
        rows = [f"<tr><th scope='row' {look}>{a}</th><td {look}>{b}</td></tr>" for a, b in texts]
        return f"<table><tbody>{''.join(rows)}</tbody></table>"


class Plottable(Summarized):
    """A result with a table and a figure too."""

    @abstractmethod
    def to_frame(self) -> pd.DataFrame:
        """Return the result as a table."""

    @abstractmethod
    def draw(self) -> figures.Figure:
        """Return the figure behind :meth:`plot`, in the style that is set."""

    def plot(self) -> figures.Figure:
        """Return a matplotlib figure of the result, whose axes have units."""
        from harness.report.figures import house_style  # slow to load: matplotlib

        with house_style():
            return self.draw()


# ---- text


def value_text(value: float, uncertainty: float = 0.0, unit: str = "") -> str:
    """Return a value with its uncertainty and unit, to the first digit of the uncertainty.

    >>> value_text(10.206981, 0.00042, "deg")
    '10.2070 ± 0.0004 deg'
    >>> value_text(0.56613974), value_text(math.nan, unit="m/s")
    ('0.56613974', '-')
    """
    unit = "" if unit == "1" or math.isnan(value) else unit
    if math.isfinite(value) and 0.0 < uncertainty < math.inf:
        exponent = math.floor(math.log10(uncertainty))
        leading = round(uncertainty / 10.0**exponent)
        places = max(0, 1 - exponent if leading == 1 else -exponent)  # two digits after a 1
        if places <= ROUND_OFF:
            return f"{value:.{places}f} ± {uncertainty:.{places}f} {unit}".rstrip()
    return f"{number(value)} {unit}".rstrip()


def number(value: float, digits: int = DIGITS) -> str:
    """Return a number for a table, a dash for a missing one."""
    return "-" if math.isnan(value) else f"{value:.{digits}g}"


def power(value: float) -> str:
    """Return a number as a power of ten with a factor of at most two digits.

    >>> power(1e6), power(250000.0)
    ('1e6', '2.5e5')
    """
    factor, exponent = f"{value:.1e}".split("e")
    return f"{float(factor):g}e{int(exponent)}"


def printable(text: str) -> str:
    """Return text without escape sequences of terminals, other control characters as ``?``."""
    return _CONTROLS.sub("?", _ESCAPES.sub("", text.replace("\r\n", "\n")))


def one_line(text: str) -> str:
    """Return printable text on one line."""
    return " ".join(printable(text).split())
