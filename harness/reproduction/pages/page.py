"""The reproduction as a page and as Markdown, beside its figures and movies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any

from harness.report.gallery import Picture
from harness.report.page import figures
from harness.report.templating import environment
from harness.reproduction.claims import ClaimStatus, Statement
from harness.reproduction.movies import Film
from harness.reproduction.pages.findings import findings_context
from harness.reproduction.run import Reproduction

if TYPE_CHECKING:
    from jinja2 import Environment


def markdown(
    found: Reproduction, pictures: Sequence[Picture], films: Sequence[Film], root: str
) -> str:
    """Return the report as Markdown, with links to ledger, figures, movies and dumps.

    ``root`` is the repository, seen from the report's folder.
    """
    page = templates().get_template("report.md.j2")
    return page.render(**_context(found, root), pictures=pictures, films=films)


def html_page(
    found: Reproduction, pictures: Sequence[Picture], films: Sequence[Film], root: str
) -> str:
    """Return the page; figures and movies are files beside it, named relative to it.

    ``root`` is the repository, seen from the report's folder.
    """
    from markdown_it import MarkdownIt
    from markupsafe import Markup

    to_html = MarkdownIt("commonmark", {"html": False}).enable("table").render
    context = _context(found, root)
    # our own text, rendered without raw HTML
    context["findings"] = Markup(to_html(context["findings"]))
    shown = figures(pictures, lambda picture: f"figures/{picture.name}.svg")
    page = templates().get_template("reproduction.html.j2")
    return page.render(**context, pictures=shown, films=films)


def findings_text(found: Reproduction) -> str:
    """Return the findings as Markdown."""
    return templates().get_template("findings.md.j2").render(findings_context(found))


def _context(found: Reproduction, root: str) -> dict[str, Any]:
    """Return what page and Markdown tell alike; without a date, the same code makes the same."""
    engine = found.provenance
    return {
        "counts": [(status, found.ledger.count(status)) for status in ClaimStatus],
        "findings": findings_text(found),
        "rows": [(s, _explained(s), _links(s, root)) for s in found.ledger.statements],
        "provenance": [
            ("dem-harness", found.harness_version),
            ("platform", found.platform),
            ("engine", engine.told),
        ],
    }


def _explained(statement: Statement) -> str:
    """Return what was computed, with the correction or the reason behind it."""
    if statement.status is ClaimStatus.UNTESTABLE:
        return f"{statement.why[0].upper()}{statement.why[1:]}."
    text = f"{statement.computed.removesuffix('.')}."
    return f"{text} Correction: {statement.correction}." if statement.correction else text


def _links(statement: Statement, root: str) -> list[tuple[str, str]]:
    """Return name and address of each piece of evidence, seen from the report's folder."""
    return [
        (PurePosixPath(path).stem, path if path.startswith("figures/") else f"{root}/{path}")
        for path in statement.evidence
    ]


def templates() -> Environment:
    """Return the templates, and how numbers are written in them; Markdown is not escaped."""
    made = environment("harness.reproduction")
    made.autoescape = lambda name: not (name or "").endswith(".md.j2")
    made.filters |= {
        "angle": lambda value, digits: "-" if math.isnan(value) else f"{value:.{digits}f}",
        "signed": lambda value, digits: f"{value:+.{digits}f}",
        "power": lambda stiffness: f"{stiffness:.0e}".replace("e+0", "e"),
        "cell": lambda text: text.replace("|", "\\|").replace("\n", " "),
        "measured": _measured,
    }
    return made


def _measured(value: float, uncertainty: float = math.nan) -> str:
    """Return a value with its uncertainty, to the digits that the uncertainty leaves."""
    if math.isnan(value):
        return "-"
    return f"{value:.3f}" if math.isnan(uncertainty) else f"{value:.3f} ± {uncertainty:.1g}"
