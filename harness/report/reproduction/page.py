"""The reproduction as an HTML page beside its figures and movies."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import resources

from harness.comparison.reproduction import Reproduction
from harness.report.gallery import Picture
from harness.report.movies.film import Film
from harness.report.reproduction.findings import findings_text
from harness.report.reproduction.text import (
    FIGURES,
    LEAD,
    MOVIES,
    TITLE,
    counts,
    explained,
    links,
    provenance,
)


def html_page(found: Reproduction, pictures: Sequence[Picture], films: Sequence[Film]) -> str:
    """Return the page; figures and movies are files beside it, named relative to it."""
    from jinja2 import Environment, StrictUndefined
    from markdown_it import MarkdownIt
    from markupsafe import Markup

    source = resources.files("harness.report").joinpath("templates", "reproduction.html.j2")
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    to_html = MarkdownIt("commonmark", {"html": False}).enable("table").render
    return environment.from_string(source.read_text(encoding="utf-8")).render(
        title=TITLE,
        lead=LEAD.replace("`", ""),
        counts=counts(found),
        total=len(found.ledger.statements),
        # our own text, rendered without raw HTML
        findings=Markup(to_html(findings_text(found))),
        rows=[(s, explained(s), links(s)) for s in found.ledger.statements],
        figures_text=FIGURES,
        pictures=pictures,
        movies_text=MOVIES,
        films=films,
        provenance=provenance(found),
    )
