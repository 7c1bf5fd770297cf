"""Write the reproduction's folder beside its place first, then in place of the old one."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path, PurePath

from harness.atomic_write import whole_folder
from harness.errors import RequestError
from harness.report.gallery import Picture, picture
from harness.report.gif import base64_uri
from harness.report.plain import write_csv
from harness.report.target import check_writable
from harness.reproduction.figure_data.compute import SourceFigure
from harness.reproduction.figures.findings import angle_against_mfix_step, angle_against_restitution
from harness.reproduction.movies import films as draw_films
from harness.reproduction.pages.page import html_page, markdown
from harness.reproduction.run import Reproduction

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


def _fill(found: Reproduction, folder: Path, root: str) -> None:
    for name in ("figures", "movies", "dumps"):
        (folder / name).mkdir()
    pictures, films = all_pictures(found), draw_films(found.motions)
    for shown in pictures:
        (folder / "figures" / f"{shown.name}.svg").write_text(shown.svg, encoding="utf-8")
    for film in films:
        (folder / "movies" / f"{film.name}.gif").write_bytes(film.gif)
        # a page that is opened from a disk may load a script, and no other file
        uri = base64_uri(film.gif, "image/gif")
        (folder / "movies" / f"{film.name}.gif.js").write_text(f'filmData("{uri}");\n', "ascii")
        (folder / "movies" / f"{film.name}.png").write_bytes(film.still)
        (folder / "dumps" / f"{film.name}.dump.gz").write_bytes(film.dump)
    write_csv(found.ledger.frame(), folder / LEDGER)
    for name, page in (("report.md", markdown), ("report.html", html_page)):
        (folder / name).write_text(page(found, pictures, films, root), encoding="utf-8")


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
