"""The cache: outputs of engines and whole verifications under keys, read in place of a run.

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
import math
import os
import platform
import random
import secrets
import sys
import tempfile
import threading
import zipfile
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, partial
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.engines import process
from harness.engines.base import Engine, Job
from harness.engines.output import Output, Provenance
from harness.engines.registry import DEFAULT, open_engine
from harness.errors import EngineError
from harness.files import (
    KERNELS,
    OTHERS,
    cache_place,
    make_private,
    whole_folder,
    writable_by_others,
)

PACKAGE = Path(__file__).resolve().parent.parent
SOURCES = ("engines", "model", "solvers")  # folders that turn a job into an output
FORM = b"dem-harness entry 2"
LIMIT = 2 * 1024**3  # [bytes] of entries and environments; the least recently used go beyond it
TAG = "CACHEDIR.TAG"  # marks a folder as a cache (bford.info/cachedir): backups pass it over
SIGNATURE = "Signature: 8a477f597d28d172789f06886806bc55\n# results of dem-harness\n"
ENTRIES = "[0-9a-f][0-9a-f]/" + "[0-9a-f]" * 64 + "*"
KERNEL_SUFFIXES = (".nbi", ".nbc")  # of numba's index and data files
PLAIN_FIELDS = ("log", "seconds", "title")  # fields of an output with a JSON form
DAMAGE = (ValueError, KeyError, TypeError, zlib.error, zipfile.BadZipFile)  # of other bytes

EngineChoice = Engine | str | None  # an open engine, the name of one, or None for the default
Outcomes = Iterator[tuple[int, Output | EngineError]]  # the place of each job and its outcome
Remote = Callable[[Engine, str, Mapping[str, Any], Sequence[Job]], Outcomes]


# ---- engines whose outputs are kept


@contextlib.contextmanager
def opened(
    engine: EngineChoice = None,
    *,
    fresh: bool = False,
    options: Mapping[str, Any] | None = None,
    entries: Entries | None = None,
    remote: Remote | None = None,
) -> Iterator[Engine]:
    """Yield an open engine as it is; open the engine of a name, keep its runs, and close it.

    With ``fresh`` every job is run; ``options`` are those of
    :func:`harness.engines.registry.open_engine`. ``entries`` are the cache, the default one unless
    given. ``remote`` makes the runs elsewhere, of the engine, its name, its options and jobs.
    """
    if isinstance(engine, Engine):
        yield engine
        return
    name, entries = engine or DEFAULT, entries or default_entries()
    with open_engine(name, options=options) as bare:
        run = remote and partial(remote, bare, name, options or {})
        yield CachedEngine(bare, entries, fresh=fresh, outcomes=run)


def default_entries() -> Entries | None:
    """Return the cache of this user; None where it cannot be written."""
    with contextlib.suppress(OSError):
        return Entries(cache_place().path)
    return None


class CachedEngine(Engine):
    """An engine whose outputs are stored as soon as they are there; errors are not.

    So an interrupted command goes on where it stopped. All but runs is that of the wrapped engine,
    whose ``outcomes`` may be made elsewhere. Without ``entries`` nothing is kept; with ``fresh``
    nothing is read. ``ran`` and ``read`` count jobs. The wall time in an output that was read is
    that of its run.
    """

    def __init__(
        self,
        engine: Engine,
        entries: Entries | None,
        *,
        fresh: bool = False,
        outcomes: Callable[[Sequence[Job]], Outcomes] | None = None,
    ) -> None:
        self.ran = self.read = 0
        self._engine, self._entries, self._fresh = engine, entries, fresh
        self._run, self._lock = outcomes or engine.outcomes, threading.Lock()

    def __getattribute__(self, attribute: str) -> Any:
        """Return an attribute of the wrapped engine, except private ones and those of runs."""
        get = object.__getattribute__
        if attribute.startswith("_") or attribute in ("run", "outcomes", "ran", "read"):
            return get(self, attribute)
        return getattr(get(self, "_engine"), attribute)

    def identify(self) -> Provenance:
        """Return the provenance of the wrapped engine."""
        return self._engine.identify()

    def run(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Return the outcomes of jobs, in order."""
        outcomes = dict(self.outcomes(jobs))
        return [outcomes[place] for place in range(len(jobs))]

    def outcomes(self, jobs: Sequence[Job]) -> Outcomes:
        """Yield stored outputs, then those of the other jobs as the engine makes them."""
        self._engine.check(jobs)
        facts = self._engine.fingerprint() if self._entries else None
        keys = [] if facts is None else [run_key(self._engine, job, facts) for job in jobs]
        missing = set(range(len(jobs)))
        for place, key in enumerate([] if self._fresh else keys):
            if self._entries and (output := self._entries.get(key, unpack_output)) is not None:
                missing.discard(place)
                with self._lock:
                    self.read += 1
                yield place, output
        places = sorted(missing)
        for index, outcome in self._run([jobs[place] for place in places]) if places else ():
            place = places[index]
            with self._lock:
                self.ran += 1
            if self._entries and keys and isinstance(outcome, Output):
                cases = (jobs[place].template.name,)
                self._entries.put(keys[place], pack_output(outcome), "run", cases)
            yield place, outcome


