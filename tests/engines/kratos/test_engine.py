"""The engine with a program that passes for a Python with Kratos: what goes wrong costs one run."""

from pathlib import Path

import pytest

from harness.cases.contact import motion as contacts
from harness.cases.drop import case as drops
from harness.cases.drop.case import Drop, DropRun, run_drops
from harness.cases.incline import system as inclines
from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import InclineRun, Motion
from harness.cases.tower import system as towers
from harness.cases.tower.run import run_towers
from harness.engines.kratos.engine import Kratos
from harness.engines.registry import open_engine
from harness.errors import (
    EngineCrashError,
    EngineInputError,
    EngineMemoryError,
    EngineMissingError,
    EngineNaNError,
    EngineOutputError,
    EngineTimeoutError,
    RequestError,
)
from harness.observables.tower import TowerRun
from harness.parameters.law import SOURCE
from harness.parameters.tower import Tower

FAKE = Path(__file__).parent / "fake_kratos.py"
RECORDED = Path(__file__).parent / "recorded"
GIGABYTE = 1024**3
INPUTS = Kratos.inputs([inclines.TEMPLATE, drops.TEMPLATE, towers.TEMPLATE, contacts.TEMPLATE])


@pytest.fixture
def fake(faked):
    """Return a function that makes an engine of the fake in one of its modes."""
    return lambda mode="", **limits: faked(Kratos, (FAKE, mode, RECORDED), **limits)


@pytest.mark.parametrize(
    ("mode", "limits", "error", "said"),
    [
        ("segfault", {}, EngineCrashError, "SIGSEGV"),
        ("exit", {}, EngineCrashError, "half the search tolerance"),
        ("refuse", {}, EngineInputError, "YOUNG_MODULUS should be presented"),
        ("overflow", {}, EngineNaNError, "a velocity is not a number"),
        ("hang", {"seconds": 2.0}, EngineTimeoutError, "within 2 s"),
        ("exceed memory", {"memory": GIGABYTE}, EngineMemoryError, "memory"),
        ("nan", {}, EngineNaNError, "stage = nan"),
        ("half a series", {}, EngineOutputError, "cut in its last row"),
        ("no end", {}, EngineOutputError, "undecided"),
        ("half a log", {}, EngineOutputError, "without a result"),
        ("ends", {}, EngineOutputError, "without a result"),
    ],
)
def test_each_way_to_fail_has_its_error_and_costs_only_its_own_run(
    fake, fails_alone, recorded_incline, mode, limits, error, said
):
    good, bad = recorded_incline, recorded_incline.replace(angle=13.0)
    passed, failed = fails_alone(fake(mode, **limits), good, bad, error, said, 50)
    for result in failed:
        assert "Deregistering" not in str(result)
        head, digest, *rest = result.log.splitlines()
        assert head.startswith("# python incline.py x=[-0.0")
        assert " gravity_x=2.2067" in head
        assert digest.endswith(Kratos.script(inclines.TEMPLATE).sha256)
        assert rest
    assert {result.motion for result in passed} == {Motion.MOVES_ON}


def test_what_was_finished_does_not_count_where_the_process_died_at_its_end(fake, recorded_incline):
    (run,) = run_inclines(fake("killed after its work"), [recorded_incline], "passage")
    assert type(run) is EngineCrashError
    assert "signal SIGKILL, after its results were written" in str(run)


def test_all_kinds_of_runs_carry_who_made_them(
    fake, recorded_drop, recorded_incline, recorded_tower
):
    engine = fake()
    (drop,) = run_drops(engine, [recorded_drop])
    (incline,) = run_inclines(engine, [recorded_incline], "passage", every=50)
    (tower,) = run_towers(engine, [recorded_tower], 3.0, steps_per_contact=100.0, samples=60)
    kinds = zip((drop, incline, tower), (DropRun, InclineRun, TowerRun), strict=True)
    assert all(isinstance(run, kind) for run, kind in kinds)
    assert incline.trajectory.x_m.size > 10
    assert drop.provenance.engine_version == "10.9.1"
    assert incline.provenance.script == "incline.py"
    assert tower.provenance.integrator == "velocity-verlet"
    assert set(engine.logs()) == {"drop.py", "incline.py", "tower.py"}
    assert "RESULT verdict = finished" in engine.logs()["incline.py"]


def test_a_python_without_kratos_is_missing_and_no_program_is_a_wrong_request(fake):
    engine = fake("no Kratos")
    for ask in (engine.identify, lambda: run_drops(engine, [Drop(contact=CLIPPED_SOURCE)])):
        with pytest.raises(
            EngineMissingError, match=r"has no Kratos .*libKratosDEMCore.*KratosDEMApplication"
        ):
            ask()
    with pytest.raises(
        RequestError, match=r"^--program kratos='/no/such/python': no such executable"
    ):
        open_engine("kratos", programs={"kratos": "/no/such/python"})
    with pytest.raises(RequestError, match=r"kratos\.scheme"):
        open_engine("kratos", options={"scheme": "Forward_Euler"})


CLIPPED_SOURCE = SOURCE.replace(tail="clipped")


def test_what_kratos_cannot_state_is_refused_in_one_line(fake, recorded_incline):
    engine = fake()
    tailed = recorded_incline.replace(contact=SOURCE)
    refusals = [
        (lambda: run_inclines(engine, [tailed], "passage"), "'incline': .*clipped tail"),
        (lambda: run_drops(engine, [Drop(contact=SOURCE)]), "'drop': .*clipped tail"),
        (lambda: run_towers(engine, [Tower(height=2)], 3.0), "law = 'deformable'"),
        (
            lambda: run_towers(engine, [Tower(height=1, law="overlap", mass=(1.0, 2.0))], 3.0),
            "one number each",
        ),
        (lambda: run_inclines(engine, [recorded_incline], "passage", every=0), "every = 0"),
    ]
    for ask, words in refusals:
        with pytest.raises(RequestError, match=words) as raised:
            ask()
        assert "\n" not in str(raised.value)


def test_a_closed_engine_runs_nothing(recorded_incline, fake):
    engine = fake()
    engine.identify()
    engine.close()
    (error,) = run_inclines(engine, [recorded_incline], "passage")
    assert isinstance(error, EngineCrashError)
    assert "closed" in str(error)


def test_the_committed_inputs_are_what_is_generated(inputs):
    committed = {f"kratos/{path.name}": path for path in (inputs / "kratos").iterdir()}
    assert {name: path.read_text(encoding="utf-8") for name, path in committed.items()} == INPUTS


@pytest.mark.parametrize("name", ["contacts", "drop", "incline", "tower"])
def test_the_scripts_are_python_that_needs_kratos_alone(name):
    text = INPUTS[f"kratos/{name}.py"]
    compile(text, name, "exec")
    assert "import harness" not in text
    assert "from harness" not in text
    assert max(map(len, text.splitlines())) <= 100
