import sys
from pathlib import Path

import pytest

from harness.cases.incline.runs import measured, run_inclines
from harness.cases.incline.system import TEMPLATE, Incline, InclineRun, Motion, job_of
from harness.engines.lammps.engine import Lammps
from harness.engines.scripts import Script, Task
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
from harness.observables.provenance import Provenance

FAKE = Path(__file__).parent / "fake_lmp.py"
GIGABYTE = 1024**3
GOOD, BAD = Incline(angle=10.0), Incline(angle=13.0)


@pytest.fixture
def fake(faked, tmp_path, recorded):
    """Return a function that makes an engine of the fake in one of its modes."""
    log = tmp_path / "recorded.log"
    log.write_text(recorded("passage-undecided.log"), encoding="utf-8")
    return lambda mode, **limits: faked(Lammps, (FAKE, mode, log), **limits)


@pytest.mark.parametrize(
    ("mode", "limits", "error", "said"),
    [
        ("segfault", {}, EngineCrashError, "SIGSEGV"),
        ("exit", {}, EngineCrashError, "exit status 3"),
        ("refuse", {}, EngineInputError, "Illegal model type"),
        ("hang", {"seconds": 2.0}, EngineTimeoutError, "within 2 s"),
        ("exceed memory", {"memory": GIGABYTE}, EngineMemoryError, "memory"),
        ("nan", {}, EngineNaNError, "margin_J = -nan"),
        ("half a log", {}, EngineOutputError, "without a result"),
        ("killed", {}, EngineMemoryError, "signal SIGKILL"),
        ("echo, then segfault", {}, EngineCrashError, "signal SIGSEGV"),
        ("echo, then killed", {}, EngineMemoryError, "signal SIGKILL"),
        ("echo, then exceed memory", {"memory": GIGABYTE}, EngineMemoryError, "bad_alloc"),
        ("echo, then exit", {}, EngineCrashError, "exit status 3"),
        ("echo, then half a log is left", {}, EngineOutputError, "without a result"),
        ("echo, then half a log", {}, EngineOutputError, "without a result"),
        ("error and verdict", {}, EngineLostAtomsError, "in spite of an error: ERROR: Lost atoms"),
    ],
)
def test_each_way_to_fail_has_its_error_and_costs_only_its_own_job(
    fake, fails_alone, mode, limits, error, said
):
    passed, _ = fails_alone(fake(mode, **limits), GOOD, BAD, error, said)
    assert {result.motion for result in passed} == {Motion.UNDECIDED}


def test_the_log_of_a_run_that_failed_says_what_ran_and_where_it_ended(fake):
    engine = fake("segfault")
    good, bad = run_inclines(engine, [GOOD, BAD], "passage")
    assert isinstance(good, InclineRun)
    head, digest, *rest = bad.log.splitlines()
    assert head.startswith(f"# lmp -in incline-{BAD.contact.name}.in -var route passage -var angle")
    assert digest.endswith(Lammps.script(TEMPLATE, BAD.contact.name).sha256)
    assert rest
    (name,) = engine.logs()
    assert "RESULT verdict" in engine.logs()[name]


def test_fake_that_fits_into_its_memory_is_not_stopped(fake):
    (run,) = run_inclines(fake("exceed memory", memory=8 * GIGABYTE), [BAD], "passage")
    assert isinstance(run, InclineRun)


@pytest.mark.parametrize(
    ("mode", "said"),
    [("killed after its work", "signal SIGKILL"), ("ends with 139", "signal SIGSEGV")],
)
def test_process_that_fails_after_its_last_result_does_not_pass_for_success(fake, mode, said):
    results = run_inclines(fake(mode), [GOOD, BAD], "passage")
    for result in results:
        assert type(result) is EngineCrashError
        assert f"died: {said}, after its results were written" in str(result)
        assert "RESULT verdict" in result.log


def test_hang_ends_at_the_limit_and_leaves_no_process(fake, ends_a_hang):
    ends_a_hang(fake("hang", seconds=0.3), BAD)


def test_measured_raises_what_went_wrong(fake):
    with pytest.raises(EngineCrashError):
        measured(fake("segfault"), [GOOD, BAD], "passage")


