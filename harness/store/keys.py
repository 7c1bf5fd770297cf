"""Make the keys of the cache: a digest of everything that decides a result."""

from __future__ import annotations

import hashlib
import json
import platform
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
"""The import package, whose source decides results as much as any parameter."""


def key_of(facts: Mapping[str, Any]) -> str:
    """Return the SHA-256 of the facts in one canonical JSON text, in hexadecimal.

    Numbers are written so that they read back as the same double. Raise
    TypeError for what JSON cannot state: a key must not depend on a ``repr``.
    """
    text = json.dumps(facts, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    return hashlib.sha256(text.encode()).hexdigest()


def digest_of_files(files: Sequence[Path], root: Path) -> str:
    """Return one SHA-256 over the names below ``root`` and the contents of files."""
    whole = hashlib.sha256()
    for path in sorted(files):
        content = hashlib.sha256(path.read_bytes()).hexdigest()
        whole.update(f"{content} {path.relative_to(root).as_posix()}\n".encode())
    return whole.hexdigest()


def digest_of_tree(root: Path) -> str:
    """Return one SHA-256 over all files below a folder; that of no file where there is none."""
    files = [path for path in root.rglob("*") if path.is_file() and "__pycache__" not in path.parts]
    return digest_of_files(files, root)


@cache
def source_digest(*rooms: str) -> str:
    """Return the digest of the harness's own source, or of some of its rooms.

    A developer who edits the code must not be given results of the code before.
    """
    if not rooms:
        return digest_of_tree(ROOT)
    return key_of({room: digest_of_tree(ROOT / room) for room in rooms})


@cache
def machine() -> dict[str, str]:
    """Return what of the platform can change a number in its last digits."""
    return {
        "system": platform.system(),
        "machine": platform.machine(),
        "processor": _processor(),
        "libc": "-".join(platform.libc_ver()),
        "python": sys.version,
    }


@cache
def versions(*packages: str) -> dict[str, str | None]:
    """Return the installed version of each package, None for one that is not here."""
    return {package: _version(package) for package in packages}


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def _processor() -> str:
    """Return the model: linear algebra libraries choose their kernels by it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return platform.processor()
    return next((line for line in lines if line.startswith("model name")), platform.processor())
