"""Render the report as one self-contained HTML page: the answer, the verdicts, causes, all rows."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from harness.comparison.verdicts import Check, Verdict
from harness.comparison.verification import Verification
from harness.report import text
from harness.report.causes import Cause, causes
from harness.report.gallery import Drawn, Picture, Reel, commands, data_uri, size, titles
from harness.report.matrix import matrices
from harness.report.sections import Opening, Section, Table
from harness.report.templating import environment
from harness.report.text import SEVERITY, by_severity, headline, summaries

NUMERIC = ("value", "expected", "difference", "uncertainty", "tolerance", "used")
COLUMNS = ("verdict", "check", "kind", "value", "expected", "unit", *NUMERIC[2:])
WIDE = 560
"""[pt] A figure wider than this takes both columns: beside another its words would be too small."""
TALL = 0.95
"""So does one at least this much of its width high."""


@dataclass(frozen=True)
class Row:
    """A check as the page shows it."""

    check: Check
    id: str

    @property
    def severity(self) -> int:
        """Return the place of the verdict in the order of reading."""
        return SEVERITY.index(self.check.verdict)

    @property
    def used(self) -> float:
        """Return how much of the tolerance the difference takes; 1 is the limit."""
        difference, tolerance = abs(self.check.difference), self.check.tolerance
        if tolerance > 0.0:
            return difference / tolerance
        return 0.0 if difference == 0.0 == tolerance else math.nan

    @property
    def percent(self) -> str:
        """Return that share in per cent; empty where there is none."""
        share = 100.0 * self.used
        return "" if math.isnan(share) else f"{share:.3g} %" if share < 1e4 else "> 1e4 %"

    @property
    def width(self) -> str:
        """Return the length of the bar [%]."""
        return f"{min(100.0, 100.0 * self.used):.0f}"


@dataclass(frozen=True)
class Shown:
    """A figure as a page shows it."""

    name: str
    title: str
    caption: str
    uri: str
    width: int
    height: int

    look: str = ""
    """Whether it takes both columns, as ``wide`` or, limited in width, as ``tall``."""


@dataclass(frozen=True)
class OpeningShown:
    """What a case answers, with its figure as the page shows it, None without one."""

    opening: Opening
    figure: Shown | None
    failures: tuple[str, ...]


@dataclass(frozen=True)
class Part:
    """A section as the page shows it; ``id`` is unique among the sections."""

    section: Section
    id: str
    figures: tuple[Shown, ...]
    failures: tuple[str, ...]
    films: tuple[Reel, ...] = ()


def rows_of(found: Verification) -> list[Row]:
    """Return the checks as rows, the most severe first."""
    return [Row(check, f"check-{n}") for n, check in enumerate(by_severity(found.checks), 1)]


def html_page(
    found: Verification,
    drawn: Sequence[Drawn],
    cells: Mapping[tuple[str, str, str], str] | None = None,
) -> str:
    """Return the page; figures, scripts and style are inside it, so that it can be sent alone.

    ``cells`` are the pages of the matrix's cells beside it, by case, submodel and engine.
    """
    template = environment().get_template("report.html.j2")
    rows = rows_of(found)
    kinds = summaries(found.checks)
    gallery = [one for one in drawn if not one.section.title and one.section.opening is None]
    return template.render(
        headline=headline(found.checks, found.untested_cases),
        outcome=_outcome(found),
        who=_who(found),
        told=[(h.name, text.expected(h), text.measured(h)) for h in found.headlines],
        summaries=kinds,
        rows=rows,
        openings=[_opening(one) for one in drawn if one.section.opening],
        causes=[(cause, rows_in(cause, rows)) for cause in causes(found, commands(drawn))],
        findings=[row for row in rows if row.check.verdict is Verdict.FINDING],
        titles=titles(drawn),
        names=COLUMNS,
        numeric=NUMERIC,
        kinds=[s.kind for s in kinds],
        verdicts=[v for v in SEVERITY if any(c.verdict is v for c in found.checks)],
        meanings=text.KINDS,
        matrices=matrices([(row.check, row.id) for row in rows], titles(drawn)),
        cells=cells or {},
        parts_of_page=parts_of(drawn),
        pictures=figures([p for d in gallery for p in d.pictures]),
        failures=[f for d in gallery for f in d.failures],
        scripts=found.scripts,
        logs=found.logs,
        provenance=text.provenance(found),
        look=look,
    )


def rows_in(cause: Cause, rows: Sequence[Row]) -> list[Row]:
    """Return the rows of a cause as the page shows them."""
    own = {id(check) for check in cause.rows}
    return [row for row in rows if id(row.check) in own]


def _opening(drawn: Drawn) -> OpeningShown:
    assert drawn.section.opening is not None
    shown = figures(drawn.pictures)
    return OpeningShown(drawn.section.opening, shown[0] if shown else None, drawn.failures)


def look(table: Table, column: int) -> str:
    """Return the class of a column's cells: numbers, sentences, or neither."""
    return "n" if column in table.numeric else "prose" if column in table.prose else ""


def parts_of(drawn: Sequence[Drawn]) -> list[Part]:
    """Return the sections that have a title, with unique places to link to."""
    parts: list[Part] = []
    for one in drawn:
        if one.section.title:
            words = re.sub(r"[^a-z0-9]+", "-", one.section.title.lower()).strip("-")[:40]
            place = f"section-{words}" if words else "section"
            again = sum(re.sub(r"-\d+$", "", part.id) == place for part in parts)
            place += f"-{again + 1}" if again else ""
            shown = tuple(figures(one.pictures))
            parts.append(Part(one.section, place, shown, one.failures, one.reels))
    return parts


def figures(
    pictures: Sequence[Picture], address: Callable[[Picture], str] | None = None
) -> list[Shown]:
    """Return the figures as a page shows them: inside it, or from an ``address`` beside it.

    Two that need one column each stand beside each other where they follow each other; one that
    is left alone takes both, as the place beside it would stay empty.
    """
    placed: list[Shown] = []
    half = False
    for picture in pictures:
        uri = address(picture) if address else data_uri(picture.svg)
        width, height = map(round, size(picture.svg))
        look = "wide" if width > WIDE else "tall" if height >= TALL * width else ""
        if half and look:
            placed[-1] = replace(placed[-1], look="tall")
        half = not half and not look
        shown = Shown(picture.name, picture.title, picture.caption, uri, width, height, look)
        placed.append(shown)
    if half:
        placed[-1] = replace(placed[-1], look="tall")
    return placed


def _outcome(verification: Verification) -> str:
    """Return the class of the headline: green only where each row was judged and holds."""
    verdicts = {check.verdict for check in verification.checks}
    if Verdict.FAIL in verdicts or verification.status:
        return "fail"
    return "apart" if verdicts & {Verdict.KNOWN_DEFECT, Verdict.NOT_TESTED} else ""


def _who(verification: Verification) -> str:
    provenance = verification.provenance.label if verification.provenance else "no engine"
    started = verification.started[:16].replace("T", " ")
    return f"{provenance} · {started} UTC · {verification.level} · {verification.seconds:.0f} s"
