"""Jobs in other processes: any executor, and a Dask cluster that loses workers and scheduler."""

import contextlib
import inspect
import os
import pickle
import re
import signal
import subprocess
import sys
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import pandas as pd
import pytest

import harness.errors
from harness.engines.registry import open_engine
from harness.errors import EngineCrashError, EngineError, HarnessError, RequestError
from harness.files import cache_place
from harness.store.cache import contents
from harness.workflows import executors, run, sweep, verify
from harness.workflows.executors import Copy, Queue, dask_executor
from tests.workflows.doubles import PROJECT, start

GOOD, SLOW = (f"tests.workflows.doubles:{name}" for name in ("Good", "Slow"))
pytestmark = pytest.mark.usefixtures("registered")
ERRORS = [kind for _, kind in inspect.getmembers(harness.errors, inspect.isclass)
          if issubclass(kind, EngineError)]  # fmt: skip


class InPlace(Executor):
    """Runs at once; ``lost`` futures raise as those of a lost worker do."""

    def __init__(self, lost=()):
        self.lost, self.pieces = lost, []

    def submit(self, function, /, *args):
        future = Future()
        self.pieces.append(args[-1])
        if len(self.pieces) in self.lost:
            future.set_exception(RuntimeError("worker gone"))
        else:
            future.set_result(function(*args))
        return future


def test_run_sweep_and_verify_in_processes_have_the_values_of_the_local_engine():
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        there = run("bounce", {"steps": 100}, GOOD, executor=pool)
        rows = sweep("bounce", {"steps": "100,120"}, engines=GOOD, executor=pool).rows
        verified = verify("quick", engines=GOOD, executor=pool)
    assert there.to_json() == run("bounce", {"steps": 100}, GOOD, open_engine=open_engine).to_json()
    assert [row["status"] for row in rows] == ["done", "done"]
    assert rows[0]["measured_restitution"] == there.quantities["restitution"].value
    assert verified.status == 0
    assert set(verified.rows["verdict"]) == {"pass"}


def test_a_worker_that_is_lost_costs_its_runs_alone():
    lost = InPlace(lost=(2,))
    result = sweep("bounce", {"steps": "100:400:4"}, engines=GOOD, executor=lost)
    assert [row["status"] for row in result.rows] == ["done", "failed", "done", "done"]
    assert result.rows[1]["reason"] == "failed on its worker: worker gone"
    again = InPlace()
    assert sweep("bounce", {"steps": "100:400:4"}, engines=GOOD, executor=again).count("done") == 4
    assert len(again.pieces) == 1  # the others were kept
    solved = sweep("bounce", {"steps": "20,30"}, engines="exact", executor=InPlace(lost=(1,)))
    assert [row["status"] for row in solved.rows] == ["failed", "done"]


def test_a_job_that_dies_elsewhere_is_the_error_it_is_here():
    with pytest.raises(EngineCrashError, match="SIGSEGV") as error:
        run("bounce", None, "tests.workflows.doubles:Dying", executor=InPlace())
    assert error.value.log == "last words"


@pytest.mark.parametrize("kind", ERRORS)
def test_an_error_of_an_engine_is_sent_whole(kind):
    extra = [{"angle": 1.0}] if kind.__name__ == "EngineUndecidedError" else []
    error = kind("what it reports", *extra).with_log("the log")
    sent = pickle.loads(pickle.dumps(error))
    assert (type(sent), str(sent), sent.log) == (kind, "what it reports", "the log")
    assert not extra or sent.values == extra[0]


def test_a_worker_with_other_programs_runs_nothing(monkeypatch):
    here, there = {"program of the engine": "1", "numpy": "2.0"}, {"numpy": "1.26"}
    answers = iter([here, {**here, **there}])
    monkeypatch.setattr(executors, "identity", lambda _: next(answers))
    monkeypatch.setattr(executors, "_open_engines", {})
    (row,) = sweep("bounce", {"steps": "77"}, engines=GOOD, executor=InPlace()).rows
    assert row["status"] == "failed"
    assert "not the same here and where the command runs: numpy" in row["reason"]


# ---- Dask


