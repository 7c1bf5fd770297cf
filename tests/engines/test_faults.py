"""What goes wrong in a run of any code costs only that run, and is named."""

import os
import sys
import time
from contextlib import ExitStack
from pathlib import Path

import pytest

from harness.cases.drop.case import CASE
from harness.cases.drop.system import TEMPLATE, Drop
from harness.engines.output import Output
from harness.engines.process import Limits
from harness.engines.registry import engine_class, open_engine
from harness.errors import (
    EngineCrashError,
    EngineInputError,
    EngineLostAtomsError,
    EngineMemoryError,
    EngineMissingError,
    EngineNaNError,
    EngineOutputError,
    EngineTimeoutError,
    RequestError,
)
from harness.model.contact import PLASTIC

PLAYER = Path(__file__).parent / "player.py"
LANGUAGE = ("lammps", "liggghts")
PYTHON = ("yade", "kratos")
CODES = (*LANGUAGE, *PYTHON)
FIRST = ("lammps",)  # whose script of the drop is run; scenes are in test_scene_files

GIGABYTE = 1024**3
GOOD, BAD = (
    Drop(contact=PLASTIC, speed=1.0, sideways=v, steps_per_contact=100.0, duration=2.0, every=100)
    for v in (0.5, 13.0)
)


def run_drops(engine, cases):
    return engine.run([CASE.job(case) for case in cases])


@pytest.fixture
def play(script_file, monkeypatch):
    """Return a function that opens the engine of a code whose program misbehaves."""
    monkeypatch.setenv("PYTHONPATH", "/no/such/folder")
    monkeypatch.setenv("OMPI_COMM_WORLD_RANK", "0")
    with ExitStack() as opened:

        def make(code, mode, workers=1, **limits):
            words = f'exec "{sys.executable}" -I "{PLAYER}" {code} "{mode}" "$@"\n'
            program = script_file(words, f"player-{code}")
            engine = engine_class(code)(program, workers=workers, limits=Limits(**limits))
            return opened.enter_context(engine)

        yield make


FAULTS = [
    ("SIGSEGV", {}, EngineCrashError, "SIGSEGV"),
    ("SIGKILL", {}, EngineMemoryError, "signal SIGKILL"),
    ("exit 3", {}, EngineCrashError, "exit status 3"),
    ("hang", {"seconds": 1.0}, EngineTimeoutError, "within 1 s"),
    ("exceed memory", {"memory": GIGABYTE}, EngineMemoryError, "memory"),
    ("exit 0", {}, EngineOutputError, "without a result"),
    ("half a log", {}, EngineOutputError, "without a result"),
    ("nan", {}, EngineNaNError, "not numbers"),
    ("not a number", {}, EngineNaNError, "not a number"),
    ("half a series", {}, EngineOutputError, "cut in its last row"),
    ("half a row", {}, EngineOutputError, "incomplete series"),
]
OWN = {
    "lammps": [
        ("echo, then SIGSEGV", {}, EngineCrashError, "signal SIGSEGV"),
        ("echo, then SIGKILL", {}, EngineMemoryError, "signal SIGKILL"),
        ("echo, then exceed memory", {"memory": GIGABYTE}, EngineMemoryError, "bad_alloc"),
        ("echo, then exit 3", {}, EngineCrashError, "exit status 3"),
        ("echo, then exit 0", {}, EngineOutputError, "without a result"),
        ("echo, then half a log", {}, EngineOutputError, "without a result"),
    ],
}
for code in FIRST:
    OWN[code] = [
        *OWN.get(code, ()),
        ("refuse", {}, EngineInputError, "Illegal model type"),
        ("error and verdict", {}, EngineLostAtomsError, "in spite of an error: ERROR: Lost atoms"),
    ]


@pytest.mark.parametrize(
    ("code", "mode", "limits", "error", "words"),
    [(code, *fault) for code in FIRST for fault in (*FAULTS, *OWN[code])],
)
def test_a_run_that_fails_is_named_and_costs_only_itself(play, code, mode, limits, error, words):
    engine = play(code, mode, **limits)
    first, failed, last = run_drops(engine, [GOOD, BAD, GOOD])
    assert type(failed) is error
    assert words in str(failed)
    assert engine.title in str(failed)
    assert "\n" not in str(failed)
    assert "Deregistering" not in str(failed)
    head, digest, *rest = failed.log.splitlines()
    assert head.startswith("# ")
    assert "13" in head
    assert digest.endswith(engine.script(TEMPLATE).sha256)
    assert rest
    for passed in (first, last):
        assert isinstance(passed, Output)
        assert passed.tables["series"]["x_m"].tolist() == [0.5, 0.5, 0.5]


@pytest.mark.parametrize(
    ("code", "mode", "words"),
    [(code, "late exit 139", "signal SIGSEGV") for code in FIRST]
    + [(code, "late SIGKILL", "signal SIGKILL") for code in FIRST],
)
def test_a_process_that_fails_after_its_last_result_takes_the_last_with_it(play, code, mode, words):
    first, failed = run_drops(play(code, mode), [GOOD, GOOD])
    assert isinstance(first, Output)
    assert type(failed) is EngineCrashError
    assert words in str(failed)
    assert str(failed).endswith(", after its results were written")
    assert "RESULT verdict" in failed.log


