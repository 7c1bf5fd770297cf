"""Jobs of SLURM: what one is ordered, how it is submitted, and what it tells."""

from __future__ import annotations

import contextlib
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from harness.cases.contract import Measured
from harness.cases.registry import get_case
from harness.engines.registry import open_engine
from harness.errors import EngineCrashError, EngineError, RequestError
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
    if not isinstance(ran, Measured):
        return {"error": str(ran), "refused": isinstance(ran, RequestError)}
    who = ran.provenance
    return {
        "values": dict(ran.values),
        "seconds": ran.seconds,
        "engine": who.engine if who else "",
        "engine_version": who.engine_version if who else "",
    }


def told_of(told: Mapping[str, Any]) -> Ran:
    """Return the outcome that a line of a job tells."""
    if "error" in told:
        return (RequestError if told["refused"] else EngineCrashError)(told["error"])
    who = Provenance(told["engine"], told["engine_version"], how="SLURM")
    return Measured(told["values"], who, told["seconds"])


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


def last_line(group: Path, job: str) -> str:
    """Return the last line that a job printed, in brackets."""
    for log in sorted((group / "jobs").glob(f"{job}_*log.out")):
        lines = log.read_text(encoding="utf-8", errors="replace").split("\n")
        said = [line.strip() for line in lines if line.strip()]
        return f" (its last line: {said[-1][:160]})" if said else ""
    return ""
