"""Read two runs and hold them side by side."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from harness.comparison.results import SCHEMA, Results, read_published
from harness.comparison.run_diff import RunDiff, diff_runs
from harness.errors import RequestError
from harness.store.bounded_text import bounded_text

FILE = "results.json"


def diff(before: str | Path, after: str | Path) -> RunDiff:
    """Return what is not the same in two runs, each a report's folder or its results.json.

    Raise RequestError as :func:`read_results` does.
    """
    return diff_runs(read_results(before), read_results(after))


def read_results(run: str | Path) -> Results:
    """Return the results of a run, from its folder or its results.json.

    Raise RequestError, naming the file, for what is not there, is no JSON or no
    run, or is of a newer form than this version reads.
    """
    path = Path(run)
    path = path / FILE if path.is_dir() else path
    record = _json(path)
    version = record.get("schema", 1) if isinstance(record, dict) else None
    if isinstance(version, int) and version > SCHEMA:
        raise RequestError(
            f"{path}: is of schema {version}, this dem-harness reads up to {SCHEMA}; "
            "take a newer one"
        )
    try:
        return read_published(record)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(map(str, first["loc"])) or "the whole"
        message = str(first["msg"])[:1].lower() + str(first["msg"])[1:]
        raise RequestError(f"{path}: is not a run of dem-harness ({where}: {message})") from None


def _json(path: Path) -> Any:
    if path.parent.is_dir() and not path.exists() and path.name == FILE:
        raise RequestError(f"{path.parent}: is not a run: it holds no {FILE}")
    try:
        return json.loads(bounded_text(path))
    except OSError as error:
        raise RequestError(f"{path}: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise RequestError(f"{path}: is no UTF-8 text, a {FILE} is expected") from None
    except (json.JSONDecodeError, RecursionError) as error:
        raise RequestError(f"{path}: is damaged, no JSON ({error})") from None
