import numpy as np
import pytest

from harness.cases.incline.runs import read as read_run
from harness.cases.incline.system import Incline, Motion
from harness.engines.lammps.language import error_from_text, version_in
from harness.engines.output import Output, read_csv, results_in
from harness.errors import (
    EngineCrashError,
    EngineInputError,
    EngineLostAtomsError,
    EngineMemoryError,
    EngineMissingError,
    EngineNaNError,
    EngineOutputError,
)
from harness.observables.provenance import Provenance
from harness.parameters.law import PLASTIC

WHO = Provenance("lammps", "22 Jul 2025 - Update 4")
CASE = Incline(angle=10.2, steps_per_contact=100.0, contact=PLASTIC)
MOVING = CASE.replace(angle=10.5, wells=3)


def read(log, series=None, case=CASE, route="steady"):
    tables = {} if series is None else {"series": read_csv(series, "LAMMPS", rising=True)}
    output = Output(results_in(log), WHO, tables, log, 0.5)
    return read_run(case, route, output, None if series is None else 1000)


def changed(log, name, value):
    """Return the log with the last RESULT of that name replaced; None removes the line."""
    lines = log.splitlines(keepends=True)
    last = max(i for i, line in enumerate(lines) if line.startswith(f"RESULT {name} ="))
    lines[last] = "" if value is None else f"RESULT {name} = {value}\n"
    return "".join(lines)


def test_trapped_run_with_its_echo(recorded):
    run = read(recorded("steady-trapped.log"))
    assert run.motion is Motion.TRAPPED
    assert run.margin_J == -0.00020290340955675401
    assert run.touching
    assert run.steps == 307450
    assert run.time_s == pytest.approx(307450 * 3.14159265358979e-05)
    assert run.crests.margin_J.shape == run.crests.time_s.shape == (5,)
    assert run.crests.time_s[0] == 0.28902652413026098
    assert run.crests.margin_J[-1] == 0.0013981773292392999
    assert (run.seconds, run.provenance, run.case) == (0.5, WHO, CASE)
    assert run.trajectory is None


def test_moving_run_with_its_path(recorded):
    run = read(recorded("steady-moves-on.log"), recorded("grain.csv"), MOVING)
    assert run.motion is Motion.MOVES_ON
    assert len(run.crests.time_s) == 3
    path = run.trajectory
    assert path.time_s[0] == 0.0
    assert path.x_m[0] == 0.5
    assert path.speed_m_per_s[0] == pytest.approx(0.48 * np.sqrt(9.81), rel=1e-12)
    assert (np.diff(path.time_s) > 0).all()
    assert path.x_m[-1] > 2.5
    assert list(path.to_frame().columns)[-1] == "speed_m_per_s"


def test_run_cut_off_by_time_is_undecided_and_passed_no_crest(recorded):
    run = read(recorded("passage-undecided.log"), None, Incline(angle=10.2), "passage")
    assert run.motion is Motion.UNDECIDED
    assert run.crests.time_s.size == 0


@pytest.mark.parametrize("name", ["verdict", "margin_J", "touching", "time_s", "steps"])
def test_missing_line_is_an_incomplete_result(recorded, name):
    with pytest.raises(EngineOutputError, match=r"incomplete|no table"):
        read(changed(recorded("steady-trapped.log"), name, None))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("verdict", "perhaps"),
        ("steps", "many"),
        ("margin_J", "much"),
        ("crest", "5 6.75"),
        ("crest", "5 6.75 much 1"),
    ],
)
def test_line_that_says_nonsense_is_an_incomplete_result(recorded, name, value):
    with pytest.raises(EngineOutputError, match="incomplete"):
        read(changed(recorded("steady-trapped.log"), name, value))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("route", "passage"),
        ("angle_deg", "10.3"),
        ("mass_kg", "1.000001"),
        ("damping_coefficient_N_s_per_m", "5000"),
        ("step_s", "6.2831853071795897e-05"),
    ],
)
def test_a_run_with_other_settings_than_the_case_is_named_with_both(recorded, name, value):
    with pytest.raises(EngineOutputError, match=rf"route|{name} = {value}, where .* was requested"):
        read(changed(recorded("steady-trapped.log"), name, value))


