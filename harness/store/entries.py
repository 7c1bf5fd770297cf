"""Payloads under keys, each with its checksum.

A key is a digest of everything that decides a result. An entry is a file: a line with form, key and
the SHA-256 of the rest, a line with a label as JSON (what it is, of which cases), and the payload.
A damaged one is dropped, never used. Plain files: a database would lock on network file systems,
and a pickle would run what others put there.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import os
import platform
import secrets
import shutil
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

from harness.engines import process
from harness.files import OTHERS, lock_file, make_private, writable_by_others

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
    digest = hashlib.sha256()
    for path in sorted(files):
        content = hashlib.sha256(path.read_bytes()).hexdigest()
        digest.update(f"{content} {path.relative_to(root).as_posix()}\n".encode())
    return digest.hexdigest()


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
    found: dict[str, str | None] = dict.fromkeys(packages)
    for package in packages:
        with contextlib.suppress(metadata.PackageNotFoundError):
            found[package] = metadata.version(package)
    return found


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return platform.processor()
    return next((line for line in lines if line.startswith("model name")), platform.processor())


FORM = b"dem-harness entry 2"
LIMIT = 2 * 1024**3  # [bytes] of entries and environments; beyond it the least recently used go
ASIDE, PRUNING, ENTRIES = ".aside", ".pruning", "[0-9a-f][0-9a-f]/" + "[0-9a-f]" * 64
ABANDONED_SECONDS = 3600.0  # an entry is written in a fraction of a second
MOST_LABEL = 4096  # bytes
Tell = Callable[[str], None]


def tell_stderr(note: str) -> None:
    """Print a note on stderr."""
    print(f"dem-harness: {note}", file=sys.stderr)


class Entries:
    """A folder of entries, safe to use from several threads and processes.

    ``limit`` [bytes] bounds its size, give or take a tenth, with that of the environments of
    releases in it, of which those in use stay. Where the folder fails later, one note is printed
    and nothing more is written: a cache must not end a run. Raise OSError when the folder cannot be
    made or written, belongs to another user, or may be written by all.
    """

    def __init__(self, folder: Path, limit: int = LIMIT, tell: Tell = tell_stderr) -> None:
        self.folder = folder
        self._limit = limit
        self._tell = tell
        self._lock = threading.Lock()
        self._unpruned = limit  # the first entry written looks through the folder
        self._broken = False
        make_private(folder / ASIDE)
        for each in (folder, folder / ASIDE):
            # a group may share one, and root of a container use its owner's: it is data, never run
            if os.geteuid() and (why := writable_by_others(each, OTHERS)):
                raise PermissionError(f"{each}: {why}; make it yours alone, or name another place")
        with tempfile.TemporaryFile(dir=folder / ASIDE):
            pass

    def get(self, key: str) -> bytes | None:
        """Return the payload of a key, or None; drop an entry that is damaged, with a note."""
        path = self._path(key)
        try:
            data = path.read_bytes()
        except FileNotFoundError:
            return None
        except OSError as error:
            self.drop(key, error.strerror or str(error))
            return None
        payload, damage = _checked(data, key)
        if damage:
            self.drop(key, damage)
            return None
        with contextlib.suppress(OSError):
            os.utime(path)
        return payload

    def put(self, key: str, payload: bytes, sort: str = "other", cases: Sequence[str] = ()) -> None:
        """Keep a payload under a key: written aside, then renamed.

        It is not forced onto the disk, which costs several milliseconds: what the system holds
        survives the death of a process, and what a power cut tears does not match its checksum.
        """
        if self._broken:
            return
        body = b"\n".join((json.dumps([sort, *cases]).encode(), payload))
        try:
            self._write(self._path(key), b"\n".join((_head(key, body), body)))
            self._prune_sometimes(len(body))
        except OSError as error:
            self._broken = True
            why = error.strerror or error
            self._tell(f"cache {self.folder} cannot be written ({why}); nothing more is kept")

    def drop(self, key: str, why: str) -> None:
        """Remove the entry of a key, whatever it is, and say why."""
        path = self._path(key)
        self._tell(f"cache entry {path} is damaged ({why}): dropped, computed again")
        with contextlib.suppress(OSError):
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path)
            else:
                path.unlink()

    def _path(self, key: str) -> Path:
        return self.folder / key[:2] / key

    def _write(self, path: Path, data: bytes) -> None:
        # plain names and calls: paths, and a name by tempfile, cost as much as the write
        aside, place = f"{self.folder}/{ASIDE}/{secrets.token_hex(16)}", str(path)
        try:
            with open(os.open(aside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as stream:  # noqa: PTH123
                stream.write(data)
            try:
                os.replace(aside, place)  # noqa: PTH105
            except FileNotFoundError:
                path.parent.mkdir(mode=0o700, exist_ok=True)
                os.replace(aside, place)  # noqa: PTH105
        except BaseException:
            Path(aside).unlink(missing_ok=True)
            raise

    def _prune_sometimes(self, written: int) -> None:
        with self._lock:
            self._unpruned += written
            if self._unpruned < self._limit / 10:
                return
            self._unpruned = 0
        with lock_file(self.folder / PRUNING) as lock, contextlib.suppress(BlockingIOError):
            # who prunes measures anew: of several at a time one does, and the others go on
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self._prune()

    def _prune(self) -> None:
        """Drop what was not asked for the longest until nine tenths of the limit are left."""
        self._sweep()
        candidates: list[tuple[float, int, Path, Callable[[Path], None]]] = []
        for path in self.folder.glob("??/*"):
            with contextlib.suppress(OSError):
                state = path.stat()
                candidates.append((state.st_mtime, state.st_size, path, Path.unlink))
        for home in (self.folder / process.FOLDER).glob("*"):
            with contextlib.suppress(OSError):
                candidates.append((*process.last_use_and_size(home), home, process.drop))
        excess = sum(size for _, size, *_ in candidates) - self._limit * 9 // 10
        if excess <= self._limit // 10:
            return
        for _, size, path, drop in sorted(candidates, key=lambda candidate: candidate[:3]):
            if excess <= 0:
                return
            with contextlib.suppress(OSError):
                drop(path)
                excess -= size

    def _sweep(self) -> None:
        oldest = time.time() - ABANDONED_SECONDS
        for path in (self.folder / ASIDE).iterdir():
            with contextlib.suppress(OSError):
                if path.stat().st_mtime < oldest:
                    path.unlink()


def label_of(path: Path) -> tuple[str, tuple[str, ...]]:
    """Return what an entry is and of which cases, by its label alone."""
    with contextlib.suppress(OSError, ValueError), path.open("rb") as file:
        if file.readline(MOST_LABEL).startswith(FORM):
            sort, *cases = json.loads(file.readline(MOST_LABEL))
            return sort, tuple(cases)
    return "other", ()


def _head(key: str, body: bytes) -> bytes:
    return b" ".join((FORM, key.encode(), hashlib.sha256(body).hexdigest().encode()))


def _checked(data: bytes, key: str) -> tuple[bytes, str]:
    """Return the payload of a file's content, and what is wrong with it, empty if nothing."""
    head, _, body = data.partition(b"\n")
    if head == _head(key, body) and b"\n" in body:
        return body.partition(b"\n")[2], ""
    if not head.startswith(FORM):
        return b"", "not an entry, or cut short"
    if key.encode() not in head:
        return b"", "that of another key"
    return b"", "its checksum does not match"