def run_key(engine: Engine, job: Job, fingerprint: Mapping[str, Any]) -> str:
    """Return the key of a run: job, engine, platform, and the source that reads it."""
    template = job.template
    scene = None if engine.has_template(template) else job.scene  # a script has its values
    return key_of(
        {
            "template": [template.package, template.name],
            "variant": job.variant,
            "defaults": dict(template.variants.get(job.variant or template.main, {})),
            "values": dict(job.values),
            "scene": scene and scene.model_dump(mode="json"),
            "sampled": job.sampled,
            "script": engine.script_digest(job),
            "engine": dict(fingerprint),
            "machine": machine(),
            "packages": versions("numpy", "pandas"),
            "source": source_digest(*SOURCES),
        }
    )


def pack_output(output: Output) -> bytes:
    """Return an output as bytes: the size of a compressed JSON text, the text, the arrays."""
    arrays = [(table, *item) for table, cells in output.tables.items() for item in cells.items()]
    facts = {
        **{name: getattr(output, name) for name in PLAIN_FIELDS},
        "results": output.results,
        "provenance": vars(output.provenance),
        "tables": list(output.tables),
        "arrays": [(table, name, a.dtype.str, a.shape) for table, name, a in arrays],
    }
    text = zlib.compress(json.dumps(facts).encode(), 1)
    return b"".join([b"%d\n" % len(text), text, *(a.tobytes() for *_, a in arrays)])


