"""Write the reproduction's folder: aside first, then in place of the old one."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from harness.comparison.reproduction import Reproduction
from harness.errors import RequestError
from harness.report.movies import films as draw_films
from harness.report.reproduction.gallery import all_pictures
from harness.report.reproduction.page import html_page
from harness.report.reproduction.text import markdown

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
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder.parent, prefix=f".{folder.name}."):
            pass
    except OSError as error:
        raise RequestError(f"--output {folder}: cannot be written ({error.strerror})") from None


def write(found: Reproduction, folder: Path) -> None:
    """Write report.md, report.html, ledger.csv, figures, movies and dumps into a folder.

    An older reproduction there is replaced as a whole. Raise RequestError as
    :func:`check_folder` does.
    """
    check_folder(folder)
    aside = Path(tempfile.mkdtemp(dir=folder.parent, prefix=f".{folder.name}."))
    old = aside.with_name(f"{aside.name}.old")
    try:
        _fill(found, aside)
        aside.chmod(0o755)
        if folder.is_dir():
            folder.rename(old)
        aside.rename(folder)
    except BaseException:
        shutil.rmtree(aside, ignore_errors=True)
        if old.is_dir() and not folder.exists():
            old.rename(folder)
        raise
    shutil.rmtree(old, ignore_errors=True)


def _fill(found: Reproduction, folder: Path) -> None:
    for name in ("figures", "movies", "dumps"):
        (folder / name).mkdir()
    pictures, films = all_pictures(found), draw_films(found.motions)
    for picture in pictures:
        (folder / "figures" / f"{picture.name}.svg").write_text(picture.svg, encoding="utf-8")
    for film in films:
        (folder / "movies" / f"{film.name}.gif").write_bytes(film.gif)
        (folder / "dumps" / f"{film.name}.dump.gz").write_bytes(film.dump)
    found.ledger.frame().to_csv(folder / LEDGER, index=False)
    (folder / "report.md").write_text(markdown(found, pictures, films), encoding="utf-8")
    (folder / "report.html").write_text(html_page(found, pictures, films), encoding="utf-8")
