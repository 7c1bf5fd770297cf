"""The runs of a sweep on a cluster: arrays of chunks under SLURM, told as they are over.

A job opens the engine on its node with the same cache, and writes a line for each run into a file
of the sweep's folder, which must be one that the nodes see. Whoever waits reads these lines: a
sweep that is killed leaves its jobs in the queue, and the same command takes them up again.
"""

from __future__ import annotations

import itertools
import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from harness.engines.registry import chosen_options, fingerprint_of
from harness.errors import EngineCrashError
from harness.parameters.base import Parameters
from harness.store.entries import tell_stderr
from harness.store.keys import key_of, source_digest
from harness.workflows.slurm_jobs import Order, last_line, submit, told_of
from harness.workflows.slurm_queue import USUAL, ExecutorOptions, check_slurm, end_of, queued
from harness.workflows.sweep_local import Local, Ran, Work

MOST_JOBS = 1000
"""Of one array: what SLURM takes unless it is told otherwise."""

LOOK_SECONDS = (0.5, 10.0)
"""Between two looks at the queue: at first, and after a while."""

SETTLE_SECONDS = 5.0
"""After the end of a job, for its last lines to be seen on another machine."""

TOLD, SUBMITTED = "told", "submitted.jsonl"


@dataclass(frozen=True)
class Slurm:
    """Runs work under SLURM; ``folder`` is the sweep's, ``opening`` how engines are opened.

    ``local`` looks up what was run before.
    """

    folder: Path
    settings: ExecutorOptions
    local: Local
    opening: Callable[[str], Mapping[str, Any]] = lambda _: {}
    cache: Path | None = None
    tell: Callable[[str], None] = tell_stderr

    def __call__(self, work: Work) -> Iterator[tuple[int, Ran]]:
        """Submit what was not run before, and return an iterator over the outcomes.

        Raise RequestError where SLURM is not here or refuses the jobs.
        """
        check_slurm()
        known = dict(self.local.known(work))
        left = {i: p for i, p in enumerate(work.parameters) if i not in known}
        if not left:
            return iter(known.items())
        opening = {} if work.solves else dict(self.opening(work.engine))
        facts: dict[str, Any] = {"case": work.case.name, "engine": work.engine, "opening": opening}
        if not work.solves:
            facts["who"] = fingerprint_of(work.engine, chosen_options(work.engine, **opening))
        waiting = _Waiting(self._group(facts), self.tell)
        for place, parameters in left.items():
            name = key_of(parameters.model_dump(mode="json"))
            waiting.places.setdefault(name, []).append(place)
        known |= dict(waiting.told(errors=False))
        waiting.attach()
        missing = [name for name in waiting.places if name not in waiting.covered()]
        if missing:
            chosen = {name: left[waiting.places[name][0]] for name in missing}
            waiting.jobs |= self._submitted(work, opening, chosen, waiting.group)
        return itertools.chain(known.items(), waiting.outcomes())

    def _group(self, facts: Mapping[str, Any]) -> Path:
        """Return the folder of jobs that this source and this engine would submit."""
        fresh = time.time_ns() if self.local.fresh else 0
        digest = key_of({**facts, "source": source_digest(), "fresh": fresh})
        group = (self.folder / "slurm" / digest[:16]).absolute()
        (group / TOLD).mkdir(parents=True, exist_ok=True)
        return group

    def _submitted(
        self, work: Work, opening: dict[str, Any], chosen: dict[str, Parameters], group: Path
    ) -> dict[str, list[str]]:
        """Submit the runs in chunks and return the names of those in each job, written down."""
        names, size = list(chosen), self.settings.chunk
        chunks = [names[first : first + size] for first in range(0, len(names), size)]
        stamp = time.time_ns()
        orders = [
            Order(
                work.case.name,
                work.engine,
                opening,
                {name: chosen[name] for name in chunk},
                self.cache.absolute() if self.cache else None,
                self.local.fresh,
                group / TOLD / f"{stamp}-{number}.jsonl",
            )
            for number, chunk in enumerate(chunks)
        ]
        found: dict[str, list[str]] = {}
        for first in range(0, len(orders), MOST_JOBS):
            some = orders[first : first + MOST_JOBS]
            for job, order in zip(submit(some, group, self.settings), some, strict=True):
                found[job] = list(order.parameters)
            with (group / SUBMITTED).open("a", encoding="utf-8") as file:
                for job in list(found)[first:]:
                    file.write(json.dumps({"job": job, "runs": found[job]}) + "\n")
        ids = sorted({job.partition("_")[0] for job in found})
        self.tell(f"{len(found)} jobs are submitted to SLURM ({', '.join(ids)})")
        return found