def unpack_output(data: bytes) -> Output:
    """Return the output from its bytes; raise one of :data:`DAMAGE` for others."""
    size, _, rest = data.partition(b"\n")
    place = int(size)
    facts: dict[str, Any] = json.loads(zlib.decompress(rest[:place]))
    tables: dict[str, dict[str, NDArray[Any]]] = {name: {} for name in facts["tables"]}
    for table, name, kind, shape in facts["arrays"]:
        array = np.frombuffer(rest, kind, math.prod(shape), place)  # which refuses objects
        tables[table][name] = array.reshape(shape).copy()
        place += array.nbytes
    origin = facts["provenance"]
    return Output(
        results=tuple((name, text) for name, text in facts["results"]),
        provenance=Provenance(**{**origin, "packages": tuple(origin["packages"])}),
        tables=tables,
        **{name: facts[name] for name in PLAIN_FIELDS},
    )


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

    def unpack(payload: bytes) -> dict[str, Any]:
        text, _, data = payload.partition(b"\n")
        record: dict[str, Any] = json.loads(text)
        with zipfile.ZipFile(io.BytesIO(data)) as archive, whole_folder(folder) as aside:
            archive.extractall(aside)  # which strips ".." and roots from names
        return record

    record: dict[str, Any] | None = entries.get(key, unpack)
    return record


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
    fails later, one note is printed and nothing more is written: a cache must not end a run. Raise
    OSError when the folder cannot be written, belongs to another user, or all may write it.
    """

    def __init__(self, folder: Path, limit: int = LIMIT) -> None:
        self.folder, self._limit = folder, limit
        self._lock = threading.Lock()
        # [bytes] since the last look at the size, by this process or another: which one, is chance
        self._written = random.random() * limit / 10
        self._broken = False
        make_private(folder)
        # a group may share a cache, and root of a container use its owner's: it is data, never run
        if os.geteuid() and (reason := writable_by_others(folder, OTHERS)):
            raise PermissionError(f"{folder}: {reason}; make it yours alone, or name another place")
        with tempfile.TemporaryFile(dir=folder):
            (folder / TAG).write_text(SIGNATURE)

    def get(self, key: str, read: Callable[[bytes], Any] = bytes) -> Any:
        """Return what ``read`` makes of the payload of a key, None where there is none.

        An entry that is damaged, or of which it raises one of :data:`DAMAGE`, is dropped with a
        note.
        """
        path = self._path(key)
        try:
            head, _, body = path.read_bytes().partition(b"\n")
        except OSError:
            return None
        try:
            if head != _head(key, body):
                raise ValueError("its checksum does not match")
            content = read(body.partition(b"\n")[2])
        except DAMAGE as error:
            _note(f"cache entry {path} is damaged ({error}): dropped, computed again")
            with contextlib.suppress(OSError):
                path.unlink()
            return None
        with contextlib.suppress(OSError):
            os.utime(path)
        return content

    def put(self, key: str, payload: bytes, sort: str = "other", cases: Sequence[str] = ()) -> None:
        """Store a payload under a key, with a label: written under another name, then renamed.

        It is not forced onto the disk, which costs milliseconds: an entry torn by a power cut does
        not match its checksum.
        """
        if self._broken:
            return
        body = b"\n".join((json.dumps([sort, *cases]).encode(), payload))
        path = self._path(key)
        part = path.with_name(f"{key}.{secrets.token_hex(8)}")
        try:
            path.parent.mkdir(mode=0o700, exist_ok=True)
            try:
                with open(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:  # noqa: PTH123
                    file.write(b"\n".join((_head(key, body), body)))
                part.replace(path)
            except BaseException:
                part.unlink(missing_ok=True)
                raise
            self._prune_sometimes(len(body))
        except OSError as error:
            self._broken = True
            reason = error.strerror or error
            _note(f"cache {self.folder} cannot be written ({reason}); nothing more is kept")

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


def _note(text: str) -> None:
    print(f"dem-harness: {text}", file=sys.stderr)


# ---- contents of the folder


@dataclass(frozen=True)
class Item:
    """An entry, a compiled kernel or an environment: last use [s since 1970] and size [bytes]."""

    path: Path
    used: float
    size: int

    @cached_property
    def label(self) -> tuple[str, ...]:
        """Return its sort (run, verification, environment, kernel or other), and its cases."""
        if self.path.is_dir():
            return ("environment",)
        if self.path.suffix in KERNEL_SUFFIXES:
            return ("kernel",)
        with contextlib.suppress(OSError, ValueError), self.path.open("rb") as file:
            if file.readline().startswith(FORM):
                return tuple(json.loads(file.readline()))
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
    paths = [path for suffix in KERNEL_SUFFIXES for path in (folder / KERNELS).rglob(f"*{suffix}")]
    if (folder / TAG).is_file():
        paths += [*folder.glob(ENTRIES), *(folder / process.FOLDER).glob("*/")]
    items = []
    for path in paths:
        with contextlib.suppress(OSError):  # removed by another process, or not complete
            is_home = path.is_dir()
            used = (path / process.COMPLETE if is_home else path).stat().st_mtime
            files = path.rglob("*") if is_home else [path]
            size = sum(file.lstat().st_size for file in files if not file.is_dir())
            items.append(Item(path, used, size))
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
