"""Engines whose outputs are kept: read from the cache in place of a run, exact to the last bit."""

from __future__ import annotations

import contextlib
import json
import math
import threading
import zlib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from harness.engines.base import Engine, Job
from harness.engines.output import Output, Provenance
from harness.engines.registry import DEFAULT, open_engine
from harness.errors import EngineError
from harness.files import cache_place
from harness.store.entries import Entries, key_of, machine, source_digest, versions

EngineChoice = Engine | str | None  # an open engine, the name of one, or None for the default
SOURCES = ("engines", "model", "solvers")  # folders that turn a job into an output
PLAIN_FIELDS = ("log", "seconds", "title")  # fields of an output with a JSON form
ARRAY_KINDS = "biufcSU"  # numbers and text, as numpy names their kinds
OUTPUT_ERRORS = (ValueError, KeyError, TypeError, zlib.error)  # of bytes that are not an output


@contextlib.contextmanager
def opened(
    engine: EngineChoice = None, *, fresh: bool = False, options: Mapping[str, Any] | None = None
) -> Iterator[Engine]:
    """Yield an open engine as it is; open the engine of a name, keep its runs, and close it.

    With ``fresh`` every job is run; ``options`` are those of
    :func:`harness.engines.registry.open_engine`.
    """
    if not isinstance(engine, str | None):
        yield engine
        return
    with open_engine(engine or DEFAULT, options=options) as bare:
        yield keeping(bare, fresh=fresh)


def keeping(engine: Engine, *, fresh: bool = False) -> Engine:
    """Return an engine that keeps its runs; the engine itself where there is no cache to write."""
    try:
        return CachedEngine(engine, Entries(cache_place().path), fresh=fresh)
    except OSError:
        return engine


class WrappedEngine(Engine):
    """An engine with other ``outcomes``; all else is that of the engine it wraps."""

    overrides: ClassVar[frozenset[str]] = frozenset(("run", "outcomes", "overrides"))

    def __init__(self, engine: Engine) -> None:
        self._engine = engine

    def __getattribute__(self, attribute: str) -> Any:
        """Return an attribute of the wrapped engine, except overrides and private ones."""
        get = object.__getattribute__
        if attribute.startswith("_") or attribute in get(self, "overrides"):
            return get(self, attribute)
        return getattr(get(self, "_engine"), attribute)

    def identify(self) -> Provenance:
        """Return the provenance of the wrapped engine."""
        return self._engine.identify()

    def run(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Return the outcomes of jobs, in order."""
        outcomes = dict(self.outcomes(jobs))
        return [outcomes[place] for place in range(len(jobs))]


class CachedEngine(WrappedEngine):
    """An engine whose outputs are stored as soon as they are there; errors are not.

    So an interrupted command goes on where it stopped. With ``fresh`` nothing is read, and outputs
    are stored all the same. ``ran`` and ``read`` count jobs. The wall time in an output that was
    read is that of its run.
    """

    overrides = WrappedEngine.overrides | {"ran", "read"}

    def __init__(self, engine: Engine, entries: Entries, *, fresh: bool = False) -> None:
        super().__init__(engine)
        self.ran = self.read = 0
        self._entries, self._fresh, self._lock = entries, fresh, threading.Lock()

    def outcomes(self, jobs: Sequence[Job]) -> Iterator[tuple[int, Output | EngineError]]:
        """Yield stored outputs, then those of the other jobs as the engine makes them."""
        self._engine.check(jobs)
        fingerprint = self._engine.fingerprint()
        keys = [] if fingerprint is None else [run_key(self._engine, j, fingerprint) for j in jobs]
        missing = set(range(len(jobs)))
        for place, key in enumerate(() if self._fresh else keys):
            if (output := self._stored(key)) is not None:
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

    def _stored(self, key: str) -> Output | None:
        if (data := self._entries.get(key)) is None:
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
        **{name: getattr(output, name) for name in PLAIN_FIELDS},
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
        if dtype.kind not in ARRAY_KINDS:
            raise ValueError(f"an array of {kind}")
        tables[table][name] = np.ndarray(shape, dtype, rest, place).copy()
        place += math.prod(shape) * dtype.itemsize
    origin = facts["provenance"]
    return Output(
        results=tuple((name, text) for name, text in facts["results"]),
        provenance=Provenance(**{**origin, "packages": tuple(origin["packages"])}),
        tables=tables,
        **{name: facts[name] for name in PLAIN_FIELDS},
    )
