"""The report of a run: one HTML page that works offline, one Markdown page, and the figures.

``report_files(run, sections)`` returns them by their path in the folder of the run, which
``harness.store.runs.write_run`` writes.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from harness.files import safe_path
from harness.report.causes import Defects, causes, entries_of
from harness.report.content import Drawing, Section
from harness.report.figures import Picture, draw_all, svg_uri
from harness.report.matrix import divided_setups, matrix
from harness.report.render import html_page, markdown_page
from harness.report.text import SHORT, number
from harness.results.compare import counts, counts_of_changes
from harness.results.rows import KEY, Kind, Row, Verdict

if TYPE_CHECKING:
    import pandas as pd

    from harness.store.runs import Run

TITLE = "DEM verification"
MARKDOWN_LIMIT = 60_000  # characters: a comment on a pull request holds 65,536
LOG_TAIL = 3_000  # characters of the log of a failed run that the page shows
FINDINGS = 20  # shown without unfolding
MOST_FILES = 60  # scripts and logs that the page names
EMBEDDED = 60_000  # characters of scripts and logs in the page; the others are links
COLUMNS = ("verdict", "row", "kind", "engine", "value", "expected", "unit", "difference",
           "uncertainty", "tolerance", "used")  # fmt: skip
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
    def shown(self) -> bool:
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
    parts = drawn_parts(sections, png=png)
    values = _values(run, parts, defects or {})
    values |= {"title": title, "headline": headline or run.headline}
    files: dict[str, str | bytes] = {
        "report.html": html_page("report.html.j2", **values),
        "report.md": shortened(markdown_page("report.md.j2", **values), MARKDOWN_LIMIT),
    }
    return files | figure_files(parts)


def drawn_parts(sections: Iterable[Section], *, png: bool = False) -> list[Part]:
    """Return sections with their figures drawn; names of figures are unique names of files."""
    named = _with_file_names(sections)
    pictures = iter(draw_all([one for section in named for one in section.drawings], png=png))
    parts = []
    for place, section in enumerate(named, 1):
        own = [next(pictures) for _ in section.drawings]
        chosen = section.opening.figure if section.opening else ""
        first = next((one for one in own if chosen and one.drawing.name == chosen), None)
        parts.append(
            Part(f"section-{place}", section, first, tuple(one for one in own if one is not first))
        )
    return parts


def figure_files(parts: Iterable[Part]) -> dict[str, str | bytes]:
    """Return the figures of sections as files below ``figures``."""
    files: dict[str, str | bytes] = {}
    for part in parts:
        for picture in (*((part.first,) if part.first else ()), *part.pictures):
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


def _with_file_names(sections: Iterable[Section]) -> list[Section]:
    seen: Counter[str] = Counter()

    def renamed(drawing: Drawing) -> Drawing:
        name = re.sub(r"[^A-Za-z0-9._+-]+", "-", drawing.name).strip(".-") or "figure"
        seen[name] += 1
        return replace(drawing, name=name if seen[name] == 1 else f"{name}-{seen[name]}")

    def with_names(section: Section) -> Section:
        drawings = tuple(map(renamed, section.drawings))
        names = {old.name: new.name for old, new in zip(section.drawings, drawings, strict=True)}
        opening = section.opening
        if opening is not None:
            opening = replace(opening, figure=names.get(opening.figure, ""))
        return replace(section, drawings=drawings, opening=opening)

    return [with_names(section) for section in sections]


def _values(run: Run, parts: Sequence[Part], defects: Defects) -> dict[str, Any]:
    entries = entries_of(run.rows)
    verdicts = Counter(str(entry.row.verdict) for entry in entries)
    present = [str(verdict) for verdict in Verdict if verdict in verdicts]
    openings = [part for part in parts if part.section.opening]
    values: dict[str, Any] = {
        "run": run,
        "who": _who(run),
        "outcome": _outcome(run, verdicts),
        "counts": [f"{verdicts[verdict]} {verdict}" for verdict in present],
        "answers": [a for part in openings for a in part.section.opening.answers],  # type: ignore[union-attr]
        "openings": openings,
        "verdicts": _verdict_table(run.rows),
        "causes": causes(entries, defects),
        **_changes(run),
        "findings": [entry for entry in entries if entry.row.verdict is Verdict.FINDING],
        "most": FINDINGS,
        "entries": entries,
        "columns": COLUMNS,
        "present": present,
        "kinds": [kind for kind in map(str, Kind) if (run.rows["kind"] == kind).any()],
        "engines": sorted(set(run.rows["engine"])),
        "tail": LOG_TAIL,
        "matrices": _matrices(run.rows),
        "parts": parts,
        "files": _script_files(run),
        "facts": _facts(run),
    }
    return values | {"headings": _headings(values)}


def _who(run: Run) -> str:
    engines = ", ".join(f"{name} {version}".strip() for name, version in run.meta.engines.items())
    started = run.meta.started[:16].replace("T", " ")
    return f"{engines or 'no engine'} · {started} UTC · {run.meta.level} · {run.meta.seconds:.0f} s"


def _outcome(run: Run, verdicts: Mapping[str, int]) -> str:
    """Return the class of the headline: green only where every row was judged and holds."""
    if run.status:
        return "fail"
    apart = (Verdict.KNOWN_DEFECT, Verdict.NOT_TESTED)
    return "apart" if any(verdicts.get(verdict) for verdict in apart) else ""


def _verdict_table(rows: pd.DataFrame) -> pd.DataFrame:
    """Return how many rows of each kind have each verdict, which are never added up."""
    from harness.report.render import Badge

    table = counts(rows)
    cells = {
        verdict: [Badge(str(n), str(verdict)) if n else "" for n in table[verdict]]
        for verdict in table.columns
    }
    kinds = [KIND_TITLES[Kind(kind)] for kind in table.index]
    return type(rows)({"kind": kinds, **cells})


def _changes(run: Run) -> dict[str, Any]:
    """Return the changes against the accepted run: their numbers, and those that fail the run."""
    if run.changes is None:
        return {"changed": None, "regressions": None}
    numbers = [f"{number} {change}" for change, number in counts_of_changes(run.changes).items()]
    return {"changed": ", ".join(numbers) or "no row in common", "regressions": _moves(run)}


def _moves(run: Run) -> pd.DataFrame | None:
    """Return the changes that fail the run, with the values before and after."""
    from harness.report.render import Badge

    found = run.regressions
    if found.empty:
        return None

    def verdicts(line: Mapping[Any, Any]) -> list[str]:
        pair = (line["verdict_before"], line["verdict_after"])
        return [verdict for verdict in pair if isinstance(verdict, str)]

    records = found.fillna(dict.fromkeys(KEY, "")).to_dict("records")
    moves = [
        {
            "change": line["change"],
            "row": Row(**{name: line[name] for name in KEY}).name,
            "accepted": line["value_before"],
            "now": line["value_after"],
            "moved by": number(line["moved_by"], SHORT),
            "in tolerances": number(line["in_tolerances"], SHORT),
            "verdict": [Badge(v, v) for v in dict.fromkeys(verdicts(line))],
        }
        for line in records
    ]
    return type(found)(moves)


def _matrices(rows: pd.DataFrame) -> list[tuple[str, str, pd.DataFrame]]:
    if rows["engine"].nunique() < 2 or rows["case"].nunique() < 2:
        return []
    tables = [
        ("Matrix", "Rows of each case by engine and verdict.", matrix(rows, "case", "engine"))
    ]
    divided = divided_setups(rows)
    if not divided.empty:
        caption = "Setups that fail or show a known defect: the gravest verdict in each engine."
        tables.append(("Setups", caption, divided))
    return tables


def _script_files(run: Run) -> list[tuple[str, str, str]]:
    """Return name, address and text of scripts and logs; no text beyond what a page holds."""
    scripts = [(name, f"scripts/{safe_path(name)}", text) for name, text in run.scripts.items()]
    logs = [(f"log: {n}", f"logs/{safe_path(n)}", t[-LOG_TAIL:]) for n, t in run.logs.items()]
    left, files = EMBEDDED, []
    for title, address, text in [*scripts[:MOST_FILES], *logs[:MOST_FILES]]:
        left -= len(text)
        files.append((title, address, text if left >= 0 else ""))
    if len(scripts) > MOST_FILES:
        files.append((f"all {len(scripts)} scripts", "scripts/", ""))
    return files


def _facts(run: Run) -> list[tuple[str, str]]:
    meta = run.meta
    pairs = [
        ("started", f"{meta.started} (UTC)"),
        ("duration", f"{meta.seconds:.1f} s"),
        ("level", meta.level),
        ("cases", ", ".join(meta.cases)),
        ("only", "" if meta.only == "*" else meta.only),
        *(
            (f"engine {name}", version or "could not be run")
            for name, version in meta.engines.items()
        ),
        ("dem-harness", meta.harness_version),
        ("platform", meta.platform),
    ]
    return [(name, text) for name, text in pairs if text]


def _headings(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return id and text of the headings of the page that the navigation names."""
    parts: Sequence[Part] = values["parts"]
    names = [
        *(["Answer"] if values["openings"] else []),
        "Verdicts",
        *(["Causes"] if values["causes"] else []),
        *(["Changes"] if values["changed"] is not None else []),
        *(["Findings"] if values["findings"] else []),
        "Rows",
        *(name for name, _, _ in values["matrices"]),
    ]
    last = ["Scripts", "Provenance"] if values["files"] else ["Provenance"]
    return [
        *((name.lower(), name) for name in names),
        *((part.id, part.section.title) for part in parts if part.shown),
        *((name.lower(), name) for name in last),
    ]
