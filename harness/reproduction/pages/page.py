"""The reproduction as an HTML page beside its figures and movies."""

from __future__ import annotations

from collections.abc import Sequence

from harness.report.gallery import Picture
from harness.report.page import figures
from harness.reproduction.movies import Film
from harness.reproduction.pages import text
from harness.reproduction.pages.findings import findings_text
from harness.reproduction.pages.templates import templates
from harness.reproduction.run import Reproduction


def html_page(
    found: Reproduction, pictures: Sequence[Picture], films: Sequence[Film], root: str
) -> str:
    """Return the page; figures and movies are files beside it, named relative to it.

    ``root`` is the repository, seen from the report's folder.
    """
    from markdown_it import MarkdownIt
    from markupsafe import Markup

    to_html = MarkdownIt("commonmark", {"html": False}).enable("table").render
    page = templates().get_template("reproduction.html.j2")
    return page.render(
        title=text.TITLE,
        lead=text.LEAD.replace("`", ""),
        counts=text.counts(found),
        total=len(found.ledger.statements),
        # our own text, rendered without raw HTML
        findings=Markup(to_html(findings_text(found))),
        rows=[(s, text.explained(s), text.links(s, root)) for s in found.ledger.statements],
        figures_text=text.FIGURES,
        pictures=figures(pictures, lambda picture: f"figures/{picture.name}.svg"),
        movies_text=text.MOVIES,
        films=films,
        provenance=text.provenance(found),
    )
