"""Progress: told to a function, drawn in a terminal, and nowhere else."""

import inspect
import os
import pty
import re
import select
import subprocess
import sys
import time

import pytest

from harness import workflows
from harness.cases.incline.system import Incline
from harness.cases.tower.run import Options
from harness.engines.reference import Reference
from harness.engines.registry import open_engine
from harness.parameters.tower import Tower
from harness.reproduction import reproduce
from harness.workflows import progress as module

LONG = [
    "compare_with_baseline",
    "critical_angle",
    "critical_angles",
    "engines",
    "extrapolated_critical_angle",
    "impulse_angles",
    "impulse_table",
    "releases",
    "reproduce",
    "run",
    "tower",
    "verify",
]


@pytest.mark.parametrize("name", LONG)
def test_every_long_verb_takes_a_progress(name):
    verb = reproduce if name == "reproduce" else getattr(workflows, name)
    taken = set(inspect.signature(verb).parameters)
    if verb is workflows.tower:  # its keywords are one class
        taken |= set(Options.__annotations__)
    assert "progress" in taken


def stages(verb):
    told = []
    verb(lambda *one: told.append(one))
    assert told
    for stage in {one[0] for one in told}:
        done = [one[1:] for one in told if one[0] == stage]
        assert [d for d, _ in done] == sorted(d for d, _ in done)
        assert all(0 <= d <= total for d, total in done)
    return told


def test_verbs_tell_how_far_they_are():
    assert stages(lambda told: workflows.tower(Tower(height=2), progress=told))
    table = {"heights": (2, 3), "stiffnesses": (1e6,), "speeds": (2.0,)}
    assert stages(lambda told: workflows.impulse_angles(progress=told, **table))[-1] == (
        "towers", 6, 6,
    )  # fmt: skip
    with Reference() as engine:
        found = stages(
            lambda told: workflows.critical_angle(
                Incline(stiffness=1e5), engine=engine, progress=told
            )
        )
        assert found[0][:2] == ("runs, passage", 0)
        assert stages(lambda told: workflows.run("drop", engine=engine, progress=told))
    assert stages(lambda told: workflows.engines(programs={}, progress=told))[-1][0] == "engines"


def in_terminal(*words, tmp_path, **env):
    """Run a command with standard error on a terminal; return what it shows there, and stdout."""
    main, other = pty.openpty()
    with subprocess.Popen(
        [sys.executable, "-m", "harness", *words],
        stdout=subprocess.PIPE,
        stderr=other,
        cwd=tmp_path,
        env={**os.environ, "TERM": "xterm", "COLUMNS": "100", **env},
    ) as process:
        os.close(other)
        shown, deadline = b"", time.monotonic() + 100
        while time.monotonic() < deadline and select.select([main], [], [], 60)[0]:
            try:
                part = os.read(main, 65536)
            except OSError:
                break
            shown += part
        out = process.stdout.read().decode()
    os.close(main)
    assert process.returncode == 0, shown
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", shown.decode()), out


@pytest.mark.slow
def test_a_terminal_shows_the_stage_the_time_and_that_kernels_are_compiled(tmp_path):
    shown, out = in_terminal(
        "tower", "--height", "2", tmp_path=tmp_path, NUMBA_CACHE_DIR=str(tmp_path / "empty")
    )
    assert "tower: compiling, or loading, kernels" in shown
    assert re.search(r"0:00:\d\d", shown)
    assert "impulse_Ns" in out


def test_json_and_what_is_no_terminal_show_nothing(tmp_path, commands):
    shown, out = in_terminal("impulse", "--heights", "1-9", "--json", tmp_path=tmp_path)
    assert shown == ""
    assert out.startswith("{")
    done = commands.run(["impulse", "--heights", "1-9"], tmp_path, 120)
    assert (done.returncode, done.stderr) == (0, "")


def test_what_is_done_at_once_draws_nothing(tmp_path):
    assert in_terminal("theory", tmp_path=tmp_path)[0] == ""


def test_bars_that_end_at_once_end_cleanly(monkeypatch):
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    monkeypatch.setattr(module, "DELAY", 0.0)
    with module.progress_bars("verb") as told:
        told("stage", 0, 2)
        time.sleep(0.3)
        told("stage", 2, 2)
    with pytest.raises(KeyboardInterrupt), module.progress_bars("verb"):
        raise KeyboardInterrupt


def test_a_log_says_which_stages_are_over_and_how_far_others_are(monkeypatch, capsys):
    now = [0.0]
    monkeypatch.setattr(module.time, "monotonic", lambda: now[0])
    with module.progress_bars("verify") as told:
        told("drop", 1, 1)  # over at once: no line
        for seconds, done in ((1.0, 0), (10.0, 1), (20.0, 2), (45.0, 3), (50.0, 4), (51.0, 4)):
            now[0] = seconds
            told("oblique", done, 4)
    assert capsys.readouterr().err.splitlines() == [
        "verify: oblique, 3 of 4, 45 s",
        "verify: oblique, 4 of 4, 50 s",
    ]
    with module.progress_bars("verify", quiet=True) as told:
        now[0] = 1000.0
        told("oblique", 4, 4)
    assert capsys.readouterr().err == ""


@pytest.mark.usefixtures("registered")
def test_a_verification_says_which_case_is_over():
    told = []
    workflows.verify(
        "quick", cases="line", engine=open_engine("toy"), baseline=False,
        progress=lambda *one: told.append(one),
    )  # fmt: skip
    for stage in ("line, toy", "line, own solvers"):
        assert [one[1:] for one in told if one[0] == stage] == [(0, 1), (1, 1)]