def test_provenance_is_what_the_help_says(fake, tmp_path):
    (run,) = run_inclines(fake("segfault"), [GOOD], "passage")
    who = run.provenance
    assert (who.engine, who.engine_version) == ("lammps", "22 Jul 2025 - Update 4")
    assert who.packages == ("GRANULAR", "MC")
    assert who.executable == str(tmp_path / "fake-lmp")
    assert who.how == "executable"
    assert who.script == "incline-source.in"
    assert who.script_sha256 == Lammps.script(TEMPLATE, "source").sha256


def test_a_version_cannot_steer_a_terminal(script_file):
    said = r"Large-scale Atomic/Molecular Massively Parallel Simulator - 1 Jan \033[31m\a"
    path = script_file(f"printf '{said}\\n\\nInstalled packages:\\n\\nGRANULAR \\n\\n'\n")
    with Lammps(lmp=path) as engine:
        assert engine.identify().engine_version == "1 Jan ?[31m?"


def test_lammps_without_granular_is_refused_with_the_package_named(fake):
    with pytest.raises(EngineMissingError, match=r"fake-lmp .* without the GRANULAR package"):
        fake("without granular").identify()


@pytest.mark.parametrize(
    "text", ["echo I am a teapot\n", "exit 1\n", "kill -SEGV $$\n"], ids=["talks", "fails", "dies"]
)
def test_program_that_is_not_lammps_is_refused_by_name(script_file, text):
    with pytest.raises(EngineMissingError, match=r"^--lmp \S+fake-lmp is not LAMMPS") as caught:
        Lammps(lmp=script_file(text)).identify()
    assert "\n" not in str(caught.value)


def test_file_that_cannot_run_is_refused_by_name(tmp_path):
    path = tmp_path / "lmp"
    path.write_bytes(b"\x7fELF nonsense")
    path.chmod(0o755)
    with pytest.raises(EngineMissingError, match=r"^--lmp \S+lmp does not run|is not LAMMPS"):
        Lammps(lmp=str(path)).identify()


def test_file_without_the_right_to_run_is_a_wrong_request(tmp_path):
    path = tmp_path / "lmp"
    path.write_text("", encoding="utf-8")
    with pytest.raises(RequestError, match=r"--lmp .*: no such executable"):
        Lammps(lmp=str(path))


def test_launcher_alone_runs_the_lmp_on_path_and_is_checked_first():
    with pytest.raises(RequestError, match=r"--mpirun 'no-such-launcher'"):
        Lammps(lmp=sys.executable, launcher="no-such-launcher -np 4")


@pytest.mark.live
def test_lost_atom_and_refused_input_are_told_apart_and_cost_only_their_jobs(lmp, lost_atom):
    refused = Script("refused.in", "units furlongs\n", frozenset())
    with Lammps(lmp=lmp, workers=1) as engine:
        engine.identify()
        good = engine.task(job_of(Incline(angle=10.2), "passage"))
        bare = [Task(good.job, script, {}) for script in (lost_atom, refused)]
        lost, fine, wrong, fine_too = engine.execute([bare[0], good, bare[1], good])
    assert isinstance(lost, EngineLostAtomsError)
    assert isinstance(wrong, EngineInputError)
    assert "units" in str(wrong)
    assert fine.has("verdict")
    assert fine.number("margin_J") == fine_too.number("margin_J")


@pytest.mark.live
def test_real_lammps_names_its_release_and_packages(lmp):
    with Lammps(lmp=lmp) as engine:
        who = engine.identify()
    assert "GRANULAR" in who.packages
    assert any(character.isdigit() for character in who.engine_version)
    assert who.executable == lmp


@pytest.mark.parametrize(
    ("version", "shares"),
    [("23 Jun 2022 - Update 4", [[0, 3], [1], [2]]), ("2 Aug 2023", [[0, 1, 2, 3]])],
)
def test_types_that_are_mixed_run_alone_where_their_models_are_what_is_in_memory(
    fake, monkeypatch, version, shares
):
    engine = fake("run")
    monkeypatch.setattr(engine, "workers", 1)
    monkeypatch.setattr(engine, "identify", lambda: Provenance("lammps", version, (), "lmp", ""))
    plain, mixed = {"friction": 0.3}, {"partner_youngs_modulus": 4e8}
    tasks = [Task(None, None, values) for values in (plain, mixed, mixed, plain)]
    assert engine.shares(tasks) == shares
