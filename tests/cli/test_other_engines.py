"""The options that choose engines: where they go, and what they refuse."""

import json
import os
import shutil

import pytest

from harness.cli.engine_options import EngineOptions, ProgramOptions
from harness.cli.verify import VerifyOptions, _kept, _key
from harness.engines import registry
from harness.engines.registry import named_values
from harness.errors import RequestError
from harness.store.entries import Entries
from tests import engine_doubles as doubles

OPENED = []


class Known(doubles.Clamped):
    """The reference DEM under another code's name; keeps what it was opened with."""

    name = "yade"

    def __init__(self, program: str | None = None, workers: int | None = None) -> None:
        OPENED.append((program, workers))
        super().__init__()


@pytest.fixture
def as_yade(monkeypatch):
    OPENED.clear()
    monkeypatch.setitem(registry.ENGINES, "yade", f"{__name__}:Known")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("critical-angle", "--program", "yade=sh"), "--program yade=sh: goes with --engine yade"),
        (("tower", "--program", "mfix=sh"), "--program mfix=sh: goes with --solver mfix only"),
        (("verify", "--program", "yade=sh"), "--program yade=sh: goes with --engines yade only"),
        (("tower", "--engine-option", "mfix.x=1"), "--engine-option mfix: goes with --solver mfix"),
        (("run", "drop", "--program", "=sh"), "--program '=sh': must be NAME=VALUE"),
        (("run", "drop", "--program", "yade="), "--program 'yade=': must be NAME=VALUE"),
        (("verify", "--engines", "nobody"), "--engines 'nobody' is not known: must be all, or"),
        (("verify", "--engines", ","), "names no engine"),
        (("critical-angle", "--mpirun", ""), "--mpirun '': must be a command"),
        (
            ("critical-angle", "--engine", "yade", "--program", "yade=/nowhere/yade"),
            "--program yade '/nowhere/yade': no such executable",
        ),
        (
            ("critical-angle", "--engine", "yade", "--engine-option", "yade.workers=many"),
            "yade.workers",
        ),
        (("critical-angle", "--engine", "no.such:Engine"), "no.such:Engine"),
    ],
)
@pytest.mark.usefixtures("as_yade")
def test_a_wrong_request_ends_with_status_2_before_any_work(command, tmp_path, words, said):
    done = command(*words, status=2)
    assert done.out == ""
    assert said in done.err
    assert list(tmp_path.iterdir()) == []


def test_pairs_are_read_once_each():
    assert named_values(["a=1=2", "b.c= x"], "--set") == {"a": "1=2", "b.c": " x"}
    with pytest.raises(RequestError, match="--set 'a=2': a is given twice"):
        named_values(["a=1", "a=2"], "--set")


def test_programs_and_options_go_by_the_name_of_their_engine():
    given = ProgramOptions(
        program=["yade=sh", "my.mod:Dem=/x"], engine_option=["my.mod:Dem.step=3", "yade.workers=1"]
    )
    assert given.opening("yade")["program"] == "sh"
    assert given.opening("yade")["options"] == {"workers": "1"}
    assert given.opening("my.mod:Dem")["options"] == {"step": "3"}
    assert given.opening("mfix")["program"] is None


@pytest.mark.usefixtures("as_yade")
def test_an_engine_is_opened_with_its_program_and_options(command):
    words = ("--contact", "plastic", "--stiffness", "1e5", "--json")
    chosen = ("--program", "yade=sh", "--engine-option", "yade.workers=3")
    record = json.loads(command("critical-angle", "--engine", "yade", *chosen, *words).out)
    assert OPENED == [("sh", 3)]
    assert record["critical_angle_deg"] == pytest.approx(10.2, abs=0.01)
    assert record["closed_form_deg"] == pytest.approx(10.2078187)


def test_an_engine_of_ones_own_runs_by_module_and_class(command):
    words = ("--set", "contact.tail=clipped", "--json")
    record = json.loads(command("run", "drop", "--engine", f"{__name__}:Known", *words).out)
    assert record["engine"] == "yade"
    assert record["quantities"]["end_speed_m_per_s"]["reference_kind"] == "closed form"


def test_a_verification_with_engines_is_not_kept_as_a_whole(tmp_path):
    assert _key(VerifyOptions(quick=True, engines="all"), EngineOptions()) is None
    assert _kept(Entries(tmp_path / "cache"), None, tmp_path / "run") is None


@pytest.mark.slow
@pytest.mark.live
@pytest.mark.parametrize("name", ["yade", "kratos", "mfix"])
def test_a_second_command_runs_nothing(command, tmp_path, name):
    """Neither the run nor the qualification of another code, which take it most of a minute."""
    words = ["run", "drop", "--engine", name, "--cache", str(tmp_path / "cache"), "--json"]
    tail, mass = ("clipped", "full") if name != "mfix" else ("attractive", "half")
    words += ["--set", f"contact.tail={tail}", "--set", f"contact.effective_mass={mass}"]
    if name == "mfix":
        program = os.environ.get("DEM_HARNESS_MFIX")
        if program is None:
            pytest.skip("no MFiX here: DEM_HARNESS_MFIX does not name its solver")
        words += ["--program", f"mfix={program}"]
    elif name == "kratos":
        pytest.importorskip("KratosMultiphysics.DEMApplication")
    elif shutil.which(name) is None:
        pytest.skip(f"no {name} on PATH")
    first, second = (json.loads(command(*words).out) for _ in range(2))
    assert first["qualified"]
    assert first["engine_runs"] > 5
    assert (first["engine_runs_from_cache"], second["engine_runs"]) == (0, 0)
    assert second["engine_runs_from_cache"] == first["engine_runs"]
    assert second["quantities"] == first["quantities"]
