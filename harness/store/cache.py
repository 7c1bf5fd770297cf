"""The cache of engines' outputs: kept as bytes, read in place of a run, listed and cleared.

An output is kept exactly, arrays as their bytes, the rest as JSON. Besides outputs the cache holds
whole verifications, environments of releases and compiled kernels.
"""

from __future__ import annotations

import contextlib
import json
import math
import threading
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from harness.engines import process
from harness.engines.base import Engine, Job
from harness.engines.output import Output
from harness.engines.provenance import Provenance
from harness.engines.registry import DEFAULT, open_engine
from harness.errors import EngineError
from harness.files import KERNELS, cache_place
from harness.store.entries import (
    ASIDE,
    ENTRIES,
    PRUNING,
    Entries,
    key_of,
    label_of,
    machine,
    source_digest,
    versions,
)

EngineChoice = Engine | str | None
"""An open engine, the name of one, or None for the usual one."""
SOURCES = ("observables", "engines", "model", "solvers")
"""Folders of source that turn a job into an output: edited, every job is run again."""
PLAIN = ("log", "seconds", "title", "ranks")  # fields of an output that JSON has as they are
NUMBERS_AND_TEXT = "biufcSU"  # kinds of arrays that are kept
OUTPUT_ERRORS = (ValueError, KeyError, TypeError, zlib.error)  # of bytes that are no output's


@contextlib.contextmanager
def opened(
    engine: EngineChoice = None, *, fresh: bool = False, options: Mapping[str, Any] | None = None
) -> Iterator[Engine]:
    """Yield an open engine as it is; one of a name is opened, its runs kept, and closed after use.

    ``fresh`` runs again what was kept; ``options`` are those of
    :func:`harness.engines.registry.open_engine`.
    """
    if not isinstance(engine, str | None):
        yield engine
        return
    with open_engine(engine or DEFAULT, options=options) as bare:
        yield keeping(bare, fresh=fresh)


def keeping(engine: Engine, *, fresh: bool = False) -> Engine:
    """Return an open engine that keeps its runs; itself where the cache cannot be written."""
    try:
        return CachedEngine(engine, Entries(cache_place().path), fresh=fresh)
    except OSError:
        return engine