@pytest.mark.parametrize("code", FIRST)
def test_runs_are_shared_out_and_come_back_in_order(play, code):
    engine = play(code, "SIGSEGV", workers=2)
    speeds = [0.25, 13.0, 0.5, 0.75, 13.0]
    cases = [GOOD.replace(sideways=speed) for speed in speeds]
    for speed, outcome in zip(speeds, run_drops(engine, cases), strict=True):
        assert isinstance(outcome, EngineCrashError if speed == 13.0 else Output)
        assert speed == 13.0 or outcome.tables["series"]["x_m"][0] == speed


@pytest.mark.parametrize("code", FIRST)
def test_a_hang_ends_at_the_limit_and_leaves_no_process(play, tmp_path, code):
    start = time.monotonic()
    (error,) = run_drops(play(code, "hang", seconds=0.3), [BAD])
    assert isinstance(error, EngineTimeoutError)
    assert time.monotonic() - start < 10.0
    commands = (path.read_bytes() for path in Path("/proc").glob("[0-9]*/cmdline"))
    assert not any(str(tmp_path).encode() in command for command in commands)


@pytest.mark.parametrize("code", FIRST)
def test_a_closed_engine_runs_nothing_and_leaves_no_folder(play, tmp_path, monkeypatch, code):
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    engine = play(code, "")
    assert isinstance(run_drops(engine, [GOOD])[0], Output)
    assert list(folder.iterdir()) == []
    engine.close()
    (error,) = run_drops(engine, [GOOD])
    assert isinstance(error, EngineCrashError)
    assert "closed" in str(error)
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize("code", FIRST)
def test_provenance_and_log_say_what_ran(play, tmp_path, code):
    engine = play(code, "version 8.7")
    (run,) = run_drops(engine, [GOOD])
    who, script = run.provenance, engine.script(TEMPLATE)
    assert (who.engine, who.executable) == (code, str(tmp_path / f"player-{code}"))
    assert who.engine_version.endswith("8.7")
    assert (who.script, who.script_sha256) == (script.name, script.sha256)
    assert who.integrator == engine.traits.integrator
    log = engine.logs()[script.name]
    assert log.splitlines()[0] == f"# {engine.command_line(engine.task(CASE.job(GOOD)))}"
    assert who.script_sha256 in log
    assert log.rstrip().endswith("RESULT verdict = finished")
    assert engine.fingerprint() is None  # a wrapper hides what it runs


@pytest.mark.parametrize("code", CODES)
def test_a_version_cannot_steer_a_terminal(play, code):
    assert "\033" not in play(code, "version 1\033[31m").identify().engine_version


NOT_IT = {"talks": "echo I am a teapot\n", "fails": "exit 1\n", "dies": "kill -SEGV $$\n"}


@pytest.mark.parametrize("code", CODES)
@pytest.mark.parametrize("way", [*NOT_IT, "no program"])
def test_a_program_that_is_another_is_refused_by_name(script_file, tmp_path, code, way):
    if way == "no program":
        path = tmp_path / f"not-{code}"
        path.write_bytes(b"\x7fELF nonsense")
        path.chmod(0o755)
        program = str(path)
    else:
        program = script_file(NOT_IT[way], f"not-{code}")
    with (
        engine_class(code)(program=program) as engine,
        pytest.raises(EngineMissingError, match=f"not-{code}") as caught,
    ):
        engine.identify()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("code", CODES)
def test_a_program_that_is_not_there_is_a_wrong_request(code, tmp_path):
    locked = tmp_path / "program"
    locked.write_text("", encoding="utf-8")
    for path in ("/no/such/program", str(locked)):
        option = "lmp" if code == "lammps" else f"program {code}="
        with pytest.raises(RequestError, match=f"^--{option} ?'{path}': no such executable"):
            open_engine(code, program=path)


@pytest.mark.parametrize("code", [code for code in CODES if code not in ("lammps", "kratos")])
def test_a_code_that_is_not_installed_is_missing_with_the_remedy(monkeypatch, code):
    monkeypatch.setenv("PATH", "/nowhere")
    monkeypatch.setattr("sys.executable", "/nowhere/python")
    kind = engine_class(code)
    with pytest.raises(EngineMissingError) as caught:
        kind()
    assert kind.traits.install_hint in str(caught.value)


def test_the_environment_of_yade_keeps_what_is_not_foreign(play, tmp_path, monkeypatch):
    foreign = {"PYTHONPATH": "x", "OMPI_COMM_WORLD_RANK": "1"}
    monkeypatch.setattr(os, "environ", {"PATH": "/bin", "HOME": "/home/me", **foreign})
    assert play("yade", "").environment(tmp_path) == {"PATH": "/bin", "HOME": str(tmp_path)}


def test_liggghts_without_the_model_is_refused_with_the_model_named(script_file):
    said = "LIGGGHTS (Version LIGGGHTS-PUBLIC 3.8.0, compiled 2022)\n\n hertz  hooke\n"
    program = script_file(f"cat <<END\n{said}END\n", "liggghts")
    with (
        engine_class("liggghts")(program=program) as engine,
        pytest.raises(EngineMissingError, match="without the contact model hooke/stiffness"),
    ):
        engine.identify()
