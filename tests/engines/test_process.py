import os
import signal
import sys
import threading
import time
from pathlib import Path

import pytest

from harness.engines.process import Processes
from harness.errors import EngineCrashError, EngineMemoryError, EngineTimeoutError

MEMORY = 4 * 1024**3


@pytest.fixture
def python(tmp_path):
    """Return a function that runs Python source under limits."""
    processes = Processes()

    def run(source, seconds=60.0, memory=MEMORY):
        return processes.run(
            [sys.executable, "-c", source], tmp_path, seconds=seconds, memory=memory
        )

    yield run
    processes.close()


def test_what_it_says_is_kept_and_a_good_end_is_no_error(python):
    ended = python("import os; print('hello', os.environ['OMP_NUM_THREADS'])")
    assert ended.said == "hello 1\n"
    assert ended.code == 0
    assert ended.error("it", 60.0) is None


@pytest.mark.parametrize(
    ("source", "error", "words"),
    [
        ("print('oh'); raise SystemExit(7)", EngineCrashError, r"died: exit status 7 .*line: oh\)"),
        ("import os; os.abort()", EngineCrashError, "died: signal SIGABRT"),
        ("bytearray(10**10)", EngineMemoryError, "out of memory"),
    ],
)
def test_each_way_to_die_has_its_error_with_the_last_words(python, source, error, words):
    found = python(source, memory=1024**3).error("it", 60.0)
    with pytest.raises(error, match=f"^it .*{words}"):
        raise found
    assert found.log == "" or found.log.strip()


def test_one_that_hangs_is_killed_with_its_children(python, tmp_path):
    child = "import subprocess, sys; p = subprocess.Popen(['sleep', '100']); print(p.pid); "
    ended = python(child + "sys.stdout.flush(); p.wait()", seconds=2.0)
    with pytest.raises(EngineTimeoutError, match=r"^it did not finish within 2 s$"):
        raise ended.error("it", 2.0)
    assert _gone(int((tmp_path / "said").read_text()))


def test_a_program_that_goes_on_has_its_time_for_each_step(tmp_path):
    processes = Processes()
    steps = "import time\nfor i in range(4):\n open(str(i), 'w').close()\n time.sleep(0.9)"
    options = {"seconds": 2.0, "memory": MEMORY, "progress": lambda: len(list(tmp_path.iterdir()))}
    assert not processes.run([sys.executable, "-c", steps], tmp_path, **options).timed_out
    start = time.monotonic()
    stuck = steps.replace("range(4)", "range(1)").replace("0.9", "60")
    assert processes.run([sys.executable, "-c", stuck], tmp_path, **options).timed_out
    assert time.monotonic() - start < 10.0


def test_of_a_flood_of_words_the_last_are_kept(python):
    ended = python("print('x' * 10_000_000); print('the end')")
    assert len(ended.said) == 4000
    assert ended.said.endswith("the end\n")


def _gone(pid):
    for _ in range(100):
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return True
        if Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z":
            return True
        time.sleep(0.05)
    return False


def test_closing_ends_what_runs_and_starts_nothing_more(tmp_path):
    processes, ended = Processes(), []

    def run():
        ended.append(processes.run(["sleep", "100"], tmp_path, seconds=100.0, memory=MEMORY))

    thread = threading.Thread(target=run)
    thread.start()
    while not (tmp_path / "said").exists():
        time.sleep(0.01)
    time.sleep(0.2)
    processes.close()
    thread.join(10.0)
    assert ended[0].code == -signal.SIGKILL
    with pytest.raises(EngineCrashError, match="sleep was closed"):
        processes.run(["sleep", "1"], tmp_path, seconds=1.0, memory=MEMORY)