@dataclass
class _Waiting:
    """The runs that are not told of yet, by name, and the jobs that they are in."""

    group: Path
    tell: Callable[[str], None]
    places: dict[str, list[int]] = field(default_factory=dict)
    jobs: dict[str, list[str]] = field(default_factory=dict)
    read: dict[Path, int] = field(default_factory=dict)
    reasons: set[str] = field(default_factory=set)

    def attach(self) -> None:
        """Take up the jobs of an earlier process that are still in the queue."""
        file = self.group / SUBMITTED
        lines = file.read_text(encoding="utf-8").splitlines() if file.is_file() else []
        live = queued() if lines else {}
        for line in lines:
            told = json.loads(line)
            if live is None or told["job"] in live:
                self.jobs[told["job"]] = told["runs"]

    def covered(self) -> set[str]:
        """Return the names of the runs in jobs."""
        return {name for names in self.jobs.values() for name in names}

    def told(self, *, errors: bool = True) -> Iterator[tuple[int, Ran]]:
        """Yield what the jobs wrote since the last look."""
        for path in sorted((self.group / TOLD).glob("*.jsonl")):
            with path.open("rb") as file:
                file.seek(self.read.get(path, 0))
                for line in file:
                    if not line.endswith(b"\n"):
                        break  # it is being written, or its writer was killed
                    self.read[path] = self.read.get(path, 0) + len(line)
                    told = json.loads(line)
                    if told["run"] in self.places and (errors or "error" not in told):
                        ran = told_of(told)
                        yield from ((place, ran) for place in self.places.pop(told["run"]))

    def outcomes(self) -> Iterator[tuple[int, Ran]]:
        """Yield the outcomes until every run is told of or its job is over."""
        pause = LOOK_SECONDS[0]
        while self.places and self.jobs:
            yield from self.told()
            live = queued()
            self._tell_of_waits(live or {})
            for job in [job for job in self.jobs if live is not None and job not in live]:
                names = [name for name in self.jobs.pop(job) if name in self.places]
                yield from self._ended(job, names)
            if self.jobs and self.places:
                time.sleep(pause)
                pause = min(1.2 * pause, LOOK_SECONDS[1])

    def _tell_of_waits(self, live: Mapping[str, str]) -> None:
        """Tell once why jobs wait that may wait for ever."""
        for job, reason in live.items():
            if job in self.jobs and reason not in (*USUAL, *self.reasons):
                self.reasons.add(reason)
                self.tell(f"SLURM's job {job} waits: {reason}")

    def _ended(self, job: str, names: Sequence[str]) -> Iterator[tuple[int, Ran]]:
        """Yield the last that a job told, and what became of the runs that it did not get to."""
        until = time.monotonic() + SETTLE_SECONDS
        while any(name in self.places for name in names) and time.monotonic() < until:
            yield from self.told()
            time.sleep(LOOK_SECONDS[0])
        lost = [name for name in names if name in self.places]
        if lost:
            why = f"SLURM's job {job} ended before it: {end_of(job)}{last_line(self.group, job)}"
            for name in lost:
                yield from ((place, EngineCrashError(why)) for place in self.places.pop(name))