class Cluster:
    """A scheduler and workers in processes of their own."""

    def __init__(self, folder):
        self.folder, self.file = folder, folder / "scheduler.json"
        self.scheduler = self._start("scheduler", "--port", "0", "--host", "127.0.0.1")
        options = ("--no-nanny", "--nthreads", "1", "--local-directory", str(folder))
        self.workers = [self._start("worker", *options) for _ in range(2)]
        from distributed import Client

        with Client(scheduler_file=str(self.file), timeout=300, set_as_default=False) as client:
            client.wait_for_workers(2, timeout=300)
            self.address = client.scheduler.address

    def _start(self, name, *options):
        words = [sys.executable, "-m", f"distributed.cli.dask_{name}", "--no-dashboard"]
        return subprocess.Popen(
            [*words, "--scheduler-file", str(self.file), *options],
            env={**os.environ, "PYTHONPATH": str(PROJECT)},
            cwd=PROJECT, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
        )  # fmt: skip

    def end(self):
        for process in (self.scheduler, *self.workers):
            process.kill()
            process.wait()


@pytest.fixture
def dask_here():
    pytest.importorskip("distributed", reason="the extra dask is not installed")
    pytest.importorskip("dask_jobqueue", reason="the extra dask is not installed")


@pytest.fixture
def cluster(dask_here, tmp_path):  # noqa: ARG001
    started = Cluster(tmp_path)
    yield started
    started.end()


def kept_runs():
    return sum(entry.label[0] == "run" for entry in contents(cache_place().path))


def wait_for(condition, seconds=300):  # only a hang takes as long, on a busy machine too
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.05)


@pytest.mark.slow
def test_a_sweep_goes_on_where_client_worker_and_scheduler_were_killed(cluster, tmp_path):
    over, before = "100:199:100", kept_runs()
    command = ("sweep", "bounce", "--over", f"steps={over}", "--engines", SLOW)
    client = start(tmp_path, *command, "--output", "mine", "--dask", cluster.address)
    try:
        wait_for(lambda: kept_runs() - before >= 5)
    finally:
        client.kill()
        client.wait()
    victims = {40: cluster.workers[0], 70: cluster.scheduler}

    def kill(_, done, __):
        if done in victims:
            victims.pop(done).kill()

    counted = InPlace()
    with dask_executor(cluster.address) as executor:
        result = sweep("bounce", {"steps": over}, engines=SLOW, executor=executor, progress=kill)
    assert not victims
    assert 70 <= result.count("done") < 100  # the scheduler gave the dead worker's run to the other
    assert {row["reason"] for row in result.rows} == {"", executors.LOST}
    whole = sweep("bounce", {"steps": over}, engines=SLOW, executor=counted)
    assert whole.count("done") == 100
    assert sum(map(len, counted.pieces)) == 100 - result.count("done")


STUBS = {
    "srun": 'exec "$@"',
    # as the true one it keeps the script, which Dask removes once it is submitted
    "sbatch": 'case "$*" in *--test-only*) exit 0;; esac\n'
    'cp "$1" job.sh\n'
    'bash job.sh > worker.log 2>&1 < /dev/null & echo "Submitted batch job $!"',
    "scancel": 'kill "$@"',
}


def group_lives(group):
    with contextlib.suppress(ProcessLookupError):
        os.killpg(group, 0)
        return True
    return False


