"""Jobs in other processes: any executor, and a Dask cluster of which a worker is lost."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import pytest

from harness.engines.registry import open_engine
from harness.errors import EngineCrashError, RequestError
from harness.store.cache import CachedEngine
from harness.store.entries import Entries
from harness.workflows import run, sweep
from harness.workflows.executors import ExecutorEngine, dask_executor
from tests.workflows import doubles

GOOD, SLOW = (f"tests.workflows.doubles:{name}" for name in ("Good", "Slow"))
pytestmark = pytest.mark.usefixtures("registered")
PROJECT = Path(__file__).parents[2]


def opener(executor, entries=None):
    def opened(name):
        engine = ExecutorEngine(open_engine(name), executor, name, {})
        return engine if entries is None else CachedEngine(engine, entries)

    return opened


class InPlace(Executor):
    """Runs at once; ``lost`` futures raise as those of a lost worker do."""

    def __init__(self, lost=()):
        self.lost, self.chunks = lost, []

    def submit(self, function, /, *args):
        future = Future()
        self.chunks.append(args[-1])
        if len(self.chunks) in self.lost:
            future.set_exception(RuntimeError("worker gone"))
        else:
            future.set_result(function(*args))
        return future


def test_the_values_are_those_of_the_local_engine():
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as executor:
        there = run("bounce", {"steps": 100}, GOOD, open_engine=opener(executor))
    here = run("bounce", {"steps": 100}, GOOD, open_engine=open_engine)
    assert there.to_json() == here.to_json()


def test_a_worker_that_is_lost_costs_its_runs_alone():
    executor = InPlace(lost=(2,))
    result = sweep("bounce", {"steps": "100:400:4"}, engines=GOOD, open_engine=opener(executor))
    assert [row["status"] for row in result.rows] == ["done", "failed", "done", "done"]
    assert result.rows[1]["reason"] == "its worker was lost: worker gone"


def test_many_jobs_go_in_chunks():
    executor = InPlace()
    sweep("bounce", {"steps": "10:1005:200"}, engines=GOOD, open_engine=opener(executor))
    assert {len(chunk) for chunk in executor.chunks} <= {1, 2, 3}


def test_a_job_that_dies_elsewhere_is_the_error_it_is_here():
    name = "tests.workflows.doubles:Dying"
    with pytest.raises(EngineCrashError, match="SIGSEGV"):
        run("bounce", None, name, open_engine=opener(InPlace()))


@pytest.mark.benchmark
def test_the_overhead_of_a_run_is_below_10_ms():
    values = {"steps": [str(steps) for steps in range(100, 600)]}
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as executor:
        sweep("bounce", {"steps": "50,60"}, engines=GOOD, open_engine=opener(executor))
        started = time.monotonic()
        sweep("bounce", values, engines=GOOD, open_engine=opener(executor))
        assert (time.monotonic() - started) / 500 < 0.010


# ---- Dask


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """Start a scheduler and two workers in processes of their own; return address and workers."""
    pytest.importorskip("distributed", reason="the extra dask is not installed")
    file = tmp_path_factory.mktemp("dask") / "scheduler.json"
    environment = {**os.environ, "PYTHONPATH": str(PROJECT)}

    def start(name, *options):
        words = [sys.executable, "-m", f"distributed.cli.{name}", "--scheduler-file", str(file)]
        return subprocess.Popen(
            [*words, *options], env=environment, cwd=PROJECT, stderr=subprocess.DEVNULL
        )

    started = [start("dask_scheduler", "--port", "0", "--no-dashboard", "--host", "127.0.0.1")]
    worker = ("--no-nanny", "--no-dashboard", "--nthreads", "1", "--local-directory", file.parent)
    started += [start("dask_worker", *map(str, worker)) for _ in range(2)]
    from distributed import Client

    with Client(scheduler_file=str(file), timeout=60, set_as_default=False) as client:
        client.wait_for_workers(2, timeout=60)
        address = client.scheduler.address
    yield address, started[1:]
    for process in started:
        process.kill()
        process.wait()


@pytest.mark.slow
def test_a_sweep_goes_on_where_a_worker_and_then_the_client_was_killed(cluster, tmp_path):
    address, workers = cluster
    entries, over = Entries(tmp_path), {"steps": "100:139:40"}
    killed = False

    def kill_one(*_):
        nonlocal killed
        if not killed:
            killed = True
            workers[0].send_signal(signal.SIGKILL)

    with dask_executor(address) as executor:
        result = sweep("bounce", over, engines=SLOW, open_engine=opener(executor, entries),
                       progress=lambda _, done, __: kill_one() if done == 5 else None)  # fmt: skip
    assert killed
    assert result.count("done") == 40  # the scheduler gave the runs of the dead to the other
    with dask_executor(address) as executor:
        started = time.monotonic()
        again = sweep("bounce", over, engines=SLOW, open_engine=opener(executor, entries))
    assert again.count("done") == 40
    assert time.monotonic() - started < 40 * doubles.Slow.seconds  # kept, not run


def test_a_scheduler_that_is_not_there_is_named():
    pytest.importorskip("distributed", reason="the extra dask is not installed")
    with (
        pytest.raises(
            RequestError, match=r"--dask nowhere: no scheduler.*tcp://head:8786, or slurm"
        ),
        dask_executor("nowhere"),
    ):
        pass


def test_dask_that_is_not_installed_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    refused = pytest.raises(RequestError, match=r"pip install 'dem-harness\[dask\]'")
    with refused, dask_executor("tcp://127.0.0.1:1"):
        pass
