"""Wrap an engine with a cache: outputs of earlier runs are read, only the other jobs are run."""

from __future__ import annotations

import inspect
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from harness.engines.contract import Engine, Job
from harness.engines.output import Output
from harness.errors import EngineError
from harness.observables.provenance import Provenance
from harness.store.entries import Entries
from harness.store.keys import ROOT, digest_of_tree, key_of, machine, source_digest, versions
from harness.store.outputs import DECODE_ERRORS, pack, unpack

SOURCES = ("parameters", "observables", "engines")
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
        self._engine.check(jobs)
        who = self._engine.fingerprint()
        if who is None:
            return self._counted(self._engine.run(jobs))
        keys = [run_key(self._engine, job, who) for job in jobs]
        results: dict[int, Output | EngineError] = {}
        for index, key in enumerate(keys):
            kept = None if self._fresh else self._kept(key)
            if kept is not None:
                results[index] = kept
        missing = [index for index in range(len(jobs)) if index not in results]
        made = self._counted(self._engine.run([jobs[i] for i in missing])) if missing else []
        for index, output in zip(missing, made, strict=True):
            results[index] = output
            if isinstance(output, Output):
                self._entries.put(keys[index], pack(output, jobs[index].template.name))
        return [results[index] for index in range(len(jobs))]

    def kept(self, jobs: Sequence[Job]) -> dict[int, Output]:
        """Return the outputs that are kept, by the places of their jobs; nothing is run."""
        who = self._engine.fingerprint()
        if who is None or self._fresh:
            return {}
        found = ((i, self._kept(run_key(self._engine, j, who))) for i, j in enumerate(jobs))
        return {place: output for place, output in found if output is not None}

    def on_ranks(self, ranks: int) -> Engine:
        """Return the engine on so many MPI ranks, whose outputs are kept as well."""
        return CachedEngine(self._engine.on_ranks(ranks), self._entries, fresh=self._fresh)

    def close(self) -> None:
        """End the engine's processes."""
        self._engine.close()

    def _kept(self, key: str) -> Output | None:
        data = self._entries.get(key)
        if data is None:
            return None
        try:
            output = unpack(data)
        except DECODE_ERRORS as error:
            self._entries.drop(key, f"not a run: {error}")
            return None
        with self._lock:
            self.read += 1
        return output

    def _counted(self, results: list[Output | EngineError]) -> list[Output | EngineError]:
        with self._lock:
            self.ran += len(results)
        return results


_PASSED_ON = frozenset(
    (
        *("name", "title", "states", "refuses", "check", "fingerprint", "fingerprint_of"),
        *("ready", "workers", "resumes", "resumed_at", "srun_mpi"),
        *("twin", "twin_options", "script_digest", "inputs", "logs", "variations"),
    )
)


def run_key(engine: Engine, job: Job, who: Mapping[str, Any]) -> str:
    """Return the key of a run: job, engine ``who``, platform, and the source that reads it."""
    template = job.template
    return key_of(
        {
            "template": [template.package, template.name],
            "variant": job.variant,
            "defaults": dict(template.variants.get(job.variant or template.main, {})),
            "values": dict(job.values),
            "sampled": job.sampled,
            "script": engine.script_digest(job) or _source_of_scene(job),
            "engine": dict(who),
            "machine": machine(),
            "packages": versions("numpy", "pandas"),
            "source": source_digest(*SOURCES),
        }
    )


def _source_of_scene(job: Job) -> str:
    """Return the digest of the source beside the function that makes a job's scene."""
    file = inspect.getsourcefile(job.template.scene) if job.template.scene else None
    folder = Path(file).resolve().parent if file else ROOT
    if folder.is_relative_to(ROOT):
        return source_digest(folder.relative_to(ROOT).parts[0]) if folder != ROOT else ""
    return digest_of_tree(folder)
