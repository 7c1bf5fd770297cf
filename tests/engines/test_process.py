import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from harness.engines.process import (
    Limits,
    Processes,
    text_of,
)
from harness.engines.registry import _limits as limits_in
from harness.errors import (
    EngineCrashError,
    EngineInputError,
    EngineMemoryError,
    EngineOutputError,
    EngineTimeoutError,
)

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
    assert ended.error("it") is None


@pytest.mark.parametrize(
    ("source", "error", "words"),
    [
        ("print('oh'); raise SystemExit(7)", EngineCrashError, r"died: exit status 7 .*line: oh\)"),
        ("import os; os.abort()", EngineCrashError, "died: signal SIGABRT"),
        ("bytearray(10**10)", EngineMemoryError, "out of memory"),
        (
            "print('ERROR: angle = 5: must be 4'); raise SystemExit('no')",
            EngineCrashError,
            r"exit status 1 \(its last line: no\)",
        ),
        ("raise SystemExit('ERROR: angle = 5: must be 4')", EngineInputError, "refused its input"),
        (
            "import os; print('ERROR: angle = 5: must be 4', flush=True); os.kill(os.getpid(), 11)",
            EngineCrashError,
            "died: signal SIGSEGV",
        ),
        (
            "import os; print('std::bad_alloc', flush=True); print('3', flush=True); "
            "os.kill(os.getpid(), 11)",
            EngineCrashError,
            "died: signal SIGSEGV",
        ),
        ("import os; os.kill(os.getpid(), 9)", EngineMemoryError, "signal SIGKILL"),
    ],
)
def test_each_way_to_die_has_its_error_with_the_last_words(python, source, error, words):
    found = python(source, memory=1024**3).error("it")
    with pytest.raises(error, match=f"^it .*{words}"):
        raise found
    assert found.log == "" or found.log.strip()


def test_one_that_hangs_is_killed_with_its_children(python, tmp_path):
    child = "import subprocess, sys; p = subprocess.Popen(['sleep', '100']); print(p.pid); "
    ended = python(child + "sys.stdout.flush(); p.wait()", seconds=2.0)
    with pytest.raises(EngineTimeoutError, match=r"^it did not finish within 2 s$"):
        raise ended.error("it")
    assert _gone(int((tmp_path / "said").read_text()))


def test_a_long_run_has_more_time_unless_a_limit_is_named():
    assert Limits().time_for(29.0) == 300.0
    assert Limits().time_for(600.0) == 6000.0
    assert limits_in("60").time_for(600.0) == 60.0


def test_a_program_that_goes_on_has_its_time_for_each_step(tmp_path):
    processes = Processes()
    steps = "import time\nfor i in range(3):\n open(str(i), 'w').close()\n time.sleep(0.8)"
    options = {"seconds": 2.0, "memory": MEMORY, "progress": lambda: len(list(tmp_path.iterdir()))}
    assert not processes.run([sys.executable, "-c", steps], tmp_path, **options).timed_out
    start = time.monotonic()
    stuck = steps.replace("range(3)", "range(1)").replace("0.8", "60")
    assert processes.run([sys.executable, "-c", stuck], tmp_path, **options).timed_out
    assert time.monotonic() - start < 10.0


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


HARNESS = """
import sys, threading
from pathlib import Path
from harness.engines.process import Processes
words = [sys.executable, "-c", sys.argv[2]]
options = {"seconds": 100.0, "memory": 4 * 1024**3}
thread = threading.Thread(target=Processes().run, args=(words, Path(sys.argv[1])), kwargs=options)
thread.start()
thread.join()
"""
PARENT = """
import os, subprocess
child = subprocess.Popen(["sleep", "100"])
os.write(1, f"{os.getpid()} {child.pid}\\n".encode())
"""


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
@pytest.mark.parametrize("kill", [os.kill, os.killpg])
def test_a_program_and_its_children_end_with_the_harness(tmp_path, number, kill):
    words = [sys.executable, "-c", HARNESS, tmp_path, PARENT + "child.wait()"]
    harness = subprocess.Popen(words, start_new_session=True)
    pids = _told(tmp_path / "said")
    kill(harness.pid, number)
    assert harness.wait(10.0) == -number
    assert all(_gone(pid) for pid in pids)


def test_a_program_that_floods_is_stopped_and_nothing_too_long_is_read(
    python, tmp_path, monkeypatch
):
    monkeypatch.setattr("harness.engines.process.LARGEST_FILE", 10_240)
    flood = "import signal; signal.signal(signal.SIGXFSZ, signal.SIG_DFL)\nwhile True: print('x')"
    with pytest.raises(EngineOutputError, match=r"^it wrote a file of more than 10240 bytes$"):
        raise python(flood).error("it")
    with pytest.raises(EngineOutputError, match="said holds 10240 bytes: must be below 10240"):
        text_of(tmp_path / "said")
    assert text_of(Path("/dev/zero")) == ""


def _told(said):
    """Return the numbers of the processes that a program tells, when it has."""
    while not (said.exists() and said.read_text().endswith("\n")):
        time.sleep(0.01)
    return [int(word) for word in said.read_text().split()]


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
