"""What goes wrong in a run of a code costs only that run, and is named; so is another program."""

import sys
from contextlib import ExitStack
from pathlib import Path

import pytest

from harness.cases.drop import CASE, TEMPLATE, Drop
from harness.engines.output import Output
from harness.engines.process import Limits
from harness.engines.registry import engine_class, fingerprint_of, open_engine
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
from harness.model.law import PLASTIC

PLAYER = Path(__file__).parent / "player.py"
CODES = ("lammps", "liggghts", "yade", "kratos")
GIGABYTE = {"memory": 1024**3}
GOOD, BAD = (
    Drop(contact=PLASTIC, speed=1.0, sideways=v, steps_per_contact=100.0, duration=2.0, every=100)
    for v in (0.5, 13.0)
)


def run_drops(engine, *cases):
    return engine.run([CASE.job(case) for case in cases])


@pytest.fixture
def play(script_file, monkeypatch):
    """Return a function that opens the engine of a code whose program misbehaves."""
    monkeypatch.setenv("PYTHONPATH", "/no/such/folder")
    monkeypatch.setenv("OMPI_COMM_WORLD_RANK", "0")
    with ExitStack() as opened:

        def make(mode, code="lammps", workers=1, **limits):
            words = f'exec "{sys.executable}" -I "{PLAYER}" {code} "{mode}" "$@"\n'
            program = script_file(words, f"player-{code}")
            engine = engine_class(code)(program, workers=workers, limits=Limits(**limits))
            return opened.enter_context(engine)

        yield make


FAULTS = [
    ("SIGKILL", {}, EngineMemoryError, "signal SIGKILL"),
    ("hang", {"seconds": 1.0}, EngineTimeoutError, "within 1 s"),
    ("nan", {}, EngineNaNError, "not numbers"),
    ("not a number", {}, EngineNaNError, "not a number"),
    ("half a row", {}, EngineOutputError, "incomplete series"),
    ("echo, then SIGSEGV", {}, EngineCrashError, "signal SIGSEGV"),
    ("echo, then exceed memory", GIGABYTE, EngineMemoryError, "bad_alloc"),
    ("echo, then exit 3", {}, EngineCrashError, "exit status 3"),
    ("echo, then half a log", {}, EngineOutputError, "without a result"),
    ("refuse", {}, EngineInputError, "Illegal model type"),
    ("error and verdict", {}, EngineLostAtomsError, "in spite of an error: ERROR: Lost atoms"),
]


@pytest.mark.parametrize(("mode", "limits", "error", "words"), FAULTS)
def test_a_run_that_fails_is_named_and_costs_only_itself(play, mode, limits, error, words):
    engine = play(mode, **limits)
    first, failed, last = run_drops(engine, GOOD, BAD, GOOD)
    assert type(failed) is error
    assert words in str(failed)
    assert str(failed).startswith(engine.title)
    assert "\n" not in str(failed)
    head, digest, *rest = failed.log.splitlines()
    assert head.startswith("# lmp -in drop.in")
    assert "13" in head
    assert digest.endswith(engine.script(TEMPLATE).sha256)
    assert rest
    for passed in (first, last):
        assert passed.tables["series"]["x_m"].tolist() == [0.5, 0.5, 0.5]


def test_a_closed_engine_runs_nothing_and_leaves_no_folder(play, tmp_path, monkeypatch):
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    engine = play("")
    assert isinstance(run_drops(engine, GOOD)[0], Output)
    engine.close()
    (error,) = run_drops(engine, GOOD)
    assert isinstance(error, EngineCrashError)
    assert "closed" in str(error)
    assert engine.fingerprint() is None  # a wrapper hides what it runs
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize("code", CODES)
def test_a_version_cannot_steer_a_terminal(play, code):
    assert "\033" not in play("version 1\033[31m", code).identify().engine_version


NOT_IT = {"talks": "echo I am a teapot\n", "fails": "exit 1\n", "dies": "kill -SEGV $$\n"}


@pytest.mark.parametrize(
    ("code", "way"),
    [*(("lammps", way) for way in NOT_IT), *((code, "no program") for code in CODES)],
)
def test_a_program_that_is_another_is_refused_by_name(script_file, code, way):
    program = Path(script_file(NOT_IT.get(way, ""), f"not-{code}"))
    if way == "no program":
        program.write_bytes(b"\x7fELF nonsense")
    with (
        engine_class(code)(program=str(program)) as engine,
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


@pytest.mark.parametrize("code", ["liggghts", "yade"])
def test_a_code_that_is_not_installed_is_missing_with_the_remedy(monkeypatch, code):
    monkeypatch.setenv("PATH", "/nowhere")
    monkeypatch.setattr("sys.executable", "/nowhere/python")
    kind = engine_class(code)
    with pytest.raises(EngineMissingError) as caught:
        kind()
    assert kind.traits.install_hint in str(caught.value)
    assert fingerprint_of(code, {}) is None  # verify tests nothing of it, and goes on


def test_liggghts_without_the_model_is_refused_with_the_model_named(script_file):
    said = "LIGGGHTS (Version LIGGGHTS-PUBLIC 3.8.0, compiled 2022)\n\n hertz  hooke\n"
    program = script_file(f"cat <<END\n{said}END\n", "liggghts")
    with (
        engine_class("liggghts")(program=program) as engine,
        pytest.raises(EngineMissingError, match="without the contact model hooke/stiffness"),
    ):
        engine.identify()
