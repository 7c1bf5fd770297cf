import sys
import time
from pathlib import Path

import pytest

from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun, Motion
from harness.engines.lammps.engine import Lammps
from harness.engines.lammps.executable import Executable
from harness.engines.lammps.jobs import Job
from harness.engines.lammps.scripts import Script, incline_script, incline_variables
from harness.engines.process import Limits
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

FAKE = Path(__file__).parent / "fake_lmp.py"
GIGABYTE = 1024**3
GOOD, BAD = Incline(angle=10.0), Incline(angle=13.0)


@pytest.fixture
def fake(script_file, tmp_path, recorded):
    """Return a function that makes an engine of the fake in one of its modes."""
    log = tmp_path / "recorded.log"
    log.write_text(recorded("passage-undecided.log"), encoding="utf-8")
    engines = []

    def make(mode, **limits):
        path = script_file(f'exec "{sys.executable}" "{FAKE}" "{mode}" "{log}" "$@"\n')
        engines.append(Lammps(lmp=path, workers=1, limits=Limits(**limits)))
        return engines[-1]

    yield make
    for engine in engines:
        engine.close()


@pytest.mark.parametrize(
    ("mode", "limits", "error", "said"),
    [
        ("segfault", {}, EngineCrashError, "SIGSEGV"),
        ("exit", {}, EngineCrashError, "exit status 3"),
        ("refuse", {}, EngineInputError, "Illegal model type"),
        ("hang", {"seconds": 0.5}, EngineTimeoutError, "within 0.5 s"),
        ("exceed memory", {"memory": GIGABYTE}, EngineMemoryError, "memory"),
        ("nan", {}, EngineNaNError, "margin_J = -nan"),
        ("half a log", {}, EngineOutputError, "without a result"),
    ],
)
def test_each_way_to_fail_has_its_error_and_costs_only_its_own_job(fake, mode, limits, error, said):
    results = fake(mode, **limits).inclines([GOOD, BAD, GOOD, GOOD, BAD], "passage")
    for result in (results[1], results[4]):
        assert type(result) is error
        assert said in str(result)
        assert "\n" not in str(result)
    for result in (results[0], results[2], results[3]):
        assert isinstance(result, InclineRun)
        assert result.motion is Motion.UNDECIDED


def test_the_log_of_a_run_that_failed_says_what_ran_and_where_it_ended(fake):
    engine = fake("segfault")
    good, bad = engine.inclines([GOOD, BAD], "passage")
    assert isinstance(good, InclineRun)
    head, digest, *rest = bad.log.splitlines()
    assert head.startswith(f"# lmp -in incline-{BAD.contact.name}.in -var route passage -var angle")
    assert digest.endswith(incline_script(BAD.contact.name).sha256)
    assert rest
    (name,) = engine.logs()
    assert "RESULT verdict" in engine.logs()[name]


def test_fake_that_fits_into_its_memory_is_not_stopped(fake):
    (run,) = fake("exceed memory", memory=8 * GIGABYTE).inclines([BAD], "passage")
    assert isinstance(run, InclineRun)


def test_process_killed_after_its_last_result_loses_nothing(fake):
    results = fake("killed after its work").inclines([GOOD, BAD], "passage")
    assert [type(result) for result in results] == [InclineRun, InclineRun]


def test_hang_ends_at_the_limit_and_leaves_no_process(fake, tmp_path):
    start = time.monotonic()
    (error,) = fake("hang", seconds=0.3).inclines([BAD], "passage")
    assert isinstance(error, EngineTimeoutError)
    assert time.monotonic() - start < 10.0
    commands = (path.read_bytes() for path in Path("/proc").glob("[0-9]*/cmdline"))
    assert not any(str(tmp_path).encode() in command for command in commands)


def test_measured_raises_what_went_wrong(fake):
    with pytest.raises(EngineCrashError):
        fake("segfault").measured([GOOD, BAD], "passage")


def test_provenance_is_what_the_help_says(fake, tmp_path):
    (run,) = fake("segfault").inclines([GOOD], "passage")
    who = run.provenance
    assert (who.engine, who.engine_version) == ("lammps", "22 Jul 2025 - Update 4")
    assert who.packages == ("GRANULAR", "MC")
    assert who.executable == str(tmp_path / "fake-lmp")
    assert who.how == "executable"
    assert who.script == "incline-source.in"
    assert who.script_sha256 == incline_script("source").sha256


def test_lammps_without_granular_is_refused_with_the_package_named(fake):
    with pytest.raises(EngineMissingError, match=r"fake-lmp .* without the GRANULAR package"):
        fake("without granular")


@pytest.mark.parametrize(
    "text", ["echo I am a teapot\n", "exit 1\n", "kill -SEGV $$\n"], ids=["talks", "fails", "dies"]
)
def test_program_that_is_not_lammps_is_refused_by_name(script_file, text):
    with pytest.raises(EngineMissingError, match=r"^--lmp \S+fake-lmp is not LAMMPS") as caught:
        Lammps(lmp=script_file(text))
    assert "\n" not in str(caught.value)


def test_file_that_cannot_run_is_refused_by_name(tmp_path):
    path = tmp_path / "lmp"
    path.write_bytes(b"\x7fELF nonsense")
    path.chmod(0o755)
    with pytest.raises(EngineMissingError, match=r"^--lmp \S+lmp does not run"):
        Lammps(lmp=str(path))


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
    case = Incline(angle=10.2, contact=GOOD.contact)
    good = Job(incline_script("source"), {"route": "passage", **incline_variables(case)})
    runner = Executable(lmp, "", 1, Limits())
    lost, fine, wrong, fine_too = runner.run([Job(lost_atom, {}), good, Job(refused, {}), good])
    runner.close()
    assert isinstance(lost, EngineLostAtomsError)
    assert isinstance(wrong, EngineInputError)
    assert "units" in str(wrong)
    assert "RESULT verdict = " in fine.log
    margins = [line for line in fine.log.splitlines() if line.startswith("RESULT margin_J")]
    assert margins == [x for x in fine_too.log.splitlines() if x.startswith("RESULT margin_J")]


@pytest.mark.live
def test_real_lammps_names_its_release_and_packages(lmp):
    runner = Executable(lmp, "", 1, Limits())
    who = runner.identify()
    runner.close()
    assert "GRANULAR" in who.packages
    assert any(character.isdigit() for character in who.engine_version)
    assert who.executable == lmp
