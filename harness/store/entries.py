"""The cache folder: payloads under keys, each with its checksum; listed, bounded and cleared.

A key is a digest of everything that decides a result. An entry is a file: a line with form, key and
the SHA-256 of the rest, a line with a label as JSON (its sort, its cases), and the payload. A
damaged entry is dropped, never used. Plain files: a database would lock on network file systems,
and a pickle would run what others put there. The folder also has compiled kernels and environments
of releases.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import os
import platform
import secrets
import sys
import tempfile
import threading
import zipfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import metadata
from pathlib import Path
from typing import Any

from harness.engines import process
from harness.files import KERNELS, OTHERS, make_private, whole_folder, writable_by_others

PACKAGE = Path(__file__).resolve().parent.parent
FORM = b"dem-harness entry 2"
LIMIT = 2 * 1024**3  # [bytes] of entries and environments; the least recently used go beyond it
TAG = "CACHEDIR.TAG"  # marks a folder as a cache (bford.info/cachedir): backups pass it over
SIGNATURE = "Signature: 8a477f597d28d172789f06886806bc55\n# results of dem-harness\n"
LONGEST_LABEL = 4096  # bytes
ENTRIES = "[0-9a-f][0-9a-f]/" + "[0-9a-f]" * 64 + "*"
KERNEL_SUFFIXES = (".nbi", ".nbc")  # of numba's index and data files


# ---- keys


def key_of(facts: Mapping[str, Any]) -> str:
    """Return the SHA-256 of the facts in one canonical JSON text, in hexadecimal.

    Raise TypeError for values without a JSON form: a key must not depend on a ``repr``.
    """
    text = json.dumps(facts, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    return hashlib.sha256(text.encode()).hexdigest()


def digest_of_tree(root: Path) -> str:
    """Return one SHA-256 over names and contents of the files below a folder, byte code aside."""
    digest = hashlib.sha256()
    for path in sorted(root.rglob("*")):
        if path.is_file() and "__pycache__" not in path.parts:
            content = hashlib.sha256(path.read_bytes()).hexdigest()
            digest.update(f"{content} {path.relative_to(root).as_posix()}\n".encode())
    return digest.hexdigest()


@cache
def source_digest(*rooms: str) -> str:
    """Return the digest of this package's source, or of some of its folders.

    Results of code that was edited since are thus never returned.
    """
    return key_of({room: digest_of_tree(PACKAGE / room) for room in rooms or ("",)})


@cache
def machine() -> dict[str, str]:
    """Return the properties of the platform that can change the last digits of a result."""
    file = Path("/proc/cpuinfo")
    lines = file.read_text("utf-8", "replace").splitlines() if file.is_file() else []
    models = [line for line in lines if line.startswith("model name")]
    return {
        "system": platform.system(),
        "machine": platform.machine(),
        "processor": models[0] if models else platform.processor(),
        "libc": "-".join(platform.libc_ver()),
        "python": sys.version,
    }


@cache
def versions(*packages: str) -> dict[str, str | None]:
    """Return the installed version of each package, None for a missing one."""
    installed: dict[str, str | None] = dict.fromkeys(packages)
    for package in packages:
        with contextlib.suppress(metadata.PackageNotFoundError):
            installed[package] = metadata.version(package)
    return installed


# ---- entries


class Entries:
    """A folder of entries, safe to use from several threads and processes.

    ``limit`` [bytes] bounds entries and unused environments, give or take a tenth. Where the folder
    fails later, one note goes to ``notify`` and nothing more is written: a cache must not end a
    run. Raise OSError when the folder cannot be written, belongs to another user, or all may write
    it.
    """

    def __init__(
        self, folder: Path, limit: int = LIMIT, notify: Callable[[str], None] | None = None
    ) -> None:
        self.folder = folder
        self._limit, self._notify = limit, notify or _print_note
        self._lock = threading.Lock()
        self._written = limit  # [bytes] since the last look at the size: the first entry looks
        self._broken = False
        make_private(folder)
        # a group may share a cache, and root of a container use its owner's: it is data, never run
        if os.geteuid() and (reason := writable_by_others(folder, OTHERS)):
            raise PermissionError(f"{folder}: {reason}; make it yours alone, or name another place")
        with tempfile.TemporaryFile(dir=folder):
            (folder / TAG).write_text(SIGNATURE)

    def get(self, key: str) -> bytes | None:
        """Return the payload of a key, or None; drop a damaged entry with a note."""
        path = self._path(key)
        try:
            head, _, body = path.read_bytes().partition(b"\n")
        except OSError:
            return None
        if head != _head(key, body):
            self.drop(key, "its checksum does not match")
            return None
        with contextlib.suppress(OSError):
            os.utime(path)
        return body.partition(b"\n")[2]

    def put(self, key: str, payload: bytes, sort: str = "other", cases: Sequence[str] = ()) -> None:
        """Store a payload under a key, with a label: written under another name, then renamed.

        It is not forced onto the disk, which costs milliseconds: an entry torn by a power cut does
        not match its checksum.
        """
        if self._broken:
            return
        body = b"\n".join((json.dumps([sort, *cases]).encode(), payload))
        path = self._path(key)
        part = f"{path}.{secrets.token_hex(8)}"
        try:
            if not path.parent.is_dir():
                path.parent.mkdir(mode=0o700, exist_ok=True)
            try:
                with open(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:  # noqa: PTH123
                    file.write(b"\n".join((_head(key, body), body)))
                os.replace(part, path)  # noqa: PTH105
            except BaseException:
                Path(part).unlink(missing_ok=True)
                raise
            self._prune_sometimes(len(body))
        except OSError as error:
            self._broken = True
            reason = error.strerror or error
            self._notify(f"cache {self.folder} cannot be written ({reason}); nothing more is kept")

    def drop(self, key: str, reason: str) -> None:
        """Remove the entry of a key, with a note."""
        path = self._path(key)
        self._notify(f"cache entry {path} is damaged ({reason}): dropped, computed again")
        with contextlib.suppress(OSError):
            path.unlink()

    def _path(self, key: str) -> Path:
        return self.folder / key[:2] / key

    def _prune_sometimes(self, size: int) -> None:
        with self._lock:
            self._written += size
            if self._written < self._limit / 10:
                return
            self._written = 0
        items = [item for item in contents(self.folder) if item.path.suffix not in KERNEL_SUFFIXES]
        size = sum(item.size for item in items)
        if size <= self._limit:
            return
        for item in sorted(items, key=lambda item: item.used):
            if size > self._limit * 9 // 10 and item.clear():
                size -= item.size


def _head(key: str, body: bytes) -> bytes:
    return b" ".join((FORM, key.encode(), hashlib.sha256(body).hexdigest().encode()))


def _print_note(note: str) -> None:
    print(f"dem-harness: {note}", file=sys.stderr)


# ---- contents of the folder


@dataclass(frozen=True)
class Item:
    """An entry, a compiled kernel or an environment: size [bytes], last use [s since 1970]."""

    path: Path
    size: int
    used: float

    @cached_property
    def label(self) -> tuple[str, ...]:
        """Return its sort (run, verification, environment, kernel or other), and its cases."""
        if self.path.is_dir():
            return ("environment",)
        if self.path.suffix in KERNEL_SUFFIXES:
            return ("kernel",)
        with contextlib.suppress(OSError, ValueError), self.path.open("rb") as file:
            if file.readline(LONGEST_LABEL).startswith(FORM):
                return tuple(json.loads(file.readline(LONGEST_LABEL)))
        return ("other",)

    def clear(self) -> bool:
        """Remove it; return whether it is gone. An environment in use stays."""
        try:
            if self.path.is_dir():
                process.drop(self.path)
                for lock in process.LOCKS:
                    self.path.with_name(self.path.name + lock).unlink(missing_ok=True)
            self.path.unlink(missing_ok=True)
        except OSError:
            return False
        return True


def contents(folder: Path) -> list[Item]:
    """Return the contents of a cache folder; of a folder without the tag only kernels."""
    items = []
    paths = [path for suffix in KERNEL_SUFFIXES for path in (folder / KERNELS).rglob(f"*{suffix}")]
    is_cache = (folder / TAG).is_file()
    for path in [*paths, *(folder.glob(ENTRIES) if is_cache else ())]:
        with contextlib.suppress(OSError):  # removed by another process
            state = path.stat()
            items.append(Item(path, state.st_size, state.st_mtime))
    for home in (folder / process.FOLDER).glob("*/") if is_cache else ():
        with contextlib.suppress(OSError):  # not complete
            used, size = process.last_use_and_size(home)
            items.append(Item(home, size, used))
    return items


def clear(folder: Path, items: Iterable[Item]) -> list[Item]:
    """Remove items of a cache folder, and folders that are empty then; return the removed."""
    removed = [item for item in items if item.clear()]
    parents = {p for item in removed for p in item.path.parents if p.is_relative_to(folder)}
    if not contents(folder):
        (folder / TAG).unlink(missing_ok=True)
    for path in sorted(parents, reverse=True):
        with contextlib.suppress(OSError):
            path.rmdir()
    return removed


def sorts(items: Iterable[Item]) -> dict[str, dict[str, int]]:
    """Return the number and the size [bytes] of items by sort."""
    numbers: dict[str, dict[str, int]] = {}
    for item in items:
        count = numbers.setdefault(item.label[0], {"entries": 0, "bytes": 0})
        count["entries"] += 1
        count["bytes"] += item.size
    return numbers


# ---- whole verifications


def keep_verification(entries: Entries, key: str, folder: Path, record: Mapping[str, Any]) -> None:
    """Store the folder of a report and its record, which is JSON-ready."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for path in sorted(folder.rglob("*")):
            archive.write(path, path.relative_to(folder))
    payload = b"\n".join((json.dumps(record).encode(), stream.getvalue()))
    entries.put(key, payload, "verification", record.get("cases", ()))


def kept_verification(entries: Entries, key: str, folder: Path) -> dict[str, Any] | None:
    """Write a stored report into a new folder and return its record; None where none is stored."""
    if (payload := entries.get(key)) is None:
        return None
    text, _, data = payload.partition(b"\n")
    try:
        record: dict[str, Any] = json.loads(text)
        with zipfile.ZipFile(io.BytesIO(data)) as archive, whole_folder(folder) as aside:
            archive.extractall(aside)  # which strips ".." and roots from names
    except (ValueError, zipfile.BadZipFile) as error:
        entries.drop(key, f"not a verification: {error}")
        return None
    return record
