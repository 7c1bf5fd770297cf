"""The parts that a report is made of: sections of sentences, tables and figures.

Cases and workflows make them; ``report`` renders the same sections as HTML and as Markdown.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
class Section:
    """A part of a report: paragraphs, list items, tables, figures, in this order.

    A section without a title adds its figures to the gallery and nothing else.
    """

    title: str = ""
    paragraphs: tuple[str, ...] = ()
    items: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    drawings: tuple[Drawing, ...] = ()
