"""The report of the reproduction: ledger, figures, movies and findings in one folder.

The numbers of the page of findings, whose prose is ``findings.md.j2``: all from the run.

The reproduction as a page and as Markdown, beside its figures and movies.

Write the reproduction's folder beside its place first, then in place of the old one.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from pathlib import Path, PurePath, PurePosixPath
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from harness.errors import RequestError
from harness.files import check_writable, whole_folder
from harness.observables.windows import WINDOWS
from harness.report.film import base64_uri
from harness.report.gallery import Picture, picture
from harness.report.markdown import document
from harness.report.page import figures
from harness.report.plain import write_csv
from harness.report.templating import environment
from harness.reproduction.claims import ClaimStatus, Statement
from harness.reproduction.figures import angle_against_mfix_step, angle_against_restitution
from harness.reproduction.findings import FindingTables
from harness.reproduction.movies import Movie
from harness.reproduction.movies import films as draw_films
from harness.reproduction.run import Reproduction, SourceFigure

if TYPE_CHECKING:
    from jinja2 import Environment


TALLEST = 19
HEIGHTS = (2, 3, 4, 10, TALLEST)
LOST = "critical_angle_lost_deg"


def findings_context(found: Reproduction) -> dict[str, Any]:
    """Return what the template of the findings is filled with."""
    findings = found.findings
    decided = findings.restitution[findings.restitution["reference_deg"].notna()]
    first, *_, last = decided.itertuples()
    return {
        "closed": findings.closed_form_deg,
        "engine": found.provenance.engine.upper(),
        "restitution": list(findings.restitution.itertuples()),
        "first": first,
        "last": last,
        "steps": first.steps_per_contact,
        **_heights(findings),
        **_mfix(findings),
    }


def _heights(findings: FindingTables) -> dict[str, Any]:
    at, closed = findings.at_height, findings.closed_form_deg
    tall, overlap = at(TALLEST, "deformable"), at(TALLEST, "overlap")
    return {
        "tall": tall,
        "overlap": overlap,
        "deformable2": at(2, "deformable"),
        "overlap2": at(2, "overlap"),
        "explained": (closed - float(overlap[LOST])) / (closed - float(tall[LOST])),
        "windows": [
            (n, law, [_window(at(n, law, window)) for window in WINDOWS])
            for n in HEIGHTS
            for law in ("overlap", "deformable")
        ],
        "n2": {w: float(at(2, "deformable", w)[LOST]) for w in ("turnaround", "structure")},
    }


def _window(row: pd.Series) -> str:
    if math.isnan(row["impulse_ratio"]):
        return "-"
    return f"{row['impulse_ratio']:.3f}, {row[LOST]:.2f}"


def _mfix(findings: FindingTables) -> dict[str, Any]:
    closed = findings.closed_form_deg
    at_1e6 = findings.mfix[findings.mfix["stiffness_N_per_m"] == 1e6].set_index("factor")
    limits = findings.limits.set_index("stiffness_N_per_m")["critical_angle_deg"]
    return {
        "mfix": list(findings.mfix.itertuples()),
        "limits": list(findings.limits.itertuples()),
        "default_off": float(at_1e6["euler_deg"][50]) - closed,
        "crossing": _crossing(at_1e6["euler_deg"].sort_index() - closed),
        "limit6": float(limits[1e6]),
    }


def _crossing(off: pd.Series) -> float:
    """Return the factor, the index, at which ``off`` first rises through 0, NaN where it does not.

    Straight between two factors on the logarithmic axis of the figure.
    """
    value, log = off.to_numpy(), np.log(off.index.to_numpy())
    rises = np.flatnonzero((value[:-1] <= 0) & (value[1:] > 0))
    if rises.size == 0:
        return math.nan
    i = int(rises[0])
    return math.exp(log[i] - value[i] * (log[i + 1] - log[i]) / (value[i + 1] - value[i]))


def markdown(
    found: Reproduction, pictures: Sequence[Picture], films: Sequence[Movie], root: str
) -> str:
    """Return the report as Markdown, with links to ledger, figures, movies and dumps.

    ``root`` is the repository, seen from the report's folder.
    """
    page = templates().get_template("report.md.j2")
    return page.render(**_context(found, root), pictures=pictures, films=films)


def html_page(
    found: Reproduction, pictures: Sequence[Picture], films: Sequence[Movie], root: str
) -> str:
    """Return the page; figures and movies are files beside it, named relative to it.

    ``root`` is the repository, seen from the report's folder.
    """
    from markupsafe import Markup

    context = _context(found, root)
    # our own text, rendered without raw HTML
    context["findings"] = Markup(document(context["findings"]).body)
    shown = figures(pictures, lambda picture: f"figures/{picture.name}.svg")
    page = templates().get_template("reproduction.html.j2")
    return page.render(**context, pictures=shown, films=films)


def findings_text(found: Reproduction) -> str:
    """Return the findings as Markdown."""
    return templates().get_template("findings.md.j2").render(findings_context(found))


def _context(reproduction: Reproduction, root: str) -> dict[str, Any]:
    """Return what page and Markdown tell alike; without a date, the same code makes the same."""
    engine = reproduction.provenance
    return {
        "counts": [(status, reproduction.ledger.count(status)) for status in ClaimStatus],
        "findings": findings_text(reproduction),
        "rows": [(s, _explained(s), _links(s, root)) for s in reproduction.ledger.statements],
        "provenance": [
            ("dem-harness", reproduction.harness_version),
            ("platform", reproduction.platform),
            ("engine", engine.label),
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


LEDGER = "ledger.csv"


def check_folder(folder: Path) -> None:
    """Raise RequestError for a folder that cannot take the report.

    One that holds an older reproduction (a ledger) is replaced; one that holds
    something else is not touched.
    """
    if folder.exists() and not folder.is_dir():
        raise RequestError(f"--output {folder}: is a file; name a folder")
    ours = folder.is_dir() and (folder / LEDGER).is_file()
    if folder.is_dir() and any(folder.iterdir()) and not ours:
        raise RequestError(
            f"--output {folder}: holds something that is not a reproduction; name a new folder"
        )
    check_writable(folder)


def write(found: Reproduction, folder: Path) -> None:
    """Write report.md, report.html, ledger.csv, figures, movies and dumps into a folder.

    An older reproduction there is replaced as a whole. Raise RequestError as
    :func:`check_folder` does.
    """
    check_folder(folder)
    root = os.path.relpath(Path.cwd(), folder.absolute())
    with whole_folder(folder, replace=True) as aside:
        aside.mkdir()
        _fill(found, aside, PurePath(root).as_posix())


def _fill(reproduction: Reproduction, folder: Path, root: str) -> None:
    for name in ("figures", "movies", "dumps"):
        (folder / name).mkdir()
    pictures, films = all_pictures(reproduction), draw_films(reproduction.motions)
    for shown in pictures:
        (folder / "figures" / f"{shown.name}.svg").write_text(shown.svg, encoding="utf-8")
    for film in films:
        (folder / "movies" / f"{film.name}.gif").write_bytes(film.gif)
        # a page that is opened from a disk may load a script, and no other file
        uri = base64_uri(film.gif, "image/gif")
        (folder / "movies" / f"{film.name}.gif.js").write_text(f'filmData("{uri}");\n', "ascii")
        (folder / "movies" / f"{film.name}.png").write_bytes(film.still)
        (folder / "dumps" / f"{film.name}.dump.gz").write_bytes(film.dump)
    write_csv(reproduction.ledger.frame(), folder / LEDGER)
    for name, page in (("report.md", markdown), ("report.html", html_page)):
        (folder / name).write_text(page(reproduction, pictures, films, root), encoding="utf-8")


def all_pictures(found: Reproduction) -> list[Picture]:
    """Return the source's figures in their order, then two of the findings."""
    findings, engine = found.findings, found.provenance.engine.upper()
    return [
        *source_pictures(found.figures),
        picture(
            "finding-mfix-step",
            "Finding: the step of MFiX's scheme",
            "Critical angle of the source's contact with m/2, by our integrator in MFiX's scheme "
            "and as recorded with MFiX. The curves cross the closed form on their way to limits "
            "that only a stiffer contact brings down. Bars: resolution of the search, and where "
            "in a step a contact begins.",
            lambda: angle_against_mfix_step(findings),
        ),
        picture(
            "finding-restitution",
            "Finding: what a rebound does to the angle",
            "The two readings of the source's shock, and what a DEM does.",
            lambda: angle_against_restitution(findings, engine),
        ),
    ]


def source_pictures(figures: Sequence[SourceFigure]) -> list[Picture]:
    """Return a picture for each figure of the source but those that cannot be drawn again.

    Its title names the figure that it answers, its caption is the sentence of the statement.
    """
    return [
        picture(
            row.source.picture,
            f"{row.source.where.capitalize()} of the source: {row.source.title}",
            row.computed,
            draw,
        )
        for row, draw in figures
        if draw is not None
    ]
