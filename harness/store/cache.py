"""The cache of engines' outputs: kept as bytes, read in place of a run, listed and cleared.

An output is kept exactly, arrays as npz, the rest as JSON. Besides outputs the cache holds whole
verifications, environments of releases and compiled kernels.
"""

from __future__ import annotations

import contextlib
import io
import json
import threading
import zipfile
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from harness.engines import process
from harness.engines.contract import Engine, Job
from harness.engines.output import Output
from harness.engines.provenance import Provenance
from harness.engines.registry import DEFAULT, open_engine
from harness.errors import EngineError
from harness.files import KERNELS, cache_place
from harness.store.entries import (
    ASIDE,
    PRUNING,
    Entries,
    key_of,
    machine,
    source_digest,
    versions,
)
from harness.store.verifications import RECORD

EngineChoice = Engine | str | None
"""An open engine, the name of one, or None for the usual one."""


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


FACTS = "facts"
PLAIN = ("log", "seconds", "title", "ranks")
"""Fields of an output that JSON has as they are."""

OUTPUT_ERRORS = (ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, zlib.error)
"""What unpacking raises for bytes that are not those of an output."""


def pack_output(output: Output, template: str = "") -> bytes:
    """Return an output as bytes; ``template`` says what was run, for who looks into the cache."""
    arrays: dict[str, NDArray[Any]] = {}
    tables: dict[str, dict[str, str]] = {}
    for table, columns in output.tables.items():
        alike: dict[tuple[np.dtype[Any], tuple[int, ...]], list[str]] = {}
        for column, values in columns.items():
            alike.setdefault((values.dtype, values.shape), []).append(column)
        tables[table] = dict.fromkeys(columns, "")
        for names in alike.values():  # one array for all: each has its own cost
            place = f"array {len(arrays)}"
            arrays[place] = np.stack([columns[name] for name in names])
            tables[table] |= {name: f"{place}/{row}" for row, name in enumerate(names)}
    plain = {name: getattr(output, name) for name in PLAIN}
    facts = {
        **plain,
        "results": output.results,
        "provenance": vars(output.provenance),
        "tables": tables,
        "template": template,
    }
    stream = io.BytesIO()
    text = np.frombuffer(zlib.compress(json.dumps(facts).encode(), 1), dtype=np.uint8)
    np.savez(stream, allow_pickle=False, **{FACTS: text}, **arrays)
    return stream.getvalue()


def unpack_output(data: bytes) -> Output:
    """Return the output from its bytes; ``seconds`` are those of the run when it was made.

    Raise one of :data:`OUTPUT_ERRORS` when the bytes are not those of an output.
    """
    with np.load(io.BytesIO(data), allow_pickle=False) as stored:
        arrays = {name: stored[name] for name in stored.files}
    facts: dict[str, Any] = json.loads(zlib.decompress(arrays[FACTS].tobytes()))
    origin = facts["provenance"]
    return Output(
        results=tuple((name, text) for name, text in facts["results"]),
        provenance=Provenance(**{**origin, "packages": tuple(origin["packages"])}),
        tables={
            table: {column: _array(arrays, place) for column, place in columns.items()}
            for table, columns in facts["tables"].items()
        },
        **{name: facts[name] for name in PLAIN},
    )


def _array(arrays: Mapping[str, NDArray[Any]], place: str) -> NDArray[Any]:
    name, _, row = place.partition("/")
    return arrays[name][int(row)] if row else arrays[name]


SOURCES = ("observables", "engines", "model", "solvers")
"""Folders of source that turn a job into an output: edited, every job is run again."""


