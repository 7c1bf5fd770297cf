"""Whole verifications in the cache: the folder of a report and its record, under one key."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any

from harness.files import whole_folder
from harness.store.entries import Entries

RECORD, REPORT = "record.json", "report/"


def keep_verification(entries: Entries, key: str, folder: Path, record: Mapping[str, Any]) -> None:
    """Keep the folder of a report and its record, which is JSON-ready."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr(RECORD, json.dumps(record))
        for path in sorted(path for path in folder.rglob("*") if path.is_file()):
            archive.write(path, REPORT + path.relative_to(folder).as_posix())
    entries.put(key, stream.getvalue(), "verification", record.get("cases", ()))


def kept_verification(entries: Entries, key: str, folder: Path) -> dict[str, Any] | None:
    """Write a kept report into a new folder and return its record; None where none is kept.

    A damaged entry is dropped, also one whose names lead out of the folder.
    """
    payload = entries.get(key)
    if payload is None:
        return None
    try:
        with zipfile.ZipFile(io.BytesIO(payload)) as archive, whole_folder(folder) as aside:
            record: dict[str, Any] = json.loads(archive.read(RECORD))
            aside.mkdir()
            for name in (n for n in archive.namelist() if n.startswith(REPORT)):
                path = aside / _inside(name.removeprefix(REPORT))
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(archive.read(name))
    except (ValueError, KeyError, zipfile.BadZipFile) as error:
        entries.drop(key, f"not a verification: {error}")
        return None
    return record


def _inside(name: str) -> PurePosixPath:
    path = PurePosixPath(name)
    if not path.parts or path.is_absolute() or ".." in path.parts or "\0" in name:
        raise ValueError(f"{name!r} is no name of a file below the report")
    return path
