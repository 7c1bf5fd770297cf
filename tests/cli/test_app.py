"""The app: help without heavy imports, signals, closed pipes, and the commands of lists."""

import os
import signal
import subprocess
import sys
import time

import pytest

from harness.cli.app import COMMANDS
from tests.workflows.doubles import start


def test_the_help_lists_every_command(harness):
    text = harness("--help").out
    for name in COMMANDS:
        assert f" {name} " in text
    assert "130 interrupted" in " ".join(text.split())


def test_help_imports_nothing_heavy():
    code = (
        "import sys; sys.argv = ['dem-harness', '--help']\n"
        "from harness.cli import main\n"
        "try: main()\nexcept SystemExit: pass\n"
        "print([m for m in ('numpy', 'pandas', 'pydantic', 'matplotlib', 'numba', 'scipy') "
        "if m in sys.modules], file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == "[]"


@pytest.mark.parametrize(
    ("words", "parts"),
    [(["verfy"], ["verfy", "verify"]), (["run", "bounce", "spare"], ["spare"])],
)
def test_what_is_no_command_is_refused_with_the_help(harness, words, parts):
    text = harness(*words, status=2).err
    for part in (*parts, "--help"):
        assert part in text


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_a_command_with_its_status_and_leaves_nothing(tmp_path, number, status):
    words = ("run", "bounce", "--engine", "tests.workflows.doubles:Sleeping")
    process = start(tmp_path, *words, stderr=subprocess.PIPE)
    deadline = time.monotonic() + 60
    while not (tmp_path / "asleep").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    (tmp_path / "asleep").unlink()
    process.send_signal(number)
    said = process.communicate(timeout=60)[1]
    assert process.returncode == status, said
    assert "nothing half-written is left" in said
    assert not list(tmp_path.iterdir())


def test_a_closed_pipe_is_no_error(tmp_path):
    reader, writer = os.pipe()
    os.close(reader)
    process = start(tmp_path, "cases", stdout=writer, stderr=subprocess.PIPE)
    said = process.communicate(timeout=60)[1]
    os.close(writer)
    assert (process.returncode, said) == (0, "")


def test_cases_and_engines_are_objects_of_lists(answer):
    assert [case["name"] for case in answer("cases")["cases"]] == ["bounce", "wrong"]
    (case,) = answer("cases", "bounce")["cases"]
    assert {"parameters", "presets", "quantities", "engines", "refused_by", "meanings"} <= set(case)
    engines = {e["engine"]: e for e in answer("engines")["engines"]}
    assert engines["good"]["available"]
    assert "make good" in engines["missing"]["reason"]


def test_diff_and_accept_of_runs(answer, harness, tmp_path):
    answer("verify", "--quick", "--engines", "good", "--output", "one")
    answer("verify", "--quick", "--engines", "off", "--output", "two", status=1)
    assert answer("diff", "one", "one")["status"] == 0
    accepted = answer("accept", "one", "--folder", "accepted")
    assert len(accepted["files"]) == 2  # of the engine, and of this package's solvers
    assert (tmp_path / "accepted" / "good" / "1" / "rows.csv").is_file()
    assert "nowhere" in harness("diff", "one", "nowhere", status=2).err
    assert "needs two runs" in harness("diff", "one", status=2).err


def test_the_cache_is_shown_and_cleared(answer, harness):
    answer("run", "bounce", "--engine", "good")
    assert answer("cache")["sorts"]["run"]["entries"] == 1
    assert not answer("cache", "--clear", "--older-than", "1")["sorts"]
    answer("cache", "--clear")
    assert "run" not in answer("cache")["sorts"]
    assert "--older-than -1" in harness("cache", "--older-than", "-1", status=2).err
