"""The runs of a sweep on this machine: in the engine's own workers, or in a solver of the case."""

from __future__ import annotations

import inspect
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

from harness import __version__
from harness.cases.contract import Case, Measured
from harness.engines.contract import Engine, Job, Output
from harness.engines.registry import engine_names
from harness.errors import EngineError, EngineOutputError, HarnessError, RequestError
from harness.observables.provenance import Provenance
from harness.parameters.base import Parameters
from harness.store.cached_engine import CachedEngine
from harness.store.entries import Entries
from harness.store.keys import ROOT, digest_of_tree, key_of, machine, source_digest, versions
from harness.workflows.opened import opened
from harness.workflows.verification_run import Open

CHUNK = 512
"""Runs whose jobs are held at a time."""

Ran = Measured | HarnessError
"""What became of a run: RequestError where the engine cannot state it."""


@dataclass(frozen=True)
class Work:
    """Runs of one case in one engine, or one solver of the case."""

    case: Case[Any]
    engine: str
    parameters: Sequence[Parameters]

    @property
    def solves(self) -> bool:
        """Return whether it is a solver that runs them."""
        return self.engine in self.case.solvers and self.engine not in engine_names()


class Executor(Protocol):
    """Runs the work of a sweep somewhere."""

    def __call__(self, work: Work) -> Iterator[tuple[int, Ran]]:
        """Yield the place and the outcome of each run as soon as it is known, in any order."""


@runtime_checkable
class CheckedExecutor(Protocol):
    """An executor that can say beforehand what it cannot run."""

    def check(self, work: Work) -> None:
        """Raise RequestError for work that cannot be run; nothing is begun."""


@dataclass(frozen=True)
class Local:
    """Runs work here; ``entries`` keep what solvers found, nothing for None."""

    open_one: Open = opened
    entries: Entries | None = None
    fresh: bool = False

    def __call__(self, work: Work) -> Iterator[tuple[int, Ran]]:
        """Yield the outcomes; raise EngineError where the engine itself cannot be opened."""
        if work.solves:
            for place, parameters in enumerate(work.parameters):
                yield place, self._solved(work, parameters)
            return
        with self.open_one(work.engine) as engine:
            for first in range(0, len(work.parameters), CHUNK):
                yield from _in_engine(work, engine, range(first, first + CHUNK))

    def known(self, work: Work) -> Iterator[tuple[int, Ran]]:
        """Yield what is kept and what is refused; nothing is run."""
        if work.solves:
            for place, parameters in enumerate(work.parameters):
                found = self._kept(work, self._key(work, parameters))
                if found is not None:
                    yield place, found
            return
        with self.open_one(work.engine) as engine:
            jobs, refused = jobs_of(work, engine, range(len(work.parameters)))
            yield from refused.items()
            kept = engine.kept([job for job, _ in jobs]) if isinstance(engine, CachedEngine) else {}
            for index, output in kept.items():
                for place in jobs[index][1]:
                    yield place, read(work, engine, place, output)

    def _solved(self, work: Work, parameters: Parameters) -> Ran:
        """Return what a solver finds, or found before."""
        key = self._key(work, parameters)
        kept = self._kept(work, key)
        if kept is not None:
            return kept
        found = solved(work.case, parameters, work.engine)
        if isinstance(found, Measured) and self.entries is not None:
            self.entries.put(key, json.dumps(dict(found.values)).encode())
        return found

    def _key(self, work: Work, parameters: Parameters) -> str:
        """Return the key of what a solver finds: all of the source decides it."""
        return key_of(
            {
                "case": work.case.name,
                "solver": work.engine,
                "parameters": parameters.model_dump(mode="json"),
                "machine": machine(),
                "packages": versions("numba", "numpy", "scipy"),
                "source": [source_digest(), _beyond(work.case)],
            }
        )

    def _kept(self, work: Work, key: str) -> Measured | None:
        kept = None if self.fresh or self.entries is None else self.entries.get(key)
        if kept is None:
            return None
        return Measured(json.loads(kept), version_of_solver(work.engine), ranks=1)


def solved(case: Case[Any], parameters: Parameters, solver: str) -> Ran:
    """Return what a solver of a case finds, or the error that it raises."""
    try:
        found = case.solve(parameters, solver)
    except HarnessError as error:
        return error
    return Measured(found.values, version_of_solver(solver), found.seconds, 1)


def version_of_solver(solver: str) -> Provenance:
    """Return who a solver of this package is."""
    return Provenance(solver, f"dem-harness {__version__}", how="solver")


def jobs_of(
    work: Work, engine: Engine, places: Sequence[int]
) -> tuple[list[tuple[Job, list[int]]], dict[int, Ran]]:
    """Return the jobs that an engine can run, each once with its places, and why not the others."""
    jobs: dict[tuple[Any, ...], tuple[Job, list[int]]] = {}
    refused: dict[int, Ran] = {}
    for place in places:
        try:
            job = work.case.job(work.parameters[place])
            reason = engine.refuses(job)
        except HarnessError as error:
            refused[place] = error
            continue
        if reason:
            refused[place] = RequestError(reason)
        else:
            same = (job.variant, job.sampled, *sorted(job.values.items()))
            jobs.setdefault(same, (job, []))[1].append(place)
    return list(jobs.values()), refused


def read(work: Work, engine: Engine, place: int, output: Output | EngineError) -> Ran:
    """Return the quantities of an output, or the error that it is or raises."""
    if isinstance(output, EngineError):
        return output
    try:
        return work.case.measured(work.parameters[place], output, engine.traits)
    except HarnessError as error:
        return error
    except Exception as error:  # a case that cannot read one output must not cost the others
        return EngineOutputError(f"{type(error).__name__}: {error}")


def _in_engine(work: Work, engine: Engine, some: range) -> Iterator[tuple[int, Ran]]:
    jobs, refused = jobs_of(work, engine, some[: len(work.parameters) - some.start])
    yield from refused.items()
    for index, output in engine.outcomes([job for job, _ in jobs]) if jobs else ():
        for place in jobs[index][1]:
            yield place, read(work, engine, place, output)


def _beyond(case: Case[Any]) -> str:
    """Return the digest of a case's own folder where it belongs to another package."""
    folder = Path(inspect.getfile(type(case))).resolve().parent
    return "" if folder.is_relative_to(ROOT) else digest_of_tree(folder)
