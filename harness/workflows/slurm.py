"""The runs of a sweep on a cluster: arrays of chunks under SLURM, read as they end.

Runs are chunked by what they are expected to take, so that a job fits its time with a margin. One
that does not is refused before anything is queued, unless its engine lets it go on from a restart
file: it is submitted again as long as it gets on.

A job opens the engine on its node with the same cache, and writes a line for each run into a file
of the sweep's folder, which must be one that the nodes see. Whoever waits reads these lines: a
sweep that is killed leaves its jobs in the queue, and the same command takes them up again.
"""

from __future__ import annotations

import contextlib
import io
import itertools
import json
import math
import re
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from harness.cases.contract import Measured
from harness.cases.registry import get_case
from harness.engines.border import in_words
from harness.engines.registry import chosen_options, engine_class, fingerprint_of, open_engine
from harness.errors import EngineCrashError, EngineError, EngineUndecidedError, RequestError
from harness.observables.provenance import Provenance
from harness.parameters.base import Parameters
from harness.store.cache import CachedEngine
from harness.store.entries import Entries, key_of, source_digest, tell_stderr
from harness.workflows.case_runs import default_of, parameters_in
from harness.workflows.slurm_queue import (
    USUAL,
    ExecutorOptions,
    check_launcher,
    check_slurm,
    end_of,
    queued,
)
from harness.workflows.sweep_run import Local, Ran, Work, undecided


@dataclass(frozen=True)
class JobOrder:
    """What a job runs: parameters of a case, how the engine is opened, the file of its outcomes."""

    case: str
    engine: str
    opening: Mapping[str, Any]
    parameters: Mapping[str, Parameters]
    cache: Path | None
    fresh: bool
    file: Path
    quantities: tuple[str, ...] = ()


def run_order(order: JobOrder) -> None:
    """Run a job's order on its node, and write the outcome of each run as it ends."""
    entries = Entries(order.cache) if order.cache else None

    def open_one(name: str) -> Any:
        engine = open_engine(name, **order.opening)
        return engine if entries is None else CachedEngine(engine, entries, fresh=order.fresh)

    names = list(order.parameters)
    case = get_case(order.case).measuring(order.quantities)
    work = Work(case, order.engine, list(order.parameters.values()))
    with order.file.open("a", encoding="utf-8") as file:

        def tell(name: str, outcome: Mapping[str, Any]) -> None:
            file.write(json.dumps({"run": name, **outcome}) + "\n")
            file.flush()

        remaining = set(names)
        try:
            for place, ran in Local(open_one, entries, order.fresh)(work):
                remaining.discard(names[place])
                tell(names[place], _line(ran))
        except EngineError as error:  # the engine itself: it is not here, or died as a whole
            for name in remaining:
                tell(name, _line(error))


def _line(ran: Ran) -> dict[str, Any]:
    if not isinstance(ran, Measured | EngineUndecidedError):
        return {"error": str(ran), "refused": isinstance(ran, RequestError)}
    provenance = ran.provenance
    reason = {"undecided": str(ran)} if isinstance(ran, EngineUndecidedError) else {}
    return {
        **reason,
        "values": dict(ran.values),
        "seconds": ran.seconds,
        "ranks": ran.ranks,
        "engine": provenance.engine if provenance else "",
        "engine_version": provenance.engine_version if provenance else "",
    }


def outcome_of(line: Mapping[str, Any]) -> Ran:
    """Return the outcome in a line that a job wrote."""
    if "error" in line:
        return (RequestError if line["refused"] else EngineCrashError)(line["error"])
    provenance = Provenance(line["engine"], line["engine_version"], how="SLURM")
    ran = Measured(line["values"], provenance, line["seconds"], line["ranks"])
    return undecided(line["undecided"], ran) if "undecided" in line else ran


def submit(orders: Sequence[JobOrder], group: Path, settings: ExecutorOptions) -> list[str]:
    """Submit a job for each order, as one array; raise RequestError where sbatch refuses."""
    import submitit
    from submitit.core.utils import FailedJobError

    executor = submitit.SlurmExecutor(folder=group / "jobs")
    executor.update_parameters(**settings.parameters(sorted(executor._valid_parameters())))
    try:
        with contextlib.redirect_stderr(io.StringIO()):  # what sbatch says is in the error
            return [str(job.job_id) for job in executor.map_array(run_order, orders)]
    except FailedJobError as error:
        lines = str(error).splitlines()
        why = next((line for line in reversed(lines) if line.startswith("sbatch:")), lines[-1])
        raise RequestError(f"--executor slurm: it refuses the jobs: {why.strip()}") from None


