from pathlib import Path

import pytest

from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import TEMPLATE, Incline, InclineRun, Motion
from harness.engines.liggghts.engine import Liggghts
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
from harness.parameters.law import PLASTIC

HERE = Path(__file__).parent
GOOD, BAD = (Incline(angle=angle, stiffness=5e3, contact=PLASTIC) for angle in (10.0, 13.0))


@pytest.fixture
def fake(faked):
    """Return a function that makes an engine of the fake in one of its modes."""
    file, recorded = HERE / "fake_liggghts.py", HERE / "recorded"
    return lambda mode, **limits: faked(Liggghts, (file, mode, recorded), **limits)


@pytest.mark.parametrize(
    ("mode", "limits", "error", "said"),
    [
        ("segfault", {}, EngineCrashError, "SIGSEGV"),
        ("silent", {}, EngineCrashError, "exit status 1"),
        ("nothing", {}, EngineOutputError, "without a result"),
        ("refuse", {}, EngineInputError, "0.05 < coefficientRestitution <= 1 required"),
        ("lose", {}, EngineLostAtomsError, "Lost atoms"),
        ("hang", {"seconds": 2.0}, EngineTimeoutError, "within 2 s"),
        ("bad_alloc", {}, EngineMemoryError, "memory"),
        ("nan", {}, EngineNaNError, "margin_J = -nan"),
        ("half a log", {}, EngineOutputError, "without a result"),
        ("half a series", {}, EngineOutputError, "cut in its last row"),
        ("half a row", {}, EngineOutputError, "incomplete series"),
    ],
)
def test_each_way_to_fail_has_its_error_and_costs_only_its_own_job(
    fake, fails_alone, mode, limits, error, said
):
    passed, failed = fails_alone(fake(mode, **limits), GOOD, BAD, error, said, every=100)
    assert all(str(result).startswith("LIGGGHTS") for result in failed)
    assert {result.motion for result in passed} == {Motion.MOVES_ON}


def test_the_log_of_a_run_that_failed_says_what_ran_and_where_it_ended(fake):
    engine = fake("refuse")
    good, bad = run_inclines(engine, [GOOD, BAD], "passage")
    assert isinstance(good, InclineRun)
    head, digest, *rest = bad.log.splitlines()
    assert head.startswith("# liggghts -in incline-plastic.in -var route passage -var angle 13")
    assert digest.endswith(Liggghts.script(TEMPLATE, "plastic").sha256)
    assert any(line.startswith("ERROR: 0.05 <") for line in rest)


def test_logs_leave_out_what_is_said_of_every_stretch(fake, recorded):
    engine = fake("segfault")
    run_inclines(engine, [GOOD], "passage")
    (log,) = engine.logs().values()
    assert recorded("passage-moves-on.log").count("for 50 steps") > 10
    assert "for 50 steps" not in log
    assert "RESULT verdict = moves_on" in log


def test_hang_ends_at_the_limit_and_leaves_no_process(fake, ends_a_hang):
    ends_a_hang(fake("hang", seconds=0.3), BAD)


def test_closed_engine_starts_nothing(fake):
    engine = fake("segfault")
    engine.close()
    (error,) = run_inclines(engine, [GOOD], "passage")
    assert isinstance(error, EngineCrashError)


def test_provenance_is_what_the_help_says(fake, tmp_path):
    (run,) = run_inclines(fake("segfault"), [GOOD], "passage")
    who = run.provenance
    assert (who.engine, who.engine_version) == ("liggghts", "LIGGGHTS-PUBLIC 3.8.0")
    assert (who.executable, who.how) == (str(tmp_path / "fake-lmp"), "executable")
    assert who.script_sha256 == Liggghts.script(TEMPLATE, "plastic").sha256
    assert who.integrator == "velocity-verlet"


def test_liggghts_without_the_model_is_refused_with_the_model_named(fake):
    with pytest.raises(EngineMissingError, match="without the contact model hooke/stiffness"):
        fake("without model").identify()


def test_wrapper_script_hides_what_it_runs_and_nothing_is_kept(fake):
    assert fake("segfault").fingerprint() is None


@pytest.mark.parametrize(
    "text", ["echo I am a teapot\n", "exit 1\n", "kill -SEGV $$\n"], ids=["talks", "fails", "dies"]
)
def test_program_that_is_not_liggghts_is_refused_by_name(script_file, text):
    with pytest.raises(
        EngineMissingError, match=r"^--program liggghts=\S+fake-lmp is not LIGGGHTS"
    ) as e:
        Liggghts(script_file(text)).identify()
    assert "\n" not in str(e.value)


def test_file_that_cannot_run_is_refused_by_name(tmp_path):
    path = tmp_path / "liggghts"
    path.write_bytes(b"\x7fELF nonsense")
    path.chmod(0o755)
    with pytest.raises(
        EngineMissingError, match=r"^--program liggghts=\S+liggghts is not LIGGGHTS"
    ):
        Liggghts(str(path)).identify()


def test_program_that_is_named_and_not_there_is_a_wrong_request():
    with pytest.raises(
        RequestError, match=r"--program liggghts='/no/such/one': no such executable"
    ):
        Liggghts("/no/such/one")


def test_engine_that_is_not_installed_says_how_to_get_it(monkeypatch):
    monkeypatch.setattr(Liggghts, "programs", ("no-such-program",))
    with pytest.raises(
        EngineMissingError, match=r"apt install liggghts .* or --program liggghts=PATH"
    ):
        Liggghts()
