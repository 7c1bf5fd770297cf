"""MFiX's inputs, against the one of the recorded runs."""

import math
from pathlib import Path

import pytest

from harness.cases.drop import case as drop
from harness.cases.incline import system as incline
from harness.cases.incline.system import Incline, start_in_well
from harness.cases.incline.verification import CONTACT, START_SPEED, case_at
from harness.cases.tower import system as tower
from harness.engines.mfix.engine import Mfix, keyword_file, particle_file
from harness.engines.mfix.system import LIFT, steps_per_contact

RECORDED = Path(__file__).parent / "recorded"

DIFFERS = {
    "RUN_NAME": "a name",
    "DESCRIPTION": "a name",
    "TSTOP": "how long it runs",
    "CALL_USR": "the recorded runs had routines of their own for output and to freeze the row",
    **dict.fromkeys((f"C({i})" for i in range(1, 8)), "switches of those routines"),
    "CYCLIC_X": "a grain that crosses comes back behind the held spheres, and counts twice",
    "PARTICLES": "so the row is as long as the grain needs",
    "XLENGTH": "and so is the box",
    "IMAX": "and so are its cells, 2 m wide as they were",
    "IC_X_E(1)": "and so is the region that is filled with gas",
}
"""Keywords in which the generated input differs from the recorded one, and why."""

ADDED = ("BC_", "DESGRIDSEARCH_", "VTK_", "WRITE_VTK_FILES", "TIME_DEPENDENT_FILENAME")
"""Keywords that replace those routines (the outlet that holds the row, and the output), and those
of the search for neighbours, which their box did not need."""


@pytest.fixture(scope="module")
def recorded(read_keywords):
    return read_keywords((RECORDED / "mfix_quartier.dat").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def system(recorded, incline_of):
    """Return the recorded run as the engine states it."""
    gx, gy = recorded["GRAVITY_X"], recorded["GRAVITY_Y"]
    case = Incline(
        angle=math.degrees(math.atan2(gx, -gy)),
        gravity=math.hypot(gx, gy),
        stiffness=recorded["KN"],
        contact=CONTACT,
        steps_per_contact=steps_per_contact(recorded["DTSOLID_FACTOR"], CONTACT),
    )
    return incline_of(case, start_in_well(case, START_SPEED), 8, 45.0, 20)[1]


def test_every_keyword_of_the_recorded_input_is_stated_but_for_those_reviewed(
    recorded, system, read_keywords
):
    generated = read_keywords(keyword_file(system))
    for key, value in recorded.items():
        if key not in DIFFERS:
            number = isinstance(value, float)
            assert generated[key] == (pytest.approx(value, rel=1e-12) if number else value), key
    extra = {key for key in generated if key not in recorded}
    assert all(key.startswith(ADDED) for key in extra)
    assert {key for key in DIFFERS if generated.get(key) == recorded[key]} == set()


def test_the_grain_starts_as_recorded_against_its_row(system):
    lines = (RECORDED / "particle_input_quartier.dat").read_text(encoding="utf-8").splitlines()
    *row, grain = [[float(word) for word in line.split()] for line in lines]
    ours = [
        [float(word.replace("d", "e")) for word in line.split()]
        for line in particle_file(system).splitlines()
    ]
    mine, below = ours[0], ours[2]  # the mobile one first; the sphere behind the well
    under = min(row, key=lambda sphere: abs(sphere[0] + 0.5 - grain[0]))
    for axis in (0, 1):
        apart = grain[axis] - under[axis]
        assert mine[axis] - below[axis] == pytest.approx(apart, abs=2 * LIFT)
    assert mine[2:] == pytest.approx(grain[2:], rel=1e-15)
    assert [sphere[0] for sphere in ours[1:]] == pytest.approx(
        [ours[1][0] + i for i in range(len(ours) - 1)], abs=1e-15
    )
    assert [sphere[2:4] for sphere in ours[1:]] == [sphere[2:4] for sphere in row[:1]] * (
        len(ours) - 1
    )


def test_numbers_read_back_as_they_were(read_keywords, incline_of):
    case = case_at(10.2, 1e6, 500.0)
    _, system = incline_of(case, start_in_well(case), 1, 1.0, 50)
    keys = read_keywords(keyword_file(system))
    assert keys["DTSOLID_FACTOR"] == pytest.approx(500.0, rel=1e-12)
    assert keys["VTK_DT(1)"] == 50 * case.step
    assert keys["DES_EN_INPUT"] == 1e-20
    assert keys["GRAVITY_X"] == case.gravity * math.sin(math.radians(case.angle))
    assert keys["RO_S0(1)"] == case.density


def test_the_run_ends_with_its_last_step_rounded_up_in_single_precision(read_keywords, incline_of):
    case = case_at(10.2, 1e6, 500.0)
    _, system = incline_of(case, start_in_well(case), 1, 1.0, 50)
    steps = read_keywords(keyword_file(system))["TSTOP"] / system.step
    assert math.ceil(steps) == system.steps
    assert steps == pytest.approx(system.steps - 0.5)


def test_the_inputs_are_a_folder_for_each_system_without_user_routines(read_keywords):
    files = Mfix.inputs([incline.TEMPLATE, drop.TEMPLATE, tower.TEMPLATE])
    assert {name.split("/")[0] for name in files} == {"incline", "drop", "tower"}
    for name, text in files.items():
        if name.endswith("mfix.dat"):
            keys = read_keywords(text)
            assert keys["CALL_USR"] is False
            for axis, index in (("X", "I"), ("Y", "J")):
                cells = keys[f"DESGRIDSEARCH_{index}MAX"]
                assert cells == 1 or keys[f"{axis}LENGTH"] / cells >= 2.4 * keys["D_P0(1)"]
            particles = files[name.replace("mfix.dat", "particle_input.dat")].splitlines()
            assert keys["PARTICLES"] == len(particles)
            assert text.startswith("# ")
            assert "mfixsolver -f mfix.dat" in text
            assert max(map(len, text.splitlines())) < 110