SUBMITIT = re.compile(r"^\s*submitit\b|\bsubmitit (?:DEBUG|INFO|WARNING|ERROR)\b")


def logs_of(group: Path, job: str) -> list[Path]:
    """Return what a job printed: nothing where it never started, as SLURM makes the file then."""
    return sorted((group / "jobs").glob(f"{job}_*log.out"))


def last_line(group: Path, job: str) -> str:
    """Return the last line that a job printed, in brackets; not those of submitit about itself."""
    for log in logs_of(group, job):
        lines = log.read_text(encoding="utf-8", errors="replace").split("\n")
        printed = [line.strip() for line in lines if line.strip() and not SUBMITIT.search(line)]
        return f" (its last line: {printed[-1][:160]})" if printed else ""
    return ""


K = TypeVar("K")

MOST_JOBS = 1000
"""Of one array: what SLURM takes by default."""

LOOK_SECONDS = (0.5, 10.0)
"""Between two looks at the queue: at first, and after a while."""

MARGIN = 3.0
"""By which a job's time must exceed what its runs are expected to take: estimates of steps are good
to it."""

PART_MARGIN = 1.5
"""The same of a part between two restart files, whose number of steps is known."""

GAIN = 0.5
"""Part of the speed of so many ranks that is counted on."""

SETTLE_SECONDS = 5.0
"""After the end of a job, for its last lines to be seen on another machine."""

