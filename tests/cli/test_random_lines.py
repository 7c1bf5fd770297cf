"""Random command lines: an error in a line or two, a known exit status, and an end in time.

Hundreds in this process with everything long cut short, and some as a user gives them.
"""

import contextlib
import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import harness.workflows
from harness.cli import main
from harness.engines import border, registry
from harness.errors import EngineError, RequestError
from tests.cli.random_lines import line
from tests.published_run import RUN

STATUSES = {0, 1, 2, 3, 130}
LONG = {"verify", "reproduce", "baseline", "releases", "study"}
"""What runs for a minute or more when it is asked rightly."""


@pytest.fixture
def files(tmp_path, monkeypatch):
    """Make the files and folders that random lines name, and go there."""
    here = tmp_path / "here"
    (here / "folder").mkdir(parents=True)
    (here / "folder" / "results.json").write_text(json.dumps(RUN))
    for name in ("file.csv", "file.svg", "file.png"):
        (here / name).write_text("h_over_d,theta_deg\n1,10\n")
    (here / "link").symlink_to("folder")
    (here / "endless").symlink_to("/dev/zero")
    monkeypatch.chdir(here)
    monkeypatch.setenv("HOME", str(tmp_path))
    return here


def wrong(words, status, out, err):
    """Return what is wrong with the end of a command line, or nothing."""
    if status not in STATUSES:
        return f"status {status}"
    if "Traceback" in err or "internal error" in err or "\x1b" in err + out:
        return "a traceback, an internal error or an escape sequence"
    if status == 2 and not 1 <= len(err.strip().splitlines()) <= 3:
        return f"{len(err.splitlines())} lines of error"
    if max(map(len, err.splitlines()), default=0) > 12_000:
        return "an endless line"
    if status == 2 and "--json" in words and "--" not in words:
        told = json.loads(out)
        if told["status"] != 2 or "Value error" in told["error"]:
            return f"an error told as {told}"
    return ""


@pytest.fixture
def quick(monkeypatch, files):  # noqa: ARG001
    """Run a command line in this process: engines in a moment, nothing installed."""
    for name in ("lammps", "liggghts", "yade", "kratos", "esys", "mfix"):
        monkeypatch.setitem(registry.ENGINES, name, "harness.engines.reference:Reference")
    monkeypatch.setattr(border, "MOST_SECONDS", 0.3)
    monkeypatch.setattr(border, "OWN_SECONDS", 0.3)

    def cut(*_, **__):
        raise EngineError("cut short")

    def answered(*_, **__):
        raise RequestError("cut short")

    monkeypatch.setattr(harness.workflows, "verify", cut, raising=False)
    monkeypatch.setattr(harness.workflows, "study", cut, raising=False)
    monkeypatch.setattr("harness.workflows.baseline.verify", cut)
    monkeypatch.setattr("harness.workflows.baseline.verify", cut, raising=False)
    monkeypatch.setattr("harness.reproduction.run.reproduce", cut)
    monkeypatch.setattr("harness.workflows.engine_status.inputs", answered)

    def run(words, capfd):
        monkeypatch.setattr(sys, "argv", ["dem-harness", *words])
        with pytest.raises(SystemExit) as left:
            main()
        said = capfd.readouterr()
        return left.value.code or 0, said.out, said.err

    return run


@pytest.mark.parametrize(
    "first", [0, *(pytest.param(n, marks=pytest.mark.slow) for n in range(100, 600, 100))]
)
def test_a_hundred_random_command_lines(quick, capfd, first):
    found = []
    for seed in range(first, first + 100):
        words = line(random.Random(seed))
        begun = time.monotonic()
        fault = wrong(words, *quick(words, capfd))
        seconds = time.monotonic() - begun
        if fault or seconds > 120:
            found.append(
                f"seed {seed}, {seconds:.0f} s: {fault or 'slow'}: {[w[:60] for w in words]}"
            )
    assert not found, "\n".join(found)


@pytest.fixture(scope="module")
def kernels(tmp_path_factory):
    """Return a folder in which kernels are compiled once for all lines."""
    return tmp_path_factory.mktemp("kernels")


def wait_for_start(process):
    """Wait until the command line handles signals: before it there is Python's own start."""
    for _ in range(1200):
        with contextlib.suppress(OSError, IndexError):
            caught = Path(f"/proc/{process.pid}/status").read_text().split("SigCgt:")[1].split()[0]
            if int(caught, 16) & 1 << signal.SIGTERM - 1:
                return
        if process.poll() is not None:
            return
        time.sleep(0.1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1100, 1150))
def test_a_random_command_line_as_a_user_gives_it(files, kernels, seed):
    words = line(random.Random(seed))
    if words[0] == "baseline":
        words += ["--baseline", str(files / "mine")]
    with subprocess.Popen(
        [sys.executable, "-m", "harness", *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
        env={
            **os.environ,
            "DEM_HARNESS_HOME": str(files.parent / "home"),
            "NUMBA_CACHE_DIR": str(kernels),
        },
    ) as process:
        wait_for_start(process)
        try:
            out, err = process.communicate(timeout=3 if words[0] in LONG else 400)
        except subprocess.TimeoutExpired:
            assert words[0] in LONG
            process.send_signal(signal.SIGINT)
            out, err = process.communicate(timeout=30)
    assert wrong(words, process.returncode, out, err) == ""
