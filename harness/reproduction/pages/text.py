"""The reproduction as Markdown, and the words that it shares with the page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import PurePosixPath

from harness.report.gallery import Picture
from harness.reproduction.claims import ClaimStatus, Statement
from harness.reproduction.movies import Film
from harness.reproduction.pages.findings import findings_text
from harness.reproduction.run import Reproduction

TITLE = "Harper, Dufek and Breard (arXiv 2409.13633), recomputed"

LEAD = (
    "One row for every numbered equation, testable number and figure of the source, both "
    "appendices included, and for each erratum. A row holds what the statement gives as it "
    "stands, the same quantity by a route of its own, and the status that follows. The errata "
    "come last, with those of our own restatement, from which this harness was planned. "
    "`dem-harness reproduce` makes such a folder; nothing in it is typed in."
)

FIGURES = (
    "Redrawn from our own runs with the axes of the source; the sentence below each says what "
    "agrees and what does not."
)

MOVIES = (
    "The source's supplement shows two and three particles; incline and tower are added. The "
    "dump files beside them are LAMMPS text dumps, which OVITO opens."
)


def markdown(
    found: Reproduction, pictures: Sequence[Picture], films: Sequence[Film], root: str
) -> str:
    """Return the report as Markdown, with links to ledger, figures, movies and dumps.

    ``root`` is the repository, seen from the report's folder.
    """
    lines = [f"# {TITLE}", "", LEAD, "", *_counts(found), "", "## Findings", ""]
    lines += [findings_text(found), "", "## Ledger", ""]
    lines += ["As a table for pandas: [ledger.csv](ledger.csv).", ""]
    lines += ["| where | the source says | status | computed here | evidence |"]
    lines += ["|---|---|---|---|---|", *(_row(s, root) for s in found.ledger.statements)]
    lines += ["", "## Figures", "", FIGURES, ""]
    for picture in pictures:
        lines += [f"### {picture.title}", "", f"![{picture.title}](figures/{picture.name}.svg)", ""]
        lines += [picture.caption, ""]
    lines += ["## Movies", "", f"{MOVIES} A still starts its movie when it is clicked.", ""]
    for film in films:
        still = f"![{film.title}](movies/{film.name}.png)"
        lines += [f"### {film.title}", "", f"[{still}](movies/{film.name}.gif)", ""]
        lines += [f"{film.caption} Dump: [{film.name}.dump.gz](dumps/{film.name}.dump.gz).", ""]
    lines += ["## Provenance", "", *(f"- {name}: {text}" for name, text in provenance(found)), ""]
    return "\n".join(lines)


def counts(found: Reproduction) -> list[tuple[ClaimStatus, int]]:
    """Return how many statements have each status."""
    return [(status, found.ledger.count(status)) for status in ClaimStatus]


def explained(statement: Statement) -> str:
    """Return what was computed, with the correction or the reason behind it."""
    if statement.status is ClaimStatus.UNTESTABLE:
        return f"{statement.why[0].upper()}{statement.why[1:]}."
    text = f"{statement.computed.removesuffix('.')}."
    return f"{text} Correction: {statement.correction}." if statement.correction else text


def links(statement: Statement, root: str) -> list[tuple[str, str]]:
    """Return name and address of each piece of evidence, seen from the report's folder."""
    return [
        (PurePosixPath(path).stem, path if path.startswith("figures/") else f"{root}/{path}")
        for path in statement.evidence
    ]


def provenance(found: Reproduction) -> list[tuple[str, str]]:
    """Return what made this report; no date, so that the same code makes the same files."""
    engine = found.provenance
    return [
        ("dem-harness", found.harness_version),
        ("platform", found.platform),
        ("engine", f"{engine.engine} {engine.engine_version}, {engine.how}"),
    ]


def _counts(found: Reproduction) -> list[str]:
    cells = [("statements", len(found.ledger.statements)), *counts(found)]
    names, values = (" | ".join(str(part) for part in row) for row in zip(*cells, strict=True))
    return [f"| {names} |", f"|{'--:|' * len(cells)}", f"| {values} |"]


def _row(statement: Statement, root: str) -> str:
    source = statement.source
    evidence = "<br>".join(f"[{name}]({address})" for name, address in links(statement, root))
    cells = [source.where, source.says, str(statement.status), explained(statement), evidence]
    return "| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in cells) + " |"
