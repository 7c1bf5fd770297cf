"""Write the report of the reproduction: ledger, figures and findings in one folder.

Page and Markdown are of one template; its findings are prose, filled with the numbers of the run.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from functools import cache
from pathlib import Path, PurePath, PurePosixPath
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from harness.errors import RequestError
from harness.files import check_writable, whole_folder
from harness.observables.tower import WINDOWS
from harness.report import render
from harness.report.gallery import Picture, picture
from harness.report.markdown import markdown_environment
from harness.report.plain import write_csv
from harness.report.render import markdown_page
from harness.report.sections import Label, Table
from harness.reproduction.claims import ClaimStatus, Statement
from harness.reproduction.figures import angle_against_mfix_step, angle_against_restitution
from harness.reproduction.run import FindingTables, Reproduction, SourceFigure

if TYPE_CHECKING:
    from jinja2 import Environment


TALLEST = 19
HEIGHTS = (2, 3, 4, 10, TALLEST)
LOST = "critical_angle_lost_deg"


def findings_context(reproduction: Reproduction) -> dict[str, Any]:
    """Return what the template of the findings is filled with."""
    findings = reproduction.findings
    decided = findings.restitution[findings.restitution["reference_deg"].notna()]
    first, *_, last = decided.itertuples()
    return {
        "closed": findings.closed_form_deg,
        "engine": reproduction.provenance.engine.upper(),
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


PACKAGE, TEMPLATE = "harness.reproduction", "reproduction.md.j2"
TITLE = "Harper, Dufek and Breard (arXiv 2409.13633), recomputed"
LEDGER_HEAD = ("where", "the source says", "status", "computed here", "evidence")


def markdown(reproduction: Reproduction, pictures: Sequence[Picture], root: str) -> str:
    """Return the report as Markdown, with links to ledger and figures.

    ``root`` is the repository, seen from the report's folder.
    """
    values = _values(reproduction, root)
    return markdown_page(TEMPLATE, TITLE, PACKAGE, **values, pictures=pictures)


def html_page(reproduction: Reproduction, pictures: Sequence[Picture], root: str) -> str:
    """Return the page; figures are files beside it, named relative to it.

    ``root`` is the repository, seen from the report's folder.
    """
    values = _values(reproduction, root)
    versions = f"{reproduction.provenance.label} · dem-harness {reproduction.harness_version}"
    return render.html_page(
        TEMPLATE, TITLE, package=PACKAGE, frame={"who": versions}, **values, pictures=pictures
    )


def _values(reproduction: Reproduction, root: str) -> dict[str, Any]:
    """Return what fills the template; without a date, the same code makes the same."""
    _templates()
    statements = reproduction.ledger.statements
    rows = tuple(
        (
            statement.source.where,
            statement.source.says,
            (Label(statement.status, statement.status),),
            _explained(statement),
            _links(statement, root),
        )
        for statement in statements
    )
    counts = [(status, reproduction.ledger.count(status)) for status in ClaimStatus]
    return {
        **findings_context(reproduction),
        "counts": counts,
        "statuses": Table(
            "Statuses", "", ("statements", *(status for status, _ in counts)),
            ((str(len(statements)), *(str(count) for _, count in counts)),),
        ),
        "ledger": Table(
            "Ledger", "", LEDGER_HEAD, rows, tuple(row.source.key for row in statements)
        ),
        "provenance": [
            ("dem-harness", reproduction.harness_version),
            ("platform", reproduction.platform),
            ("engine", reproduction.provenance.label),
        ],
    }  # fmt: skip


def _explained(statement: Statement) -> str:
    """Return what was computed, with the correction or the reason behind it."""
    if statement.status is ClaimStatus.UNTESTABLE:
        return f"{statement.why[0].upper()}{statement.why[1:]}."
    text = f"{statement.computed.removesuffix('.')}."
    return f"{text} Correction: {statement.correction}." if statement.correction else text


def _links(statement: Statement, root: str) -> tuple[Label, ...]:
    """Return the names of the evidence, each leading to it as seen from the report's folder."""
    return tuple(
        Label(
            PurePosixPath(path).stem,
            address=path if path.startswith("figures/") else f"{root}/{path}",
        )
        for path in statement.evidence
    )


@cache
def _templates() -> Environment:
    """Return the templates of Markdown, which write numbers by filters of their own."""
    page, text = (markdown_environment(PACKAGE, html=html) for html in (True, False))
    for templates in (page, text):
        templates.filters |= {
            "angle": lambda value, digits: "-" if math.isnan(value) else f"{value:.{digits}f}",
            "signed": lambda value, digits: f"{value:+.{digits}f}",
            "power": lambda stiffness: f"{stiffness:.0e}".replace("e+0", "e"),
            "measured": _measured,
        }
    return text


def _measured(value: float, uncertainty: float) -> str:
    """Return a value with its uncertainty, a dash for one that was not measured."""
    return "-" if math.isnan(value) else f"{value:.3f} ± {uncertainty:.1g}"


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


def write(reproduction: Reproduction, folder: Path) -> None:
    """Write report.md, report.html, ledger.csv and figures into a folder.

    An older reproduction there is replaced as a whole. Raise RequestError as
    :func:`check_folder` does.
    """
    check_folder(folder)
    root = os.path.relpath(Path.cwd(), folder.absolute())
    with whole_folder(folder, replace=True) as aside:
        aside.mkdir()
        _fill(reproduction, aside, PurePath(root).as_posix())


def _fill(reproduction: Reproduction, folder: Path, root: str) -> None:
    (folder / "figures").mkdir()
    pictures = all_pictures(reproduction)
    for drawn in pictures:
        (folder / "figures" / f"{drawn.name}.svg").write_text(drawn.svg, encoding="utf-8")
    write_csv(reproduction.ledger.to_frame(), folder / LEDGER)
    for name, page in (("report.md", markdown), ("report.html", html_page)):
        (folder / name).write_text(page(reproduction, pictures, root), encoding="utf-8")


def all_pictures(reproduction: Reproduction) -> list[Picture]:
    """Return the source's figures in their order, then two of the findings."""
    findings, engine = reproduction.findings, reproduction.provenance.engine.upper()
    return [
        *source_pictures(reproduction.figures),
        picture(
            "finding-mfix-step",
            "Finding: the step of MFiX's scheme",
            "Critical angle of the source's contact with m/2, by our integrator in MFiX's scheme. "
            "The curves cross the closed form on their way to limits "
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
