"""The content of a report: sections of text, tables and figures, made by cases and workflows.

Tables are DataFrames; figures are drawn when a page is written. One template renders the same
sections as HTML, another as Markdown.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Table:
    """A table with its title and caption.

    Cells are numbers or text. A cell that is the name of a verdict has its colours on a page.
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
    ``figure`` the name of a drawing of the same section, ``terms`` words with their meanings.
    ``answers`` are the main results: name, measured value with its uncertainty, expected value.
    """

    title: str
    sketch: str = field(repr=False)
    steps: tuple[str, ...]
    source: str
    terms: tuple[tuple[str, str], ...]
    figure: str = ""
    answers: tuple[tuple[str, str, str], ...] = ()


@dataclass(frozen=True)
class Section:
    """A part of a report: Markdown text, tables and figures, in this order."""

    title: str
    text: str = ""
    tables: tuple[Table, ...] = ()
    drawings: tuple[Drawing, ...] = ()
    opening: Opening | None = None


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
    fixed: Floats = field(default_factory=lambda: np.empty((0, 3)))
    lines: Floats = field(default_factory=lambda: np.empty((0, 2, 2)))
    value: Floats | None = None
    value_label: str = ""
