from pathlib import Path

import pytest

from harness.cases.drop.case import Drop, run_drops
from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import Incline, InclineRun
from harness.engines.registry import open_engine
from harness.engines.yade.engine import Yade
from harness.errors import (
    EngineCrashError,
    EngineMemoryError,
    EngineMissingError,
    EngineNaNError,
    EngineOutputError,
    EngineTimeoutError,
    RequestError,
)
from harness.parameters.law import PLASTIC, SOURCE

HERE = Path(__file__).parent
GIGABYTE = 1024**3
GOOD, BAD = (Incline(angle=angle, contact=PLASTIC, stiffness=1e5) for angle in (10.5, 13.0))


@pytest.fixture
def fake(faked, monkeypatch):
    """Return a function that makes an engine of the fake in one of its modes."""
    monkeypatch.setenv("PYTHONPATH", "/no/such/folder")
    monkeypatch.setenv("OMPI_COMM_WORLD_RANK", "0")
    words = ("-I", HERE / "fake_yade.py")
    return lambda mode, **options: faked(
        Yade, (*words, mode, HERE / "recorded"), "fake-yade", **options
    )


@pytest.mark.parametrize(
    ("mode", "limits", "error", "said"),
    [
        ("segfault", {}, EngineCrashError, "SIGSEGV"),
        ("exception", {}, EngineCrashError, "Both materials should have the same"),
        ("hang", {"seconds": 2.0}, EngineTimeoutError, "Yade did not finish within"),
        ("exceed memory", {"memory": GIGABYTE}, EngineMemoryError, "out of memory"),
        ("nan", {}, EngineNaNError, "stage = nan"),
        ("half a result", {}, EngineOutputError, "without a result"),
        ("without a line", {}, EngineOutputError, "undecided"),
    ],
)
def test_each_way_to_fail_has_its_error_and_costs_only_its_own_run(
    fake, fails_alone, mode, limits, error, said
):
    _, failed = fails_alone(fake(mode, **limits), GOOD, BAD, error, said)
    assert all(" gravity_x=2.2067" in result.log for result in failed)


def test_a_path_that_is_cut_costs_only_its_own_run(fake):
    good, bad = run_inclines(fake(""), [GOOD, BAD], "passage", every=200)
    assert good.trajectory.time_s.size == 24
    assert type(bad) is EngineOutputError


def test_runs_are_shared_out_and_come_back_in_order(fake):
    cases = [GOOD, BAD, GOOD, GOOD, BAD]
    results = run_inclines(fake("segfault", workers=2), cases, "passage")
    assert [isinstance(result, InclineRun) for result in results] == [c is GOOD for c in cases]
    assert [r.case for r in results if isinstance(r, InclineRun)] == [GOOD] * 3


def test_hang_ends_at_the_limit_and_leaves_no_process(fake, ends_a_hang):
    ends_a_hang(fake("hang", seconds=0.3), BAD)


def test_a_closed_engine_runs_nothing_and_leaves_no_folder(fake, tmp_path, monkeypatch):
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    engine = fake("")
    assert isinstance(run_inclines(engine, [GOOD], "passage")[0], InclineRun)
    assert list(folder.iterdir()) == []
    engine.close()
    (error,) = run_inclines(engine, [GOOD], "passage")
    assert isinstance(error, EngineCrashError)
    assert list(folder.iterdir()) == []


def test_provenance_and_log_say_what_ran(fake, tmp_path):
    engine = fake("")
    (run,) = run_inclines(engine, [GOOD], "passage")
    who = run.provenance
    assert (who.engine, who.engine_version, who.how) == ("yade", "2023.02a", "executable")
    assert who.executable == str(tmp_path / "fake-yade")
    assert (who.script, who.integrator) == ("incline.py", "mfix-euler")
    log = engine.logs()["incline.py"]
    assert log.startswith("# yade -n -x incline.py x=[-0.0087")
    assert who.script_sha256 in log
    assert log.endswith("RESULT verdict = finished\n\n")


def test_another_version_is_named_as_it_says(fake):
    assert fake("old").identify().engine_version == "2019.01a"


@pytest.mark.parametrize("text", ["echo I am a teapot\n", "exit 1\n", "kill -SEGV $$\n"])
def test_program_that_is_not_yade_is_refused_by_name(script_file, text):
    with (
        Yade(program=script_file(text, "fake-yade")) as engine,
        pytest.raises(EngineMissingError, match=r"fake-yade is not Yade") as caught,
    ):
        engine.identify()
    assert "\n" not in str(caught.value)


def test_program_that_cannot_run_is_refused_by_name(tmp_path):
    path = tmp_path / "yade"
    path.write_bytes(b"\x7fELF nonsense")
    path.chmod(0o755)
    with (
        Yade(program=str(path)) as engine,
        pytest.raises(EngineMissingError, match=r"yade is not Yade: .*[Ee]xec"),
    ):
        engine.identify()


def test_program_that_is_missing_is_a_wrong_request():
    with pytest.raises(RequestError, match=r"^--program yade='/no/such/yade': no such executable"):
        open_engine("yade", programs={"yade": "/no/such/yade"})


def test_yade_that_is_not_installed_is_missing_with_the_remedy(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(EngineMissingError, match=r"no yade on PATH; to get it: apt install yade"):
        Yade()


def test_environment_keeps_what_is_not_foreign(fake, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "os.environ",
        {"PATH": "/bin", "PYTHONPATH": "x", "OMPI_COMM_WORLD_RANK": "1", "HOME": "/home/me"},
    )
    assert fake("").environment(tmp_path) == {"PATH": "/bin", "HOME": str(tmp_path)}


def test_a_contact_that_yade_cannot_state_is_a_wrong_request(fake):
    engine = fake("")
    for refused in (
        lambda: run_inclines(engine, [GOOD, GOOD.replace(contact=SOURCE)], "passage"),
        lambda: run_drops(engine, [Drop(contact=SOURCE)]),
    ):
        with pytest.raises(
            RequestError,
            match=r"'yade' cannot run '\w+': its contacts always have the clipped tail",
        ):
            refused()


def test_a_path_needs_steps_between_its_rows(fake):
    with pytest.raises(RequestError, match=r"every = 0: must be at least 1 step"):
        run_inclines(fake(""), [GOOD], "passage", every=0)
