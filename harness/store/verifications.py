"""Keep whole verifications, the report's folder with the record, each under one key."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Any

from harness.engines.registry import chosen_options, fingerprint_of
from harness.store.keys import key_of, machine, source_digest, versions

PACKAGES = ("jinja2", "matplotlib", "numba", "numpy", "pandas", "pydantic", "scipy")
RECORD = "record.json"
REPORT = "report/"
DECODE_ERRORS = (ValueError, KeyError, zipfile.BadZipFile)
"""What :func:`unpack` raises for bytes that are not those of a verification."""


def verification_key(
    level: str,
    *,
    cases: Sequence[str],
    engine: str,
    options: Mapping[str, Any] | None = None,
    beside: Mapping[str, Any] | None = None,
    **more: str | None,
) -> str | None:
    """Return the key of a verification, or None where an engine cannot be told by its content.

    ``options`` and ``more`` open the engine; ``beside`` is what else decides the
    verdicts, such as the digest of a baseline. Raise RequestError for a program that is
    not there.
    """
    who = fingerprint_of(engine, chosen_options(engine, options={**(options or {}), **more}))
    if who is None:
        return None
    return key_of(
        {
            "verification": level,
            "cases": list(cases),
            "engine": dict(who),
            "machine": machine(),
            "packages": versions(*PACKAGES),
            "source": source_digest(),
            "beside": dict(beside or {}),
        }
    )


def pack(folder: Path, record: Mapping[str, Any]) -> bytes:
    """Return a report's folder and the record as bytes; NaN in the record stays NaN."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr(RECORD, json.dumps(record))
        for path in sorted(path for path in folder.rglob("*") if path.is_file()):
            archive.write(path, REPORT + path.relative_to(folder).as_posix())
    return stream.getvalue()


def unpack(payload: bytes, folder: Path) -> dict[str, Any]:
    """Write a kept report into a new folder and return the record.

    Raise one of :data:`DECODE_ERRORS` when the bytes are not those of a verification, also where
    a name leads out of the folder; then nothing is written.
    """
    with zipfile.ZipFile(io.BytesIO(payload)) as archive:
        record: dict[str, Any] = json.loads(archive.read(RECORD))
        names = [name for name in archive.namelist() if name.startswith(REPORT)]
        paths = {name: _inside(name.removeprefix(REPORT)) for name in names}
        folder.mkdir()
        for name, path in paths.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_bytes(archive.read(name))
    return record


def _inside(name: str) -> PurePosixPath:
    """Return a name as a path; raise ValueError for one that leads out of its folder."""
    path = PurePosixPath(name)
    if not path.parts or path.is_absolute() or ".." in path.parts or "\0" in name:
        raise ValueError(f"{name!r} is no name of a file below the report")
    return path
