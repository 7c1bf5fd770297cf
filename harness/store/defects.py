"""The files of known defects: the committed one, and one of a user's own."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import harness
from harness.errors import RequestError
from harness.results.defects import KnownDefect

FILE = "known-defects.toml"
SCRIPTS = "reports/defects/"


def known_defects(further: Path | None = None) -> tuple[KnownDefect, ...]:
    """Return the committed defects, and the defects of a further file.

    Raise RequestError, naming file and defect, for a file that is damaged, and for a name that
    both files have.
    """
    committed = read_defects(_committed(f"inputs/{FILE}", FILE))
    if further is None:
        return committed
    own = read_defects(further)
    if both := sorted({defect.name for defect in committed} & {defect.name for defect in own}):
        raise RequestError(f"known defects {further}: {both[0]!r} is the name of a committed one")
    return (*committed, *own)


def read_defects(file: Path) -> tuple[KnownDefect, ...]:
    """Return the defects of a TOML file with tables ``[defect.NAME]``.

    Raise RequestError, naming file and defect, for anything else.
    """
    label = f"known defects {file}"
    try:
        record: dict[str, Any] = tomllib.loads(file.read_bytes().decode("utf-8"))
    except OSError as error:
        raise RequestError(f"{label}: cannot be read: {error.strerror}") from None
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise RequestError(f"{label}: cannot be read: {error}") from None
    tables = record.pop("defect", {})
    if record or not _are_tables(tables):
        raise RequestError(f"{label}: holds tables [defect.NAME] and nothing else")
    defects = []
    for name, table in tables.items():
        try:
            defects.append(KnownDefect(**{"name": name, **table}))
        except RequestError as error:
            raise RequestError(f"{label}: defect.{name}: {error}") from None
    return tuple(defects)


def defect_script(defect: KnownDefect) -> str:
    """Return the script that shows a defect with the engine alone; empty without one."""
    if not defect.script:
        return ""
    file = _committed(defect.script, f"defects/{defect.script.removeprefix(SCRIPTS)}")
    return file.read_text(encoding="utf-8") if file.is_file() else ""


def _committed(in_checkout: str, in_package: str) -> Path:
    """Return a file of the checkout, or the copy of it that an installed package has."""
    package = Path(harness.__file__).parent
    file = package.parent / in_checkout
    return file if file.is_file() else package / "store" / "committed" / in_package


def _are_tables(tables: Any) -> bool:
    return isinstance(tables, dict) and all(isinstance(table, dict) for table in tables.values())
