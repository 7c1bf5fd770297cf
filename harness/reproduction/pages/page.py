"""The reproduction as an HTML page beside its figures and movies."""

from __future__ import annotations

from collections.abc import Sequence

from harness.report.gallery import Picture
from harness.report.page import Shown
from harness.report.vector import size
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
        pictures=[_shown(picture) for picture in pictures],
        movies_text=text.MOVIES,
        films=films,
        provenance=text.provenance(found),
    )


def _shown(picture: Picture) -> Shown:
    """Return a figure as the page shows it: a file beside it."""
    width, height = size(picture.svg)
    address = f"figures/{picture.name}.svg"
    return Shown(picture.name, picture.title, picture.caption, address, round(width), round(height))
