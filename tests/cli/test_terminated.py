"""SIGTERM, as batch systems send it, is handled as Ctrl-C is; an engine does not outlive it."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

HANGS = """#!/bin/sh
if [ "$1" = "-h" ]; then
echo "Large-scale Atomic/Molecular Massively Parallel Simulator - 1 Jan 2030"
printf "Installed packages:\\n\\nGRANULAR MOLECULE\\n\\n"
exit 0
fi
echo $$ > "$PIDS/$$"
exec sleep 100
"""


@pytest.fixture
def at_work(tmp_path, monkeypatch):
    """Start a run with a LAMMPS that hangs; return the harness and LAMMPS's process ids."""
    for name in ("pids", "tmp"):
        (tmp_path / name).mkdir()
    monkeypatch.setenv("PIDS", str(tmp_path / "pids"))
    monkeypatch.setenv("TMPDIR", str(tmp_path / "tmp"))
    fake = tmp_path / "lmp"
    fake.write_text(HANGS)
    fake.chmod(0o755)
    process = subprocess.Popen(
        [sys.executable, "-m", "harness", "run", "incline", "--lmp", str(fake)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
    )
    while not list((tmp_path / "pids").iterdir()):
        assert process.poll() is None, process.communicate()
        time.sleep(0.05)
    yield process, [int(path.name) for path in (tmp_path / "pids").iterdir()]
    process.kill()
    process.communicate()


def _running(pid):
    try:
        return "sleep" in Path(f"/proc/{pid}/cmdline").read_text()
    except OSError:
        return False


def test_sigterm_clears_up_and_ends_with_143(at_work, answer):
    process, pids = at_work
    assert all(_running(pid) for pid in pids)
    process.terminate()
    out, said = process.communicate(timeout=30)
    assert (process.returncode, out) == (143, "")
    assert said.splitlines()[-1] == "dem-harness: terminated; nothing half-written is left"
    assert "Traceback" not in said
    assert not any(_running(pid) for pid in pids)
    assert answer("history")["runs"][0]["status"] == 143


def test_after_kill_9_lammps_is_gone_and_the_next_run_removes_the_files(at_work, harness, tmp_path):
    process, pids = at_work
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    deadline = time.monotonic() + 10.0
    while any(_running(pid) for pid in pids) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(_running(pid) for pid in pids)
    assert list((tmp_path / "tmp").iterdir())
    harness("run", "incline", "--lmp", "/bin/true", status=3)
    assert list((tmp_path / "tmp").iterdir()) == []


@pytest.mark.parametrize("words", ['"', "mpirun 'x", "a\\"])
@pytest.mark.parametrize("command", [["critical-angle"], ["run", "incline"], ["verify"]])
def test_a_launcher_with_an_open_quote_is_refused_in_one_line(harness, command, words):
    said = harness(*command, "--mpirun", words, status=2).stderr
    assert said.startswith("dem-harness: --mpirun ")
    assert len(said.splitlines()) == 1
    assert "no closing quotation" in said or "no escaped character" in said
