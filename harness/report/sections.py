"""The parts that a report is made of: sections of sentences, tables and figures.

Cases and workflows make them; ``report`` renders the same sections as HTML and as Markdown.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Numbers = Sequence[float] | NDArray[np.float64]


@dataclass(frozen=True)
class Table:
    """A table: what it is called, caption, head, rows, and the columns of numbers and of prose."""

    label: str
    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numeric: frozenset[int] = frozenset()
    prose: frozenset[int] = frozenset()


@dataclass(frozen=True)
class Drawing:
    """A figure, drawn when it is rendered: file name, title, one sentence on what it shows."""

    name: str
    title: str
    caption: str
    draw: Callable[[], Figure] = field(repr=False)


@dataclass(frozen=True)
class Line:
    """A line of a plot, or points where it is ``marked``; ``x`` and ``y`` are of one length.

    A value that is not finite is left out and interrupts the line.
    """

    name: str
    x: Numbers
    y: Numbers
    marked: bool = False


@dataclass(frozen=True)
class Plot:
    """A small figure of lines, its axes named with their units, both logarithmic or linear.

    Plots of one ``group`` stand together under its name.
    """

    title: str
    caption: str
    x: str
    y: str
    lines: tuple[Line, ...]
    logarithmic: bool = False
    group: str = ""


@dataclass(frozen=True)
class CellText:
    """What is told of a cell of the matrix, a submodel of a case in an engine, beside its rows.

    ``who`` is the engine's title; ``commands`` repeat a run, by what they are. ``plots`` are made
    when the page is. ``inputs`` are names of the scripts that ``commands`` run, without ending: of
    a file or its folder.
    """

    case: str
    submodel: str
    engine: str
    who: str
    paragraphs: tuple[str, ...]
    tables: tuple[Table, ...]
    commands: tuple[tuple[str, str], ...]
    plots: Callable[[], Sequence[Plot]] = field(repr=False)
    inputs: frozenset[str] = frozenset()

    @property
    def place(self) -> tuple[str, str, str]:
        """Return case, submodel and engine."""
        return (self.case, self.submodel, self.engine)


@dataclass(frozen=True)
class Film:
    """A film: file name, title, a sentence on what it shows, how many frames, how each looks.

    ``picture`` returns a frame as bytes (height, width, 3); ``poster`` is the one that is shown
    where nothing moves.
    """

    name: str
    title: str
    caption: str
    frames: int
    poster: int
    picture: Callable[[int], NDArray[np.uint8]] = field(repr=False)


@dataclass(frozen=True)
class Section:
    """A part of a report: paragraphs, list items, tables, figures, films, in this order.

    A section without a title adds its figures to the gallery and nothing else. ``cells`` have
    pages of their own.
    """

    title: str = ""
    paragraphs: tuple[str, ...] = ()
    items: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    drawings: tuple[Drawing, ...] = ()
    cells: tuple[CellText, ...] = ()
    films: tuple[Film, ...] = ()