OUTCOMES, SUBMITTED = "outcomes", "submitted.jsonl"


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
        kept = dict(self.local.lookup(work))
        to_run = {i: p for i, p in enumerate(work.parameters) if i not in kept}
        if not to_run:
            return iter(kept.items())
        self._check(work, to_run)
        opening = {} if work.solves else dict(self.opening(work.engine))
        facts: dict[str, Any] = {"case": work.case.name, "engine": work.engine, "opening": opening}
        facts["quantities"] = _quantities(work)
        if not work.solves:
            facts["who"] = fingerprint_of(work.engine, chosen_options(work.engine, **opening))
        waiting = _Waiting(self._group(facts), self.tell)
        waiting.resubmit = partial(self._resubmit, work, opening, waiting)
        for place, parameters in to_run.items():
            name = key_of(parameters.model_dump(mode="json"))
            waiting.places.setdefault(name, []).append(place)
            waiting.runs[name] = parameters
        kept |= dict(waiting.unread(errors=False))
        waiting.attach()
        missing = [name for name in waiting.places if name not in waiting.covered()]
        waiting.marks |= self._marks(work, waiting.runs)
        if missing:
            chosen = {name: waiting.runs[name] for name in missing}
            waiting.jobs |= self._submitted(work, opening, chosen, waiting.group)
        return itertools.chain(kept.items(), waiting.outcomes())

    def check(self, work: Work) -> None:
        """Raise RequestError for work that cannot be run so; nothing is submitted."""
        if not work.parameters:
            return
        check_launcher(*self._launching(work))
        costs = self._costs(work, dict(enumerate(work.parameters)))
        if not all(self._fits(seconds) for seconds in costs.values()):
            kept = dict(self.local.lookup(work))
            self._check(work, {i: p for i, p in enumerate(work.parameters) if i not in kept})

    def cost(self, work: Work) -> dict[str, Any]:
        """Return the jobs that work takes by estimate and the longest run there [h].

        ``problem`` says why it would be refused, which is no number of jobs, or is empty.
        """
        runs = {str(place): parameters for place, parameters in enumerate(work.parameters)}
        costs = self._costs(work, runs)
        times = [sum(costs[name] for name in chunk) for chunk in self._chunks(work, runs)]
        limit = 60.0 * self.settings.minutes * self._workers
        problem = ""
        try:
            self._check(work, dict(enumerate(work.parameters)))
        except RequestError as error:
            problem = str(error)
        return {
            "ranks": self.settings.ranks,
            "jobs": None if problem else sum(max(1, math.ceil(s / limit)) for s in times),
            "longest_run_hours": max(costs.values()) / 3600.0,
            "problem": problem,
        }

    def _launching(self, work: Work) -> tuple[str | None, str, int]:
        if work.solves:
            return None, "", 1
        options = chosen_options(work.engine, **self.opening(work.engine))
        mpi = engine_class(work.engine).srun_mpi(**options)
        return options.get("launcher"), mpi, self.settings.ranks

    def _costs(self, work: Work, runs: Mapping[K, Parameters]) -> dict[K, float]:
        """Return what runs are expected to take in a job [s]."""
        rules = None if work.solves else engine_class(work.engine).traits
        solver = work.engine if work.solves else ""
        speed = max(1.0, GAIN * self.settings.ranks)
        return {
            i: work.case.seconds(parameters, rules, solver) / speed
            for i, parameters in runs.items()
        }

    def _fits(self, seconds: float, margin: float = MARGIN) -> bool:
        return margin * seconds <= 60.0 * self.settings.minutes

    def _check(self, work: Work, to_run: Mapping[int, Parameters]) -> None:
        """Raise RequestError for a run that fits no job and cannot go on in another."""
        costs = self._costs(work, to_run)
        for place in sorted(to_run, key=lambda i: -costs[i]):
            if self._fits(costs[place]):
                return
            seconds, margin = costs[place], MARGIN
            if self._resumes(work, to_run[place]):
                rules = engine_class(work.engine).traits
                seconds = work.case.part_seconds(to_run[place], rules)
                seconds, margin = seconds / max(1.0, GAIN * self.settings.ranks), PART_MARGIN
                if self._fits(seconds, margin):
                    continue
            part = " between two restart files" if margin == PART_MARGIN else ""
            least = math.ceil(margin * seconds / 60.0)
            raise RequestError(
                f"--time {self.settings.minutes:g}: the run {label(work, to_run[place])} of case "
                f"{work.case.name!r} is expected to take {in_words(seconds)}{part}, {margin:g} "
                f"times that must fit a job: --time {least} at least, or more --ranks"
            )

    def _resumes(self, work: Work, parameters: Parameters) -> bool:
        if work.solves:
            return False
        with self.local.open_one(work.engine) as engine:
            return engine.resumes(work.case.job(parameters))

    def _marks(self, work: Work, runs: Mapping[str, Parameters]) -> dict[str, float]:
        """Return when runs left their last restart files [s], 0 without any."""
        if work.solves:
            return {}
        with self.local.open_one(work.engine) as engine:
            return {
                name: engine.resumed_at(work.case.job(parameters))
                for name, parameters in runs.items()
            }

    def _resubmit(
        self, work: Work, opening: dict[str, Any], waiting: _Waiting, names: Sequence[str], *,
        ended_some: bool,
    ) -> bool:  # fmt: skip
        """Submit the runs that a job left if it got on, and return whether it did."""
        runs = {name: waiting.runs[name] for name in names}
        marks = self._marks(work, runs)
        if not (ended_some or any(marks[n] > waiting.marks.get(n, 0.0) for n in marks)):
            return False
        waiting.marks |= marks
        waiting.jobs |= self._submitted(work, opening, runs, waiting.group)
        return True

    @property
    def _workers(self) -> int:
        """Return how many runs of a job are made side by side."""
        return 1 if self.settings.ranks > 1 else self.settings.cpus

    def _chunks(self, work: Work, chosen: Mapping[str, Parameters]) -> list[list[str]]:
        """Return the names of the runs of each job: as many as fit its time, ``chunk`` at most."""
        workers = self._workers
        chunks: list[list[str]] = []
        total = longest = 0.0
        for name, seconds in self._costs(work, chosen).items():
            total, longest = total + seconds, max(longest, seconds)
            # of runs side by side, each begun as a core is free
            bound = total / workers + longest * (1.0 - 1.0 / workers)
            if not chunks or len(chunks[-1]) == self.settings.chunk or not self._fits(bound):
                chunks.append([])
                total = longest = seconds
            chunks[-1].append(name)
        return chunks

    def _group(self, facts: Mapping[str, Any]) -> Path:
        fresh = time.time_ns() if self.local.fresh else 0
        digest = key_of({**facts, "source": source_digest(), "fresh": fresh})
        group = (self.folder / "slurm" / digest[:16]).absolute()
        (group / OUTCOMES).mkdir(parents=True, exist_ok=True)
        return group

    def _submitted(
        self, work: Work, opening: dict[str, Any], chosen: dict[str, Parameters], group: Path
    ) -> dict[str, list[str]]:
        chunks = self._chunks(work, chosen)
        stamp = time.time_ns()
        orders = [
            JobOrder(
                work.case.name,
                work.engine,
                opening,
                {name: chosen[name] for name in chunk},
                self.cache.absolute() if self.cache else None,
                self.local.fresh,
                group / OUTCOMES / f"{stamp}-{number}.jsonl",
                _quantities(work),
            )
            for number, chunk in enumerate(chunks)
        ]
        submitted: dict[str, list[str]] = {}
        for first in range(0, len(orders), MOST_JOBS):
            some = orders[first : first + MOST_JOBS]
            for job, order in zip(submit(some, group, self.settings), some, strict=True):
                submitted[job] = list(order.parameters)
            with (group / SUBMITTED).open("a", encoding="utf-8") as file:
                for job in list(submitted)[first:]:
                    file.write(json.dumps({"job": job, "runs": submitted[job]}) + "\n")
        ids = sorted({job.partition("_")[0] for job in submitted})
        self.tell(f"{len(submitted)} jobs are submitted to SLURM ({', '.join(ids)})")
        return submitted


