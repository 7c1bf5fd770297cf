"""Read the known defects: ``inputs/known-defects.toml`` of the project, or of the wheel."""

from __future__ import annotations

import tomllib
from pathlib import Path

import harness
from harness.comparison.known_defects import KnownDefect
from harness.errors import RequestError
from harness.store.baseline import KNOWN_DEFECTS, committed_file

DEFECTS = "reports/defects/"
"""Where the scripts lie in a checkout."""


def script_of(defect: KnownDefect) -> str:
    """Return the script that shows a defect, of the project or of the wheel; empty without one."""
    if not defect.script:
        return ""
    package = Path(harness.__file__).parent
    committed = package / "store" / "committed" / "defects"
    below = Path(defect.script).relative_to(DEFECTS) if defect.script.startswith(DEFECTS) else None
    files = [package.parent / defect.script, *([committed / below] if below else [])]
    for file in files:
        if file.is_file():
            return file.read_text(encoding="utf-8")
    return ""


def known_defects(path: Path | None = None) -> tuple[KnownDefect, ...]:
    """Return the defects of a file, the committed one unless given; none where there is no file.

    Each is a table ``[defect.NAME]`` with the fields of
    :class:`~harness.comparison.known_defects.KnownDefect`. Raise RequestError, naming file and
    defect, for anything else.
    """
    path = path or committed_file(KNOWN_DEFECTS)
    if path is None:
        return ()
    try:
        record = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise RequestError(f"known defects {path}: cannot be read: {reason}") from None
    tables = record.pop("defect", {})
    if record or not all(isinstance(table, dict) for table in tables.values()):
        raise RequestError(f"known defects {path}: holds tables [defect.NAME] and nothing else")
    defects = []
    for name, table in tables.items():
        try:
            defects.append(KnownDefect(**{**table, "name": name}))
        except RequestError as error:
            raise RequestError(f"known defects {path}, [defect.{name}]: {error}") from None
    return tuple(defects)


def with_further(path: Path | None) -> tuple[KnownDefect, ...]:
    """Return the committed defects and those of a file; RequestError for a name of both."""
    committed = known_defects()
    if path is None:
        return committed
    further, names = known_defects(path), {defect.name for defect in committed}
    for defect in further:
        if defect.name in names:
            raise RequestError(
                f"--known-defects {path}, [defect.{defect.name}]: is known already; "
                "take another name"
            )
    return (*committed, *further)
