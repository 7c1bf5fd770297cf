"""The report of a run: one HTML page that works offline, one Markdown page, and the figures.

``report_files(run, sections)`` returns them by their path in the folder of the run, which
``harness.store.runs.write_run`` writes. The HTML page has all rows as packed JSON, which its script
turns into a table; without a script it shows those to look at first.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import pandas as pd

from harness.files import safe_path
from harness.report.content import Drawing, Section
from harness.report.figures import Picture, draw, svg_uri
from harness.report.render import html_page, markdown_page
from harness.report.rows import (
    COLUMNS,
    LOG_TAIL,
    ORDER,
    WITH_CAUSE,
    Badge,
    Defects,
    causes,
    divided_setups,
    entries_of,
    matrix,
    packed,
)
from harness.report.text import SHORT, number
from harness.results.compare import counts, counts_of_changes
from harness.results.rows import KEY, Kind, Row, Verdict

if TYPE_CHECKING:
    from harness.store.runs import Run

TITLE = "DEM verification"
MARKDOWN_LIMIT = 60_000  # characters: a comment on a pull request holds 65,536
MOST_FINDINGS = 20  # shown without unfolding
FEWEST_ROWS, MOST_ROWS = 25, 100  # of the table without a script
MOST_FILES = 60  # scripts and logs that the page names
EMBEDDED = 60_000  # characters of scripts and logs in the page; the others are links
KIND_TITLES = {
    Kind.ANALYTIC: "analytic: against a closed form",
    Kind.CROSS_CODE: "cross-code: against the reference, a solver or another code",
    Kind.FINDING: "finding: a difference between models, not judged",
    Kind.RECORDED: "recorded: against the accepted run alone",
}


@dataclass(frozen=True)
class Part:
    """A section with its id in the page and its figures: that of the opening, and the others."""

    id: str
    section: Section
    first: Picture | None
    pictures: tuple[Picture, ...]

    @property
    def has_body(self) -> bool:
        """Return whether the section has more than its opening."""
        return bool(self.section.text or self.section.tables or self.pictures)

    @property
    def sketch(self) -> str:
        """Return the sketch of the opening as a data URI."""
        return svg_uri(self.section.opening.sketch) if self.section.opening else ""


def report_files(
    run: Run,
    sections: Sequence[Section],
    *,
    defects: Defects | None = None,
    png: bool = False,
    title: str = TITLE,
    headline: str = "",
) -> dict[str, str | bytes]:
    """Return the files of a report by their path: report.html, report.md and figures.

    ``defects`` are the known defects by name, as in inputs/known-defects.toml, for their causes.
    With ``png`` figures are PNG, too. An error of a figure is text in its place. ``headline`` is
    the first sentence, that of the run unless given.
    """
    parts = list(_drawn_parts(sections, png=png))
    values = _values(run, parts, defects or {})
    values |= {"title": title, "headline": headline or run.headline}
    files: dict[str, str | bytes] = {
        "report.html": html_page("report.html.j2", **values),
        "report.md": shortened(markdown_page("report.md.j2", **values), MARKDOWN_LIMIT),
    }
    for picture in (p for part in parts for p in (part.first, *part.pictures) if p is not None):
        name = f"figures/{picture.drawing.name}"
        files |= {f"{name}.svg": picture.svg} if picture.svg else {}
        files |= {f"{name}.png": picture.png} if picture.png else {}
    return files


def shortened(text: str, limit: int) -> str:
    """Return Markdown cut between two blocks below a number of characters, with a last sentence."""
    end = "\n\nThe rest is in report.html.\n"
    if len(text) <= limit:
        return text
    return text[: limit - len(end)].rpartition("\n\n")[0] + end


def _drawn_parts(sections: Iterable[Section], *, png: bool) -> Iterator[Part]:
    """Yield sections with their figures drawn; names of figures are made unique file names."""
    numbers = Counter[str]()
    for place, section in enumerate(sections, 1):
        pictures, first = [], None
        for drawing in section.drawings:
            picture = draw(replace(drawing, name=_file_name(drawing, numbers)), png=png)
            if section.opening and section.opening.figure == drawing.name and first is None:
                first = picture
            else:
                pictures.append(picture)
        yield Part(f"section-{place}", section, first, tuple(pictures))


def _file_name(drawing: Drawing, numbers: Counter[str]) -> str:
    name = re.sub(r"[^A-Za-z0-9._+-]+", "-", drawing.name).strip(".-") or "figure"
    numbers[name] += 1
    return name if numbers[name] == 1 else f"{name}-{numbers[name]}"


def _values(run: Run, parts: Sequence[Part], defects: Defects) -> dict[str, Any]:
    """Return the values of both templates by name."""
    entries = entries_of(run.rows)
    causes_ = causes(entries, defects)
    numbers = Counter(str(entry.row.verdict) for entry in entries)
    present = [verdict for verdict in ORDER if verdict in numbers]
    attention = sum(numbers[verdict] for verdict in WITH_CAUSE)
    openings = [part.section.opening for part in parts if part.section.opening]
    versions = ", ".join(f"{name} {version}".strip() for name, version in run.meta.engines.items())
    started = run.meta.started[:16].replace("T", " ")
    times = f"{started} UTC · {run.meta.level} · {run.meta.seconds:.0f} s"
    values: dict[str, Any] = {
        "who": f"{versions or 'no engine'} · {times}",
        "outcome": _outcome(run, numbers),
        "counts": [f"{numbers[verdict]} {verdict}" for verdict in present],
        "answers": [answer for opening in openings for answer in opening.answers],
        "openings": [part for part in parts if part.section.opening],
        "verdicts": _verdict_table(run.rows),
        "causes": causes_,
        **_changes(run),
        "findings": [entry for entry in entries if entry.row.verdict is Verdict.FINDING],
        "most": MOST_FINDINGS,
        "count": len(entries),
        "first_rows": entries[: min(max(attention, FEWEST_ROWS), MOST_ROWS)],
        "packed": packed(entries, causes_),
        "columns": COLUMNS,
        "choices": {
            "verdict": present,
            "kind": [kind for kind in map(str, Kind) if (run.rows["kind"] == kind).any()],
            "engine": sorted(set(run.rows["engine"])),
        },
        "matrices": _matrices(run.rows),
        "parts": parts,
        "files": _script_files(run),
        "facts": _facts(run),
    }  # fmt: skip
    return values | {"headings": list(_headings(values))}


def _outcome(run: Run, numbers: Mapping[str, int]) -> str:
    """Return the class of the headline: green only where every row was judged and none fails."""
    if run.status:
        return "fail"
    return "partial" if numbers[Verdict.KNOWN_DEFECT] or numbers[Verdict.NOT_TESTED] else ""


def _verdict_table(rows: pd.DataFrame) -> pd.DataFrame:
    """Return how many rows of each kind have each verdict; kinds are never added up."""
    table = counts(rows)
    cells = {
        verdict: [Badge(str(n), str(verdict)) if n else "" for n in table[verdict]]
        for verdict in table.columns
    }
    return pd.DataFrame({"kind": [KIND_TITLES[Kind(kind)] for kind in table.index], **cells})


def _changes(run: Run) -> dict[str, Any]:
    """Return the changes against the accepted run: their numbers, and those that fail the run."""
    if run.changes is None:
        return {"changed": None, "regressions": None}
    numbers = [f"{number} {change}" for change, number in counts_of_changes(run.changes).items()]
    frame = run.regressions.fillna(dict.fromkeys(KEY, ""))
    keys = frame[list(KEY)].itertuples(index=False)
    verdicts = zip(frame["verdict_before"], frame["verdict_after"], strict=True)
    table = pd.DataFrame({
        "change": list(frame["change"]),
        "row": [Row(**dict(zip(KEY, key, strict=True))).name for key in keys],
        "accepted": list(frame["value_before"]),
        "now": list(frame["value_after"]),
        "in tolerances": [number(moved, SHORT) for moved in frame["in_tolerances"]],
        "verdict": [[Badge(v, v) for v in dict.fromkeys(pair) if isinstance(v, str)]
                    for pair in verdicts],
    })  # fmt: skip
    return {
        "changed": ", ".join(numbers) or "no row in common",
        "regressions": None if table.empty else table,
    }


def _matrices(rows: pd.DataFrame) -> list[tuple[str, str, pd.DataFrame]]:
    """Return title, caption and table of cases by engines, and of setups that fail in some."""
    if rows["engine"].nunique() < 2 or rows["case"].nunique() < 2:
        return []
    caption = "Setups that fail or show a known defect: the gravest verdict in each engine."
    tables = [
        ("Matrix", "Rows of each case by engine and verdict.", matrix(rows, "case", "engine")),
        ("Setups", caption, divided_setups(rows)),
    ]
    return [table for table in tables if not table[2].empty]


def _script_files(run: Run) -> list[tuple[str, str, str]]:
    """Return name, address and text of scripts and logs; no text beyond the size of a page."""
    scripts = [(name, f"scripts/{safe_path(name)}", text) for name, text in run.scripts.items()]
    logs = [(f"log: {n}", f"logs/{safe_path(n)}", t[-LOG_TAIL:]) for n, t in run.logs.items()]
    files, size = [], 0
    for title, address, text in [*scripts[:MOST_FILES], *logs[:MOST_FILES]]:
        size += len(text)
        files.append((title, address, text if size <= EMBEDDED else ""))
    if len(scripts) > MOST_FILES:
        files.append((f"all {len(scripts)} scripts", "scripts/", ""))
    return files


def _facts(run: Run) -> list[tuple[str, str]]:
    meta = run.meta
    engines = {f"engine {name}": v or "could not be run" for name, v in meta.engines.items()}
    facts = {
        "started": f"{meta.started} (UTC)",
        "duration": f"{meta.seconds:.1f} s",
        "level": meta.level,
        "cases": ", ".join(meta.cases),
        "only": "" if meta.only == "*" else meta.only,
        **engines,
        "dem-harness": meta.harness_version,
        "platform": meta.platform,
    }
    return [(name, text) for name, text in facts.items() if text]


def _headings(values: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield id and text of the headings that the navigation names."""
    present = {
        "Answer": values["openings"],
        "Verdicts": True,
        "Causes": values["causes"],
        "Changes": values["changed"] is not None,
        "Findings": values["findings"],
        "Rows": True,
        **{title: True for title, _, _ in values["matrices"]},
    }
    yield from ((name.lower(), name) for name, condition in present.items() if condition)
    yield from ((part.id, part.section.title) for part in values["parts"] if part.has_body)
    if values["files"]:
        yield "scripts", "Scripts"
    yield "provenance", "Provenance"
