"""The report as one self-contained HTML page."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from importlib import resources

from harness.comparison.verification import Verification
from harness.report.gallery import Picture
from harness.report.text import (
    KINDS,
    LAWS_APART,
    LAWS_HEAD,
    LAWS_TITLE,
    angle_rows,
    contacts_explained,
    laws_apart,
    number,
    provenance,
)


def html_page(found: Verification, shown: Sequence[Picture]) -> str:
    """Return the page; figures and style are inside it, so that it can be sent alone."""
    from jinja2 import Environment, StrictUndefined

    source = resources.files("harness.report").joinpath("templates", "report.html.j2")
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    environment.filters["number"] = number
    template = environment.from_string(source.read_text(encoding="utf-8"))
    steps, angles = angle_rows(found)
    groups = [(title, [c for c in found.checks if c.kind is kind]) for kind, title in KINDS.items()]
    return template.render(
        found=found,
        groups=[(title, rows) for title, rows in groups if rows],
        judged=[c for c in found.checks if c.verdict in ("pass", "fail")],
        failed=[c for c in found.checks if c.verdict == "fail"],
        contacts=contacts_explained(),
        laws_title=LAWS_TITLE,
        laws_text=LAWS_APART,
        laws_head=LAWS_HEAD,
        laws=laws_apart(found),
        steps=steps,
        angles=angles,
        pictures=[(p, _data_uri(p.svg)) for p in shown],
        provenance=provenance(found),
    )


def _data_uri(svg: str) -> str:
    return "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode()