@pytest.mark.parametrize("value", ["nan", "-nan", "inf", "-inf"])
@pytest.mark.parametrize("name", ["margin_J", "time_s"])
def test_value_that_is_not_a_number_is_named(recorded, name, value):
    with pytest.raises(EngineNaNError, match=f"{name} = {value}"):
        read(changed(recorded("steady-trapped.log"), name, value))


@pytest.mark.parametrize(
    ("year", "release"),
    [
        (2022, "23 Jun 2022 - Update 4"),
        (2023, "2 Aug 2023 - Update 3"),
        (2024, "29 Aug 2024 - Update 3"),
        (2025, "22 Jul 2025 - Update 4"),
    ],
)
def test_release_from_help_text_and_from_greeting(recorded, year, release):
    assert version_in(recorded(f"help-{year}.txt")) == release
    assert version_in(f"LAMMPS ({release})\nOMP_NUM_THREADS environment is not set.\n") == release


@pytest.mark.parametrize("text", ["", "usage: lmp\n", "this is like LAMMPS (but not it)\n"])
def test_text_of_another_program_names_no_release(text):
    with pytest.raises(EngineMissingError, match="not LAMMPS"):
        version_in(text)


@pytest.mark.parametrize(
    ("name", "kind", "said"),
    [
        ("lost-atom.log", EngineLostAtomsError, "Lost atoms: original 1 current 0"),
        ("unknown-damping.log", EngineInputError, "comparing string to number"),
        ("memory.log", EngineMemoryError, "Failed to reallocate 4000055296 bytes"),
    ],
)
def test_recorded_failures_are_told_apart(recorded, name, kind, said):
    error = error_from_text(recorded(name), 1)
    assert type(error) is kind
    assert said in str(error)
    assert "\n" not in str(error)


@pytest.mark.parametrize(
    ("text", "returncode", "kind", "said"),
    [
        ("terminate called after throwing 'std::bad_alloc'", -6, EngineMemoryError, "bad_alloc"),
        ("Traceback\nMemoryError", 1, EngineMemoryError, "memory"),
        ("ERROR on proc 0: Non-numeric atom coords", 1, EngineNaNError, "Non-numeric"),
        ("ERROR: Variable eta is NaN", 1, EngineNaNError, "NaN"),
        ("ERROR: Illegal model type", 1, EngineInputError, "Illegal model type"),
        ("Step 10\n", -11, EngineCrashError, "SIGSEGV"),
        ("Step 10\n", 139, EngineCrashError, "SIGSEGV"),
        ("ERROR: Lost atoms: original 3 current 2", -11, EngineCrashError, "line: ERROR: Lost"),
        ("print 'ERROR: Lost atoms'\nrun 9\n", 1, EngineCrashError, "exit status 1"),
        ("ERROR: angle = 5: must be less\nquit 1\n", 1, EngineInputError, "angle = 5: must"),
        ("ERROR: Unknown pair\nLast command: pair\n", 134, EngineInputError, "Unknown pair"),
        ("ERROR: one\nERROR on proc 1: Lost atoms\n", 1, EngineLostAtomsError, "Lost atoms"),
        # LIGGGHTS prints what it has freed already, line feeds among it
        (
            "ERROR: 0.05 < ze\n\x02U (./src/global_properties.cpp:489)\n",
            1,
            EngineInputError,
            "0.05",
        ),
        ("ERROR: careful\nrun 100\n", 1, EngineCrashError, "its last line: run 100"),
        ("# out of memory?\nStep 10\n", -11, EngineCrashError, "SIGSEGV"),
        ("", -9, EngineMemoryError, "SIGKILL"),
        ("", 137, EngineMemoryError, "SIGKILL"),
        ("", 3, EngineCrashError, "exit status 3"),
        ("", 255, EngineCrashError, "exit status 255"),
        ("Step 10\n", 0, EngineOutputError, "Step 10"),
        ("", None, EngineOutputError, "without a result"),
    ],
)
def test_last_words_and_way_of_death_give_the_kind(text, returncode, kind, said):
    error = error_from_text(text, returncode)
    assert type(error) is kind
    assert said in str(error)