class CachedEngine(Engine):
    """Wraps an engine; each output is kept as soon as it is there, errors are not.

    An interrupted command so goes on where it stopped. ``fresh`` reads nothing
    and keeps all the same. ``ran`` and ``read`` count the runs. The wall time
    in an output that was read is that of the run when it was made.
    """

    def __init__(self, engine: Engine, entries: Entries, *, fresh: bool = False) -> None:
        self.traits = engine.traits
        self.ran = 0
        self.read = 0
        self._engine = engine
        self._entries = entries
        self._fresh = fresh
        self._lock = threading.Lock()

    def __getattribute__(self, attribute: str) -> Any:
        """Return what is the wrapped engine's: its name, and all that needs no run."""
        if attribute in _PASSED_ON:
            return getattr(object.__getattribute__(self, "_engine"), attribute)
        return object.__getattribute__(self, attribute)

    def identify(self) -> Provenance:
        """Return what the engine says of itself."""
        return self._engine.identify()

    def run(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Return the outputs in order, those kept without running them."""
        outcomes = dict(self.outcomes(jobs))
        return [outcomes[place] for place in range(len(jobs))]

    def outcomes(self, jobs: Sequence[Job]) -> Iterator[tuple[int, Output | EngineError]]:
        """Yield kept outputs, then those of the others as the engine makes them."""
        self._engine.check(jobs)
        fingerprint = self._engine.fingerprint()
        keys = [] if fingerprint is None else [run_key(self._engine, j, fingerprint) for j in jobs]
        missing = set(range(len(jobs)))
        for place, output in self._kept(keys):
            missing.discard(place)
            yield place, output
        places = sorted(missing)
        for index, outcome in self._engine.outcomes([jobs[i] for i in places]) if places else ():
            place = places[index]
            with self._lock:
                self.ran += 1
            if keys and isinstance(outcome, Output):
                self._entries.put(keys[place], pack_output(outcome, jobs[place].template.name))
            yield place, outcome

    def on_ranks(self, ranks: int) -> Engine:
        """Return the engine on so many MPI ranks, whose outputs are kept as well."""
        return CachedEngine(self._engine.on_ranks(ranks), self._entries, fresh=self._fresh)

    def close(self) -> None:
        """End the engine's processes."""
        self._engine.close()

    def _kept(self, keys: Iterable[str]) -> Iterator[tuple[int, Output]]:
        """Yield the place and the output of each key that has one, nothing where all run again."""
        for place, key in enumerate(() if self._fresh else keys):
            data = self._entries.get(key)
            if data is None:
                continue
            try:
                output = unpack_output(data)
            except OUTPUT_ERRORS as error:
                self._entries.drop(key, f"not a run: {error}")
                continue
            with self._lock:
                self.read += 1
            yield place, output


_PASSED_ON = frozenset((
    "name", "title", "has_template", "refuses", "check", "fingerprint", "fingerprint_of", "ready",
    "workers", "twin", "twin_options", "script_digest", "script_text", "inputs", "logs",
    "variations", "rules", "scene_of", "has_lj_units",
))  # fmt: skip


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


Sort = Literal["run", "verification", "environment", "kernel", "other"]


@dataclass(frozen=True)
class Kept:
    """One thing in the cache: where it is, of which cases, its size and its last use."""

    path: Path
    sort: Sort
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
    entries = list(_kernels(folder))
    if (folder / ASIDE).is_dir():
        entries += [*_results(folder), *_environments(folder)]
    return entries


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


def _results(folder: Path) -> Iterator[Kept]:
    for path in sorted(folder.glob("[0-9a-f][0-9a-f]/" + "[0-9a-f]" * 64)):
        with contextlib.suppress(OSError):
            state = path.stat()
            sort, cases = _kind_and_cases(path)
            yield Kept(path, sort, state.st_size, state.st_mtime, cases)


def _kind_and_cases(path: Path) -> tuple[Sort, tuple[str, ...]]:
    """Return what an entry is, and its cases; both kinds are zip files behind a head."""
    try:
        with zipfile.ZipFile(path) as archive:
            if RECORD in archive.namelist():
                return "verification", tuple(json.loads(archive.read(RECORD))["cases"])
            with archive.open(f"{FACTS}.npy") as file:
                facts = np.lib.format.read_array(file, allow_pickle=False)
        template = json.loads(zlib.decompress(facts.tobytes())).get("template", "")
    except OUTPUT_ERRORS:
        return "other", ()
    return "run", (template,) if template else ()


def _environments(folder: Path) -> Iterator[Kept]:
    for home in sorted((folder / process.FOLDER).glob("*/")):
        with contextlib.suppress(OSError):
            used, size = process.last_use_and_size(home)
            yield Kept(home, "environment", size, used)


def _kernels(folder: Path) -> Iterator[Kept]:
    for path in sorted((folder / KERNELS).rglob("*.nb[ci]")):
        with contextlib.suppress(OSError):
            state = path.stat()
            yield Kept(path, "kernel", state.st_size, state.st_mtime)
