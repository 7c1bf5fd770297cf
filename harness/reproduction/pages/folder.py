"""Write the reproduction's folder beside its place first, then in place of the old one."""

from __future__ import annotations

import os
from pathlib import Path, PurePath

from harness.atomic_write import whole_folder
from harness.errors import RequestError
from harness.report.target import check_writable
from harness.reproduction.movies import films as draw_films
from harness.reproduction.pages.page import html_page, markdown
from harness.reproduction.pages.pictures import all_pictures
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
    for picture in pictures:
        (folder / "figures" / f"{picture.name}.svg").write_text(picture.svg, encoding="utf-8")
    for film in films:
        (folder / "movies" / f"{film.name}.gif").write_bytes(film.gif)
        (folder / "movies" / f"{film.name}.png").write_bytes(film.still)
        (folder / "dumps" / f"{film.name}.dump.gz").write_bytes(film.dump)
    found.ledger.frame().to_csv(folder / LEDGER, index=False)
    for name, page in (("report.md", markdown), ("report.html", html_page)):
        (folder / name).write_text(page(found, pictures, films, root), encoding="utf-8")