@pytest.mark.slow
@pytest.mark.usefixtures("dask_here")
@pytest.mark.parametrize("place", [0, 1])
def test_the_scripts_of_slurm_run_where_its_commands_do(tmp_path, script_file, place):
    page = (PROJECT / "harness" / "workflows" / "README.md").read_text("utf-8")
    scripts = re.findall(r"^```bash\n(#!.*?)^```", page, re.M | re.S)
    settings = re.search(r"^```yaml\n(jobqueue.*?)^```", page, re.M | re.S)[1]
    for name, text in STUBS.items():
        script_file(text, name)
    (tmp_path / "jobqueue.yaml").write_text(settings.replace("16", "1"))
    (tmp_path / "script.sh").write_text(scripts[place])
    path = f"{tmp_path}:{Path(sys.executable).parent}:{os.environ['PATH']}"
    environment = {**os.environ, "PATH": path, "SLURM_JOB_ID": str(os.getpid()),
                   "DASK_CONFIG": str(tmp_path), "PYTHONPATH": str(PROJECT)}  # fmt: skip
    words = ("sweep", "tower", "--over", "height=1,2", "--engines", "reference", "--output", "mine")
    started = subprocess.Popen(
        ["bash", "script.sh", *words], cwd=tmp_path, env=environment, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
    )  # fmt: skip
    try:
        wait_for(lambda: started.poll() is not None)
        wait_for(lambda: not group_lives(started.pid))  # scheduler and workers have ended too
    finally:
        if group_lives(started.pid):
            os.killpg(started.pid, signal.SIGKILL)
    assert started.returncode == 0, started.stdout.read()
    started.stdout.close()
    assert (pd.read_csv(tmp_path / "mine" / "rows.csv")["status"] == "done").sum() == 2


NO_SCHEDULER = r"no scheduler answers there \(.*as tcp://head:8786, or slurm$"


@pytest.mark.usefixtures("dask_here")
@pytest.mark.parametrize(
    ("cluster", "words"),
    [
        ("nowhere", NO_SCHEDULER),
        ("tcp://127.0.0.1:1", NO_SCHEDULER),
        ("tcp://127.0.0.1:x", NO_SCHEDULER),
        ("", NO_SCHEDULER),
        ("slurm", "there is no sbatch on the path"),
        ("slurm:0", "must be slurm:JOBS, from 1 to 10000 jobs"),
        ("slurm:many", "must be slurm:JOBS"),
    ],
)
def test_a_cluster_that_is_not_there_is_an_error_of_one_line(monkeypatch, cluster, words):
    monkeypatch.setattr(executors, "CONNECT_SECONDS", 0.5)
    monkeypatch.setenv("PATH", "")
    with pytest.raises(RequestError, match=rf"^--dask {cluster}.*{words}"), dask_executor(cluster):
        pass


def test_dask_that_is_not_installed_is_refused_with_the_remedy(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    refused = pytest.raises(RequestError, match=r"pip install 'dem-harness\[dask\]'")
    with refused, dask_executor("tcp://127.0.0.1:1"):
        pass


# ---- copies of this process


def squares(queue, progress):
    """Yield the squares of the items of a queue, from the order on."""
    first = yield "ready"
    for item in queue:
        progress("squares", item, 0)
        yield first + item * item


def test_each_item_of_a_queue_is_taken_once_by_this_process_or_a_copy():
    with Queue(range(300)) as queue, Copy(lambda _: (yield [*queue]), print) as copy:
        taken = [*queue, *copy.receive()]
    assert sorted(taken) == list(range(300))


def test_a_copy_answers_orders_and_shows_its_progress():
    shown = []
    with Queue([2, 3]) as queue:
        work, note = partial(squares, queue), lambda *parts: shown.append(parts)
        with Copy(work, note) as copy:
            answers = [copy.receive()]
            for order in (1, None):
                copy.send(order)
                answers.append(copy.receive())
    assert answers == ["ready", 5, 10]
    assert shown == [("squares", 2, 0), ("squares", 3, 0)]


def planted(kind):
    yield "ready"
    if kind == "kill":
        os.kill(os.getpid(), signal.SIGKILL)
    raise {"harness": RequestError("planted"), "other": ZeroDivisionError("planted")}[kind]


@pytest.mark.parametrize(
    ("kind", "error", "text"),
    [
        ("harness", RequestError, "planted"),
        ("other", ZeroDivisionError, "planted"),
        ("kill", HarnessError, "died: signal SIGKILL"),
    ],
)
def test_what_a_copy_raises_is_raised_here_and_its_death_is_an_error(kind, error, text):
    with Copy(lambda _: planted(kind), print) as copy:
        assert copy.receive() == "ready"
        copy.send(None)
        with pytest.raises(error, match=text):
            copy.receive()
        with pytest.raises(HarnessError, match="died"):
            copy.receive()