def _quantities(work: Work) -> tuple[str, ...]:
    return tuple(quantity.name for quantity in work.case.quantities)


def label(work: Work, parameters: Parameters) -> str:
    """Return what is particular to a run among those of its work, as ``height = 8, seed = 3``."""
    default = default_of(work.case) if len(work.parameters) == 1 else None
    others = work.parameters if default is None else [default]
    columns = [{name: info.default for name, info in parameters_in(other)} for other in others]
    values = {
        name: info.default
        for name, info in parameters_in(parameters)
        if name not in work.case.varied
    }
    apart = [name for name in values if any(column.get(name) != values[name] for column in columns)]
    return ", ".join(f"{name} = {values[name]}" for name in apart) or "with its default values"


@dataclass
class _Waiting:
    """The runs without an outcome, by name, and the jobs that they are in."""

    group: Path
    tell: Callable[[str], None]
    places: dict[str, list[int]] = field(default_factory=dict)
    jobs: dict[str, list[str]] = field(default_factory=dict)
    read: dict[Path, int] = field(default_factory=dict)
    reasons: set[str] = field(default_factory=set)
    runs: dict[str, Parameters] = field(default_factory=dict)
    marks: dict[str, float] = field(default_factory=dict)
    resubmit: Callable[..., bool] = lambda *_, **__: False

    def attach(self) -> None:
        file = self.group / SUBMITTED
        lines = file.read_text(encoding="utf-8").splitlines() if file.is_file() else []
        live = queued() if lines else {}
        for line in lines:
            submitted = json.loads(line)
            if live is None or submitted["job"] in live:
                self.jobs[submitted["job"]] = submitted["runs"]

    def covered(self) -> set[str]:
        return {name for names in self.jobs.values() for name in names}

    def unread(self, *, errors: bool = True) -> Iterator[tuple[int, Ran]]:
        for path in sorted((self.group / OUTCOMES).glob("*.jsonl")):
            with path.open("rb") as file:
                file.seek(self.read.get(path, 0))
                for line in file:
                    if not line.endswith(b"\n"):
                        break  # it is being written, or its writer was killed
                    self.read[path] = self.read.get(path, 0) + len(line)
                    outcome = json.loads(line)
                    if outcome["run"] in self.places and (errors or "error" not in outcome):
                        ran = outcome_of(outcome)
                        yield from ((place, ran) for place in self.places.pop(outcome["run"]))

    def outcomes(self) -> Iterator[tuple[int, Ran]]:
        """Yield the outcomes until every run has one or its job has ended."""
        pause = LOOK_SECONDS[0]
        while self.places and self.jobs:
            yield from self.unread()
            live = queued()
            self._tell_of_waits(live or {})
            for job in [job for job in self.jobs if live is not None and job not in live]:
                yield from self._ended(job, self.jobs.pop(job))
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
        """Yield the last outcomes of a job, and errors for the runs that it did not finish."""
        until = time.monotonic() + SETTLE_SECONDS
        while any(name in self.places for name in names) and time.monotonic() < until:
            yield from self.unread()
            time.sleep(LOOK_SECONDS[0])
        lost = [name for name in names if name in self.places]
        if lost:
            end, started = end_of(job), bool(logs_of(self.group, job))
            cancelled = end == "CANCELLED" or not started
            if not cancelled and self.resubmit(lost, ended_some=len(lost) < len(names)):
                self.tell(f"SLURM's job {job} ended ({end or 'not known how'}): its rest goes on")
                return
            how = f"ended before it: {end or 'not known how'}{last_line(self.group, job)}"
            if not started:
                cause = "was cancelled" if end in ("", "CANCELLED") else f"ended ({end})"
                how = f"{cause} before it started"
            why = f"SLURM's job {job} {how}"
            for name in lost:
                yield from ((place, EngineCrashError(why)) for place in self.places.pop(name))
