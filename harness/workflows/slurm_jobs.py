"""Jobs of SLURM: what one is ordered, how it is submitted, and what it tells."""

from __future__ import annotations

import contextlib
import io
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from harness.cases.contract import Measured
from harness.cases.registry import get_case
from harness.engines.registry import open_engine
from harness.errors import (
    EngineCrashError,
    EngineError,
    EngineUndecidedError,
    RequestError,
)
from harness.observables.provenance import Provenance
from harness.parameters.base import Parameters
from harness.store.cached_engine import CachedEngine
from harness.store.entries import Entries
from harness.workflows.slurm_queue import ExecutorOptions
from harness.workflows.sweep_local import Local, Ran, Work


@dataclass(frozen=True)
class Order:
    """What a job runs: some parameters of a case, how the engine is opened, where it tells."""

    case: str
    engine: str
    opening: Mapping[str, Any]
    parameters: Mapping[str, Parameters]
    cache: Path | None
    fresh: bool
    told: Path


def run_order(order: Order) -> None:
    """Run what a job was ordered, on its node, and tell of each run as it is over."""
    entries = Entries(order.cache) if order.cache else None

    def open_one(name: str) -> Any:
        engine = open_engine(name, **order.opening)
        return engine if entries is None else CachedEngine(engine, entries, fresh=order.fresh)

    names = list(order.parameters)
    work = Work(get_case(order.case), order.engine, list(order.parameters.values()))
    with order.told.open("a", encoding="utf-8") as file:

        def tell(name: str, told: Mapping[str, Any]) -> None:
            file.write(json.dumps({"run": name, **told}) + "\n")
            file.flush()

        left = set(names)
        try:
            for place, ran in Local(open_one, entries, order.fresh)(work):
                left.discard(names[place])
                tell(names[place], _line(ran))
        except EngineError as error:  # the engine itself: it is not here, or died as a whole
            for name in left:
                tell(name, _line(error))


def _line(ran: Ran) -> dict[str, Any]:
    if not isinstance(ran, Measured | EngineUndecidedError):
        return {"error": str(ran), "refused": isinstance(ran, RequestError)}
    who = ran.provenance
    undecided = {"undecided": str(ran)} if isinstance(ran, EngineUndecidedError) else {}
    return {
        **undecided,
        "values": dict(ran.values),
        "seconds": ran.seconds,
        "ranks": ran.ranks,
        "engine": who.engine if who else "",
        "engine_version": who.engine_version if who else "",
    }


def told_of(told: Mapping[str, Any]) -> Ran:
    """Return the outcome that a line of a job tells."""
    if "error" in told:
        return (RequestError if told["refused"] else EngineCrashError)(told["error"])
    who = Provenance(told["engine"], told["engine_version"], how="SLURM")
    if "undecided" in told:
        error = EngineUndecidedError(told["undecided"], told["values"])
        error.provenance, error.seconds, error.ranks = who, told["seconds"], told["ranks"]
        return error
    return Measured(told["values"], who, told["seconds"], told["ranks"])


def submit(orders: Sequence[Order], group: Path, settings: ExecutorOptions) -> list[str]:
    """Submit a job for each order, as one array; raise RequestError where sbatch refuses."""
    import submitit
    from submitit.core.utils import FailedJobError

    executor = submitit.SlurmExecutor(folder=group / "jobs")
    executor.update_parameters(**settings.parameters(sorted(executor._valid_parameters())))
    try:
        with contextlib.redirect_stderr(io.StringIO()):  # what sbatch says is in the error
            return [str(job.job_id) for job in executor.map_array(run_order, orders)]
    except FailedJobError as error:
        said = str(error).splitlines()
        why = next((line for line in reversed(said) if line.startswith("sbatch:")), said[-1])
        raise RequestError(f"--executor slurm: it refuses the jobs: {why.strip()}") from None


SUBMITIT = re.compile(r"^\s*submitit\b|\bsubmitit (?:DEBUG|INFO|WARNING|ERROR)\b")


def logs_of(group: Path, job: str) -> list[Path]:
    """Return what a job printed: nothing where it never started, as SLURM makes the file then."""
    return sorted((group / "jobs").glob(f"{job}_*log.out"))


def last_line(group: Path, job: str) -> str:
    """Return the last line that a job printed, in brackets; not those of submitit about itself."""
    for log in logs_of(group, job):
        lines = log.read_text(encoding="utf-8", errors="replace").split("\n")
        said = [line.strip() for line in lines if line.strip() and not SUBMITIT.search(line)]
        return f" (its last line: {said[-1][:160]})" if said else ""
    return ""