class WrappedEngine(Engine):
    """An engine whose runs go another way; all else is that of the engine it wraps."""

    own: ClassVar[frozenset[str]] = frozenset(("run", "outcomes", "own"))

    def __init__(self, engine: Engine) -> None:
        self._engine = engine

    def __getattribute__(self, attribute: str) -> Any:
        """Return an attribute of the wrapped engine, but for runs and what is private."""
        get = object.__getattribute__
        if attribute.startswith("_") or attribute in get(self, "own"):
            return get(self, attribute)
        return getattr(get(self, "_engine"), attribute)

    def identify(self) -> Provenance:
        """Return who the wrapped engine is."""
        return self._engine.identify()

    def run(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Return the outcomes of jobs, in order."""
        outcomes = dict(self.outcomes(jobs))
        return [outcomes[place] for place in range(len(jobs))]


class CachedEngine(WrappedEngine):
    """An engine whose outputs are kept as soon as they are there; errors are not.

    So an interrupted command goes on where it stopped. ``fresh`` reads nothing and keeps all the
    same. ``ran`` and ``read`` count the runs. The wall time in an output that was read is that of
    the run when it was made.
    """

    own = WrappedEngine.own | {"ran", "read", "on_ranks"}

    def __init__(self, engine: Engine, entries: Entries, *, fresh: bool = False) -> None:
        super().__init__(engine)
        self.ran = self.read = 0
        self._entries, self._fresh, self._lock = entries, fresh, threading.Lock()

    def outcomes(self, jobs: Sequence[Job]) -> Iterator[tuple[int, Output | EngineError]]:
        """Yield kept outputs, then those of the others as the engine makes them."""
        self._engine.check(jobs)
        fingerprint = self._engine.fingerprint()
        keys = [] if fingerprint is None else [run_key(self._engine, j, fingerprint) for j in jobs]
        missing = set(range(len(jobs)))
        for place, key in enumerate(() if self._fresh else keys):
            if (output := self._kept(key)) is not None:
                missing.discard(place)
                yield place, output
        places = sorted(missing)
        for index, outcome in self._engine.outcomes([jobs[i] for i in places]) if places else ():
            place = places[index]
            with self._lock:
                self.ran += 1
            if keys and isinstance(outcome, Output):
                cases = (jobs[place].template.name,)
                self._entries.put(keys[place], pack_output(outcome), "run", cases)
            yield place, outcome

    def on_ranks(self, ranks: int) -> Engine:
        """Return the engine on so many MPI ranks, whose outputs are kept as well."""
        return CachedEngine(self._engine.on_ranks(ranks), self._entries, fresh=self._fresh)

    def _kept(self, key: str) -> Output | None:
        data = self._entries.get(key)
        if data is None:
            return None
        try:
            output = unpack_output(data)
        except OUTPUT_ERRORS as error:
            self._entries.drop(key, f"not a run: {error}")
            return None
        with self._lock:
            self.read += 1
        return output


def run_key(engine: Engine, job: Job, fingerprint: Mapping[str, Any]) -> str:
    """Return the key of a run: job, engine, platform, and the source that reads it."""
    template = job.template
    return key_of(
        {
            "template": [template.package, template.name],
            "variant": job.variant,
            "defaults": dict(template.variants.get(job.variant or template.main, {})),
            "values": dict(job.values),
            "scene": None if job.scene is None else job.scene.model_dump(mode="json"),
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
        **{name: getattr(output, name) for name in PLAIN},
        "results": output.results,
        "provenance": vars(output.provenance),
        "tables": list(output.tables),
        "arrays": [(table, name, a.dtype.str, a.shape) for table, name, a in arrays],
    }
    text = zlib.compress(json.dumps(facts).encode(), 1)
    return b"".join([b"%d\n" % len(text), text, *(a.tobytes() for *_, a in arrays)])


def unpack_output(data: bytes) -> Output:
    """Return the output from its bytes; ``seconds`` are those of the run when it was made.

    Raise one of :data:`OUTPUT_ERRORS` when the bytes are not those of an output.
    """
    size, _, rest = data.partition(b"\n")
    place = int(size)
    facts: dict[str, Any] = json.loads(zlib.decompress(rest[:place]))
    tables: dict[str, dict[str, NDArray[Any]]] = {name: {} for name in facts["tables"]}
    for table, name, kind, shape in facts["arrays"]:
        dtype = np.dtype(kind)
        if dtype.kind not in NUMBERS_AND_TEXT:
            raise ValueError(f"an array of {kind}")
        tables[table][name] = np.ndarray(shape, dtype, rest, place).copy()
        place += math.prod(shape) * dtype.itemsize
    origin = facts["provenance"]
    return Output(
        results=tuple((name, text) for name, text in facts["results"]),
        provenance=Provenance(**{**origin, "packages": tuple(origin["packages"])}),
        tables=tables,
        **{name: facts[name] for name in PLAIN},
    )


@dataclass(frozen=True)
class Kept:
    """One thing in the cache: where it is, of which cases, its size and its last use.

    ``sort`` is "run", "verification", "environment", "kernel" or "other".
    """

    path: Path
    sort: str
    size: int  # [bytes]
    used: float  # [s since 1970]
    cases: tuple[str, ...] = ()

    def clear(self) -> bool:
        """Remove it; return whether it is gone. One that is in use stays."""
        try:
            if self.sort == "environment":
                process.drop(self.path)
                for lock in process.LOCKS:
                    self.path.with_name(self.path.name + lock).unlink(missing_ok=True)
            else:
                self.path.unlink(missing_ok=True)
        except OSError:
            return False
        return True


def contents(folder: Path) -> list[Kept]:
    """Return what the cache in a folder holds; of another folder nothing, whatever is in it."""
    found = [_kept(path, "kernel") for path in sorted((folder / KERNELS).rglob("*.nb[ci]"))]
    if (folder / ASIDE).is_dir():
        found += [_kept(path, *label_of(path)) for path in sorted(folder.glob(ENTRIES))]
        found += [_environment(home) for home in sorted((folder / process.FOLDER).glob("*/"))]
    return [kept for kept in found if kept is not None]


def clear(folder: Path, entries: Iterable[Kept]) -> list[Kept]:
    """Remove things of the cache in a folder, and folders that are empty then; return the gone."""
    gone = [entry for entry in entries if entry.clear()]
    if gone and not contents(folder):
        (folder / PRUNING).unlink(missing_ok=True)
        with contextlib.suppress(OSError):
            (folder / ASIDE).rmdir()
    parents = {p for entry in gone for p in entry.path.parents if p.is_relative_to(folder)}
    for path in sorted(parents, reverse=True):
        with contextlib.suppress(OSError):
            path.rmdir()
    return gone


def sorts(entries: Iterable[Kept]) -> dict[str, dict[str, int]]:
    """Return the number and the size [bytes] of things in the cache, by sort."""
    found: dict[str, dict[str, int]] = {}
    for entry in entries:
        count = found.setdefault(entry.sort, {"entries": 0, "bytes": 0})
        count["entries"] += 1
        count["bytes"] += entry.size
    return found


def _kept(path: Path, sort: str, cases: tuple[str, ...] = ()) -> Kept | None:
    with contextlib.suppress(OSError):  # gone by now
        state = path.stat()
        return Kept(path, sort, state.st_size, state.st_mtime, cases)
    return None


def _environment(home: Path) -> Kept | None:
    with contextlib.suppress(OSError):
        used, size = process.last_use_and_size(home)
        return Kept(home, "environment", size, used)
    return None
