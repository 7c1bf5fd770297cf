"""The options of other engines: where they go, and what they refuse."""

import json
import sys

import pytest
from harness.cli.cached_engines import Chosen

from harness.cli import main, verify
from harness.cli.options import programs_of
from harness.cli.tower import Solver
from harness.engines import registry
from harness.errors import RequestError
from harness.store.entries import Entries
from harness.store.history import History
from harness.workflows import status
from tests import engine_doubles as doubles

COMMANDS = ("verify", "critical-angle", "tower", "engines")
OPTIONS = ("--liggghts", "--yade", "--kratos", "--esys", "--mfix")
NONE = dict.fromkeys(("liggghts", "yade", "kratos", "esys", "mfix"))


@pytest.fixture
def as_yade(monkeypatch):
    """Stand in for Yade: the reference DEM under its name, with towers."""
    monkeypatch.setattr(doubles.Clamped, "name", "yade")
    monkeypatch.setitem(registry.ENGINES, "yade", "tests.engine_doubles:Clamped")


@pytest.fixture
def command(monkeypatch, capsys, tmp_path):
    """Run a command in this process, where the stand-ins are registered."""
    monkeypatch.chdir(tmp_path)

    def run(*words, status=0):
        monkeypatch.setattr(sys, "argv", ["dem-harness", *words])
        with pytest.raises(SystemExit) as left:
            main()
        said = capsys.readouterr()
        assert (left.value.code or 0) == status, said.err
        return said

    return run


@pytest.mark.parametrize("name", COMMANDS)
def test_every_option_is_in_one_panel_of_the_help(command, monkeypatch, name):
    monkeypatch.setenv("COLUMNS", "200")
    said = command(name, "--help").out
    _, _, panel = said.partition("Other engines")
    for option in OPTIONS:
        assert option in panel
    assert "PYTHON" in panel


def test_every_engine_that_states_towers_is_a_solver():
    named = {solver.value for solver in Solver}
    for name in registry.ENGINES:
        if registry.engine_class(name).states_towers:
            assert name in named


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("critical-angle", "--yade", "sh"), "--yade 'sh': goes with --engine yade only"),
        (("tower", "--mfix", "sh"), "--mfix 'sh': goes with --solver mfix only"),
        (("verify", "--esys", "sh"), "--esys 'sh': goes with --engines esys only"),
        (("verify", "--engines", "lammps", "--yade", "sh"), "--yade 'sh': goes with --engines"),
        (("verify", "--engines", "nobody"), "--engines 'nobody' is not known: must be all, or"),
        (("verify", "--engines", ","), "names no engine"),
        (("tower", "--solver", "nobody"), "nobody"),
        (("tower", "--solver", "exact", "--lmp", "sh"), "--lmp: goes with --solver lammps only"),
        (("critical-angle", "--engine", "yade", "--yade", "/nowhere/yade"), "no such executable"),
    ],
)
@pytest.mark.usefixtures("as_yade")
def test_a_wrong_request_ends_with_status_2_before_any_work(command, tmp_path, words, said):
    done = command(*words, status=2)
    assert done.out == ""
    assert said in done.err
    assert list(tmp_path.iterdir()) == []


def test_programs_go_by_the_name_of_their_engine():
    assert programs_of(["yade"], **{**NONE, "yade": "sh"}) == {"yade": "sh"}
    assert programs_of(None, **{**NONE, "mfix": "sh", "esys": "sh"}) == {
        "mfix": "sh",
        "esys": "sh",
    }
    assert programs_of(["lammps"], **NONE) == {}
    with pytest.raises(RequestError, match="no such executable"):
        programs_of(None, **{**NONE, "mfix": "/nowhere/mfix"})


@pytest.mark.usefixtures("as_yade")
def test_an_engine_is_opened_with_its_program(command, monkeypatch):
    opened = []

    def init(self, program=None):
        opened.append(program)
        doubles.Reference.__init__(self)

    monkeypatch.setattr(doubles.Clamped, "__init__", init)
    words = ("--contact", "plastic", "--stiffness", "1e5", "--json")
    record = json.loads(command("critical-angle", "--engine", "yade", "--yade", "sh", *words).out)
    assert opened == ["sh"]
    assert record["critical_angle_deg"] == pytest.approx(10.2, abs=0.01)
    command("tower", "--solver", "yade", "--yade", "sh", "--law", "overlap", "--json")
    assert opened == ["sh", "sh"]


@pytest.mark.usefixtures("as_yade")
def test_a_tower_in_another_engine_also_covers_a_longer_window(command):
    words = ("--law", "overlap", "--stiffness", "1e5", "--duration", "0.5", "--json")
    record = json.loads(command("tower", "--solver", "yade", *words).out)
    assert record["solver"] == "yade"
    assert record["impulse_Ns"] == pytest.approx(4.09842, rel=1e-5)
    assert record["peak_force_N"] == pytest.approx(642.342, rel=1e-4)


