"""A program under limits: its end, what it leaves, and what becomes of it with the harness."""

import mmap
import os
import shutil
import signal
import subprocess
import sys
import time
from collections import namedtuple
from pathlib import Path

import pytest

from harness import files
from harness.engines.process import Limits, Processes, fresh_folder
from harness.errors import (
    EngineCrashError,
    EngineMemoryError,
    EngineOutputError,
    EngineTimeoutError,
)
from harness.files import PREFIX, SHARED

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


def test_its_output_is_returned_and_a_good_end_is_no_error(python):
    ended = python("import os; print('hello', os.environ['OMP_NUM_THREADS'])")
    assert (ended.output, ended.code, ended.error("it")) == ("hello 1\n", 0, None)


SEGV = "import os; print({}, flush=True); os.kill(os.getpid(), 11)"


@pytest.mark.parametrize(
    ("source", "error", "words"),
    [
        ("print('oh'); raise SystemExit(7)", EngineCrashError, r"died: exit status 7 .*line: oh\)"),
        ("import os; os.abort()", EngineCrashError, "died: signal SIGABRT"),
        ("bytearray(10**10)", EngineMemoryError, "out of memory"),
        (SEGV.format("'std::bad_alloc\\n3'"), EngineCrashError, "died: signal SIGSEGV"),
        ("import os; os.kill(os.getpid(), 9)", EngineMemoryError, "signal SIGKILL"),
    ],
)
def test_each_way_to_die_has_its_error_with_the_last_words(python, source, error, words):
    with pytest.raises(error, match=f"^it .*{words}"):
        raise python(source, memory=1024**3).error("it")


def test_one_that_hangs_is_killed_with_its_children(python, tmp_path):
    child = "import subprocess, sys; p = subprocess.Popen(['sleep', '100']); print(p.pid); "
    ended = python(child + "sys.stdout.flush(); p.wait()", seconds=1.0)
    with pytest.raises(EngineTimeoutError, match=r"^it did not finish within 1 s$"):
        raise ended.error("it")
    assert _gone(int((tmp_path / "said").read_text()))


def test_a_long_run_has_more_time_unless_a_limit_is_named():
    assert Limits().time_for(29.0) == 300.0
    assert Limits().time_for(600.0) == 6000.0
    assert Limits(seconds=60.0, patience=0.0).time_for(600.0) == 60.0


def test_a_program_that_goes_on_has_its_time_for_each_step(python):
    steps = "import time\nfor i in range(3):\n open(str(i), 'w').close()\n time.sleep(0.6)"
    assert not python(steps, seconds=1.2).timed_out


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
child.wait()
"""


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_a_program_and_its_children_end_with_the_harness(tmp_path, number):
    words = [sys.executable, "-c", HARNESS, tmp_path, PARENT]
    harness, said = subprocess.Popen(words, start_new_session=True), tmp_path / "said"
    while not (said.exists() and said.read_text().endswith("\n")):
        assert harness.poll() is None
        time.sleep(0.05)
    os.killpg(harness.pid, number)
    assert harness.wait(10.0) == -number
    assert all(_gone(int(pid)) for pid in said.read_text().split())


def test_a_program_that_floods_is_stopped(python, monkeypatch):
    monkeypatch.setattr("harness.engines.process.LARGEST_FILE", 10_240)
    flood = "import signal; signal.signal(signal.SIGXFSZ, signal.SIG_DFL)\nwhile True: print('x')"
    with pytest.raises(EngineOutputError, match=r"^it wrote a file of more than 10240 bytes$"):
        raise python(flood).error("it")


KILLED = """
import os, signal
from harness.engines.process import fresh_folder
with fresh_folder() as folder:
    (folder / "series").touch()
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_the_files_of_a_killed_harness_are_removed_by_the_next_run(tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    (tmp_path / "dem-harness-mine").mkdir()
    subprocess.run([sys.executable, "-c", KILLED], check=False)
    (left,) = tmp_path.glob(f"{PREFIX}*")
    assert (left / "series").exists()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with fresh_folder() as other:
        assert {path.name for path in tmp_path.iterdir()} == {other.name, "dem-harness-mine"}


# ---- segments of MPICH in shared memory

USAGE = namedtuple("USAGE", "total used free")
MAPS = """
import mmap, sys, time
with open(sys.argv[1], "w+b") as file:
    file.truncate(4096)
    mapped = mmap.mmap(file.fileno(), 4096)
time.sleep(100)
"""


@pytest.mark.skipif(not SHARED.is_dir(), reason=f"no {SHARED} here")
def test_a_program_that_hangs_leaves_no_segment_and_mapped_ones_stay(tmp_path):
    segment = SHARED / f"mpich_shm_{os.getpid():x}_77"
    mapped, other = (segment.with_name(name) for name in (f"{segment.name}9", f"my_{segment.name}"))
    try:
        other.touch()
        with mapped.open("w+b") as file:
            files.remove_segments()
            assert mapped.exists()  # open, as one that is being made
            file.truncate(4096)
            with mmap.mmap(file.fileno(), 4096):
                words = [sys.executable, "-c", MAPS, str(segment)]
                assert Processes().run(words, tmp_path, seconds=0.6, memory=MEMORY).timed_out
        assert [path.exists() for path in (segment, mapped, other)] == [False, True, True]
        files.remove_segments()
        assert not mapped.exists()
    finally:
        for path in (segment, mapped, other):
            path.unlink(missing_ok=True)


def test_one_that_dies_for_want_of_shared_memory_is_told_what_helps(python, monkeypatch):
    monkeypatch.setattr(shutil, "disk_usage", lambda _: USAGE(64 * 10**6, 63 * 10**6, 10**6))
    error = python("import os, signal; os.kill(os.getpid(), signal.SIGBUS)").error("LAMMPS")
    assert type(error) is EngineMemoryError
    words = ("signal SIGBUS", f"{SHARED} holds 64 MB, 1 MB of it free", "fewer workers")
    assert all(word in str(error) for word in words)
