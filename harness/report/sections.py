"""The parts that a report is made of: sections of sentences, tables and figures.

Cases and workflows make them; ``report`` renders the same sections as HTML and as Markdown. Two
are of no case: engines beside one another, and series that left the band about their reference.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING

from harness.comparison.series import Comparison
from harness.comparison.verification import DeclaredEngine

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Label:
    """A text in a cell of a table that looks like a verdict, or leads to an ``address``.

    ``look`` is the verdict whose colours it has. ``name`` stands before it, and ``title`` explains
    it, on a page only.
    """

    text: str
    look: str = ""
    address: str = ""
    name: str = ""
    title: str = ""


TableCell = str | tuple[Label, ...]

PROSE = 34
"""Characters above which a cell is a sentence, which is wrapped."""

NUMBER = re.compile(
    r"[-+]?\d[\d,]*(\.\d+)?(e[-+]?\d+)?( %| ± \S+| \([^)]*\)| (?:x|to) -?\d+(\.\d+)?)?"
)


def plain_text(cell: TableCell) -> str:
    """Return the words of a cell."""
    return cell if isinstance(cell, str) else ", ".join(label.text for label in cell)


@dataclass(frozen=True)
class Table:
    """A table: what it is called, caption, head and rows of cells.

    A row with fewer cells than the head has its last one over the columns that are left. ``places``
    are addresses of its rows on a page.
    """

    label: str
    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[TableCell, ...], ...]
    places: tuple[str, ...] = ()

    @property
    def without_empty_columns(self) -> Table:
        """Return the table without the columns that are empty, or a dash, in every row."""
        columns = range(len(self.head))
        kept = [n for n in columns if any(text.strip("-") for text in self._texts(n))]
        if len(kept) == len(self.head) or not self.rows:
            return self
        rows = tuple(tuple(row[n] for n in kept if n < len(row)) for row in self.rows)
        return replace(self, head=tuple(self.head[n] for n in kept), rows=rows)

    @cached_property
    def looks(self) -> tuple[str, ...]:
        """Return of each column whether it has numbers, ``n``, sentences, ``prose``, or neither.

        Labels make no sentence.
        """
        labels = {n for row in self.rows for n, cell in enumerate(row) if not isinstance(cell, str)}
        looks = (column_look(self._texts(n)) for n in range(len(self.head)))
        return tuple(
            "" if n in labels and look == "prose" else look for n, look in enumerate(looks)
        )

    def _texts(self, column: int) -> list[str]:
        return [plain_text(row[column]) for row in self.rows if column < len(row)]


def column_look(texts: Sequence[str]) -> str:
    """Return ``n`` for a column of numbers, ``prose`` for one with a sentence, else nothing."""
    filled = [text for text in texts if text.strip("-") and text != "none"]
    if filled and all(map(NUMBER.fullmatch, filled)):
        return "n"
    return "prose" if any(len(text) > PROSE for text in filled) else ""


@dataclass(frozen=True)
class Drawing:
    """A figure, drawn when it is rendered: file name, title, one sentence on what it shows."""

    name: str
    title: str
    caption: str
    draw: Callable[[], Figure] = field(repr=False)


@dataclass(frozen=True)
class Opening:
    """What a case answers, for the top of a report.

    ``sketch`` is the SVG of the system. ``steps`` derive the answer, a line each, from ``source``.
    ``figure`` is the name of a drawing of the same section, empty without one. ``terms`` are words
    of the case, each with its meaning.
    """

    title: str
    sketch: str = field(repr=False)
    steps: tuple[str, ...]
    source: str
    terms: tuple[tuple[str, str], ...]
    figure: str = ""


@dataclass(frozen=True)
class Section:
    """A part of a report: paragraphs, list items, tables, figures, in this order.

    A section without a title adds its figures to the gallery and nothing else. An ``opening``
    stands at the top of the report.
    """

    title: str = ""
    paragraphs: tuple[str, ...] = ()
    items: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    drawings: tuple[Drawing, ...] = ()
    opening: Opening | None = None


TITLE = "Engines beside one another"

EXPLAINED = (
    "Two classes of contact law must not be compared as one: a code that clips the attractive "
    "tail rebounds where one that keeps it does not, and half the effective mass damps less. So "
    "each engine stands beside theory, and beside the reference DEM under the engine's own rules "
    "(tail, effective mass, scheme, step). Differences between classes are findings. An "
    "engine's results are used after it has qualified on one fixed sphere. Agreement with an "
    "engine that grew out of another is a regression test, not independent evidence."
)

HEAD = (
    "engine",
    "version",
    "tails",
    "m_eff",
    "scheme",
    "digits",
    "grew out of",
    "status",
)


def engines_section(engines: Sequence[DeclaredEngine]) -> Section:
    """Return the table of what engines declare, and what their users have to know."""
    table = Table(
        "What each engine declares",
        "What each engine declares. Tail and effective mass are those that it can be told; the "
        "scheme is the reference DEM's name for it.",
        HEAD,
        tuple(_row(declared) for declared in engines),
    )
    caveats = tuple(f"{d.engine}: {' '.join(d.caveats)}" for d in engines if d.caveats)
    return Section(TITLE, (EXPLAINED,), caveats, (table,))


def _row(declared: DeclaredEngine) -> tuple[str, ...]:
    reason = declared.missing or declared.unqualified
    return (
        declared.engine,
        ", ".join(filter(None, (declared.version, declared.how))) or "not here",
        ", ".join(declared.tails),
        ", ".join("m" if mass == "full" else "m/2" for mass in declared.effective_masses),
        declared.integrator or "its own",
        str(declared.digits),
        declared.lineage or "independent",
        f"{declared.summary}: {reason}" if reason else declared.summary,
    )


MOST_DIVERGENCES = 6
"""Figures of divergences that a report shows; the rows name them all."""


def divergence_section(series: Sequence[Comparison]) -> Section:
    """Return the figures of the cases that diverged, each by the column that did so first."""
    return Section(
        "Where series diverge",
        drawings=tuple(
            Drawing(
                f"divergence-{number}",
                f"Divergence: {case.case}",
                f"{case.run_label} against {case.reference_label} around the moment at which they "
                "diverge, and their difference over the whole record with its tolerance.",
                partial(_draw, case),
            )
            for number, case in enumerate(first_to_diverge(series)[:MOST_DIVERGENCES], 1)
        ),
    )


def first_to_diverge(series: Sequence[Comparison]) -> list[Comparison]:
    """Return of each case the column that left its band first."""
    first: dict[str, tuple[float, Comparison]] = {}
    for column in series:
        moment = column.divergence
        if moment is not None and moment.time < first.get(column.case, (math.inf, column))[0]:
            first[column.case] = moment.time, column
    return [column for _, column in first.values()]


def _draw(series: Comparison) -> Figure:
    from harness.report.figures import divergence

    return divergence(series)