@pytest.fixture
def short(monkeypatch):
    """Leave out of a verification what is not about other engines, and engines that are here."""
    from harness.workflows.verification import run

    for name in set(registry.ENGINES) - {"lammps", "reference", "yade"}:
        monkeypatch.delitem(registry.ENGINES, name)

    for part in ("_both", "reference_checks", "chain_checks", "theory_checks"):
        monkeypatch.setattr(run, part, lambda *_: [])
    monkeypatch.setattr(doubles.Newer, "name", "lammps")
    monkeypatch.setattr(doubles.Newer, "traits", doubles.TRAITS)
    monkeypatch.setitem(registry.ENGINES, "lammps", "tests.engine_doubles:Newer")
    monkeypatch.setattr(verify, "_key", lambda asked: None if asked.engines else "ab" * 32)


QUICK = ("verify", "--quick", "--no-baseline", "--engine", "reference", "--output", "run")


@pytest.mark.usefixtures("as_yade", "short")
def test_verify_compares_the_engines_that_are_asked_for(command, home, tmp_path):
    done = command(*QUICK, "--engines", "yade", "--json")
    record = json.loads(done.out)
    assert record["status"] == 0
    assert record["cached"] is False
    standings = {d["engine"]: d["standing"] for d in record["engines"]["declared"]}
    assert standings == dict.fromkeys(("lammps", "reference", "yade"), "qualified")
    assert "engine yade: 3 of 3" in done.err
    on_disk = json.loads((tmp_path / "run" / "results.json").read_text())
    assert on_disk["engines"]["declared"] == record["engines"]["declared"]
    junit = (tmp_path / "run" / "junit.xml").read_text()
    assert "yade: critical angle, plastic contact" in junit
    with History(home / "history.sqlite") as history:
        named = {row["name"] for row in history.rows("select name from quantity")}
    assert "yade: critical angle, plastic contact, k = 1e+06 N/m, 100 steps" in named


@pytest.mark.usefixtures("as_yade", "short")
@pytest.mark.parametrize(
    ("kind", "engines", "status"),
    [
        ("Missing", "yade", 3),
        ("Missing", "all", 0),
        ("Crashing", "yade", 3),
        ("Crashing", "all", 1),
        ("Undamped", "yade", 1),
    ],
)
def test_exit_status(command, monkeypatch, kind, engines, status):
    monkeypatch.setattr(getattr(doubles, kind), "name", "yade")
    monkeypatch.setitem(registry.ENGINES, "yade", f"tests.engine_doubles:{kind}")
    record = json.loads(command(*QUICK, "--engines", engines, "--json", status=status).out)
    assert record["status"] == status
    assert bool(record["engine_errors"]) is (status == 3)


def test_a_verification_with_engines_is_not_kept_as_a_whole(tmp_path):
    asked = verify._Asked("quick", Chosen("lammps"), None, None, False, "all")
    assert verify._key(asked) is None
    assert verify._kept(Entries(tmp_path / "cache"), None, tmp_path / "run") is None


def test_engines_are_listed_with_what_they_declare(monkeypatch, command):
    for name, kind in (("twin", "Twin"), ("missing", "Missing")):
        monkeypatch.setitem(registry.ENGINES, name, f"tests.engine_doubles:{kind}")
    lines = command("engines").out.splitlines()
    (missing,) = [line for line in lines if line.startswith("missing")]
    assert "missing: missing: no library of that name; to get it: apt install it" in missing
    (twin,) = [line for line in lines if line.startswith("twin")]
    assert "compiled" in twin
    rows = {row["engine"]: row for row in json.loads(command("engines", "--json").out)["engines"]}
    assert rows.keys() >= {"lammps", "reference", "twin", "missing"}
    assert rows["twin"]["lineage"] == "LAMMPS"
    assert rows["twin"]["tails"] == ["attractive", "clipped"]
    assert rows["twin"]["effective_masses"] == ["full", "half"]
    assert (rows["twin"]["spring"], rows["twin"]["digits"]) == ("linear", 15)
    assert rows["twin"]["integrator"] == "velocity-verlet"
    assert (rows["missing"]["available"], rows["missing"]["install_hint"]) == (
        False,
        "apt install it",
    )


def test_a_program_that_is_not_there_is_a_missing_engine(monkeypatch):
    def init(self, program=None):
        from harness.engines.programs import find_program

        find_program("twin", program or "twin")
        doubles.Reference.__init__(self)

    monkeypatch.setattr(doubles.Twin, "__init__", init)
    monkeypatch.setitem(registry.ENGINES, "twin", "tests.engine_doubles:Twin")
    (twin,) = [s for s in status.engines(programs={"twin": "/no/twin"}) if s.engine == "twin"]
    assert twin.provenance is None
    assert "--twin '/no/twin': no such executable" in twin.reason
