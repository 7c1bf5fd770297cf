"""The report as one self-contained HTML page."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from harness.comparison.verdicts import Check, Verdict
from harness.comparison.verification import Verification
from harness.report import engines, triage
from harness.report.gallery import Picture
from harness.report.templating import environment, tail
from harness.report.text import (
    LAWS_APART,
    LAWS_HEAD,
    LAWS_TITLE,
    angle_rows,
    contacts_explained,
    laws_apart,
    provenance,
)
from harness.report.vector import data_uri, size
from harness.report.verdict_summary import SEVERITY, by_severity, headline, standings

if TYPE_CHECKING:
    from markupsafe import Markup

NUMERIC = ("value", "expected", "difference", "uncertainty", "tolerance", "used")
COLUMNS = ("verdict", "check", "kind", "value", "expected", "unit", *NUMERIC[2:])
WIDE = 2.0
"""A figure at least this much wider than high takes both columns."""


@dataclass(frozen=True)
class Row:
    """A check as the page shows it."""

    check: Check
    id: str

    @property
    def gravity(self) -> int:
        """Return where the verdict stands in the order of reading."""
        return SEVERITY.index(self.check.verdict)

    @property
    def triage(self) -> str:
        """Return the class of the failure."""
        return triage.triage(self.check)

    @property
    def details(self) -> str:
        """Return of what kind, where and when."""
        return triage.details(self.check)

    @property
    def explained(self) -> str:
        """Return what that class means."""
        return triage.explained(self.check)

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

    @property
    def short(self) -> str:
        """Return what went wrong in a line: the note, or value against expected."""
        return triage.happened(self.check)

    @property
    def tail(self) -> str:
        """Return what of the log a page shows."""
        return tail(self.check.log)


@dataclass(frozen=True)
class Shown:
    """A figure as a page shows it."""

    name: str
    title: str
    caption: str
    uri: Markup | str
    width: int
    height: int

    @property
    def wide(self) -> bool:
        """Return whether the figure takes both columns."""
        return self.width >= WIDE * self.height


def html_page(found: Verification, shown: Sequence[Picture]) -> str:
    """Return the page; figures, scripts and style are inside it, so that it can be sent alone."""
    template = environment().get_template("report.html.j2")
    rows = [Row(check, f"check-{n}") for n, check in enumerate(by_severity(found.checks), 1)]
    steps, angles = angle_rows(found)
    return template.render(
        headline=headline(found),
        who=_who(found),
        closed_form=found.incline.closed_form_deg,
        angle=found.incline.extrapolated,
        standings=standings(found.checks),
        rows=rows,
        failed=[row for row in rows if row.check.verdict is Verdict.FAIL],
        names=COLUMNS,
        numeric=NUMERIC,
        kinds=[s.kind for s in standings(found.checks)],
        verdicts=[v for v in SEVERITY if any(c.verdict is v for c in found.checks)],
        contacts=contacts_explained(),
        laws_title=LAWS_TITLE,
        laws_text=LAWS_APART,
        laws_head=LAWS_HEAD,
        laws=laws_apart(found),
        steps=steps,
        angles=angles,
        pictures=list(figures(shown)),
        engines=found.engines,
        engines_title=engines.TITLE,
        engines_text=engines.EXPLAINED,
        engine_tables=engines.tables(found.engines) if found.engines else [],
        caveats=engines.caveats(found.engines) if found.engines else [],
        scripts=found.scripts,
        logs=found.logs,
        provenance=provenance(found),
    )


def figures(shown: Sequence[Picture]) -> Iterator[Shown]:
    """Yield the figures as a page shows them."""
    for picture in shown:
        yield Shown(picture.name, picture.title, picture.caption, *embedded(picture.svg))


def embedded(svg: str) -> tuple[Markup, int, int]:
    """Return a figure as a URI that stands in an attribute as it is, with its size [pt]."""
    from markupsafe import Markup

    width, height = size(svg)
    return Markup(data_uri(svg)), round(width), round(height)


def _who(found: Verification) -> str:
    engine = found.provenance
    who = (
        (f"{engine.engine.upper()} {engine.engine_version}", engine.how)
        if engine
        else ("no engine",)
    )
    started = found.started[:16].replace("T", " ")
    return f"{', '.join(who)} · {started} UTC · {found.level} · {found.seconds:.0f} s"
