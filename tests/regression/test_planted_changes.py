"""Each planted change is caught by the rows against the baseline, and classed rightly."""

from dataclasses import dataclass

import numpy as np
import pytest

from harness.cases.incline.checks import CASES
from harness.cases.incline.runs import measured as inclines_measured
from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import Incline
from harness.cases.tower.run import run_towers
from harness.comparison.verdicts import Triage, Verdict
from harness.engines.lammps.engine import Lammps
from harness.engines.process import Limits
from tests.regression.planted import (
    CLIPPED,
    EVERYTHING,
    PLASTIC,
    SHORT,
    SOURCE,
    TALL,
    TOWER_CASES,
    bits,
    case_of,
    editing,
    measure,
    regression,
)

pytestmark = pytest.mark.live

INCLINES = {SOURCE, CLIPPED, PLASTIC}
TOWERS = {SHORT, TALL}
BLOWN_UP = "exp(1000*(step>1000))"
NAN = rf"variable bad equal {BLOWN_UP}-{BLOWN_UP}\nfix bad all addforce v_bad 0 0"


@dataclass(frozen=True)
class Plant:
    """A change of the script, the cases that it moves, and the class of their series."""

    sed: str
    moved: frozenset[str]
    triage: Triage


PLANTS = {
    "stiffness off by 0.1 %": Plant(
        r"s/hooke \$(v_k:%.17g)/hooke $(1.001*v_k:%.17g)/", EVERYTHING, Triage.FIRST_STEP
    ),
    "clipping switched on": Plant(
        r"s/linear_nohistory 0.0 0.0\"$/linear_nohistory 0.0 0.0 limit_damping\"/",
        {SOURCE},  # the two others are clipped already, the towers have no damping
        Triage.LATE,
    ),
    "effective mass halved": Plant(
        r"s/hooke \$(v_k:%.17g) \$(v_eta:%.17g)/hooke $(v_k:%.17g) $(v_eta\/sqrt(2):%.17g)/",
        INCLINES,
        Triage.FIRST_STEP,
    ),
    "gravity rotated by 0.01 deg": Plant(
        r"s/(sin(v_theta):%.17g) \$(-cos(v_theta)/"
        r"(sin(v_theta+PI\/18000):%.17g) $(-cos(v_theta+PI\/18000)/",
        INCLINES,
        Triage.FIRST_STEP,
    ),
    "one contact dropped": Plant(
        r"s/^neigh_modify delay.*/&\ngroup two id 2\ngroup three id 3\n"
        r"neigh_modify exclude group two three/",
        TOWERS,  # two fixed spheres of the incline have no contact to lose
        Triage.LATE,
    ),
}


@pytest.fixture(scope="module")
def lammps(lammps_here):  # noqa: ARG001
    with Lammps(workers=2) as engine:
        yield engine


@pytest.fixture(scope="module")
def plain(lammps):
    return measure(lammps)


@pytest.fixture(scope="module")
def known():
    """What was measured already, by the change that was planted."""
    return {}


@pytest.fixture
def planted(lmp, script_file, known):
    """Return a function that measures with a changed LAMMPS; cases, errors and the regression."""

    def run(sed):
        if sed not in known:
            with Lammps(lmp=script_file(editing(lmp, sed)), workers=2) as engine:
                measured, errors = measure(engine)
            known[sed] = measured, errors, regression(measured, errors)
        return known[sed]

    return run


def failed(found):
    return [check for check in found.checks if check.verdict is Verdict.FAIL]


def series_row(found, case):
    (row,) = [c for c in found.checks if case_of(c) == case and ": series" in c.name]
    return row


def test_nothing_planted_nothing_found(plain):
    found = regression(*plain)
    assert {check.verdict for check in found.checks} == {Verdict.PASS}
    assert not any(check.triage for check in found.checks)
    assert found.divergences == ()


FAST = ("clipping switched on", "gravity rotated by 0.01 deg", "one contact dropped")
"""Of each class one in the incline and one in towers; what the others plant is a factor."""


@pytest.mark.parametrize(
    "plant",
    [
        pytest.param(plant, id=name, marks=[] if name in FAST else pytest.mark.slow)
        for name, plant in PLANTS.items()
    ],
)
def test_a_change_is_caught_where_it_acts_and_nowhere_else(planted, plant):
    _, errors, found = planted(plant.sed)
    assert not errors
    assert {case_of(check) for check in failed(found)} == plant.moved
    for case in plant.moved:
        assert series_row(found, case).triage.startswith(plant.triage)
    for check in failed(found):
        assert check.triage.startswith(plant.triage), check.name
    assert {series.case for series in found.divergences} == plant.moved


def test_clipping_parts_when_a_contact_first_pulls(planted, lammps):
    """The path leaves the baseline's where, in a run of its own, a contact force turns attractive.

    Force of either sphere: k overlap - eta times the rate of separation, with the
    velocity of the half step, which LAMMPS evaluates it with: x(i) - x(i-1) over the step.
    """
    _, _, found = planted(PLANTS["clipping switched on"].sed)
    case = CASES[0]
    (run,) = run_inclines(lammps, [case], "passage", every=1)
    path, d = run.trajectory, case.diameter
    eta = 2 * case.contact.zeta * np.sqrt(case.stiffness * case.mass)
    pulls = np.zeros(path.time_s.size - 1, dtype=bool)
    for sphere in (0.0, d):
        distance = np.hypot(path.x_m - sphere, path.y_m)[1:]
        along, up = (path.x_m - sphere)[1:] / distance, path.y_m[1:] / distance
        separation = (along * np.diff(path.x_m) + up * np.diff(path.y_m)) / case.step
        pulls |= (distance < d) & (case.stiffness * (d - distance) < eta * separation)
    first = path.time_s[1:][np.argmax(pulls)]
    (parted,) = [series for series in found.divergences if series.column == "x_m"]
    moment = parted.divergence
    assert pulls.any()
    assert moment.stays
    assert moment.last_inside <= first <= moment.time


def test_a_dropped_contact_leaves_the_first_samples_as_they_are(planted):
    """The grain feels what the second contact does to the particle behind it only later.

    Up to there contact 1 alone acts; the missing force k delta_2 changes the grain's
    force by k (omega t)^5 / 5! of v0/omega at first (series expansion of three particles).
    """
    _, _, found = planted(PLANTS["one contact dropped"].sed)
    (parted,) = [s for s in found.divergences if (s.case, s.column) == (SHORT, "grain_force_N")]
    omega, stiffness, speed = 1e3, 1e6, 2.0

    def missing(time):
        return stiffness * speed / omega * (omega * time) ** 5 / 120

    moment = parted.divergence
    assert not moment.from_first_step
    assert missing(moment.last_inside) < 1.1 * parted.band
    assert missing(moment.time) > 0.9 * parted.band


def test_a_step_twice_as_long_is_refused_when_it_is_read(planted):
    """The clock of a run must be the steps that were asked for: nothing is left to compare."""
    measured, errors, found = planted(
        r"s/variable step_size equal PI/variable step_size equal 2*PI/"
    )
    assert not measured
    assert set(errors) == EVERYTHING
    assert {case_of(check) for check in failed(found)} == EVERYTHING
    for check in failed(found):
        assert check.triage == f"{Triage.ENGINE_ERROR}: bad output"
        assert "says that it ran with step_s = " in check.note


def test_a_run_that_says_it_had_another_effective_mass_is_refused_when_it_is_read(planted):
    measured, errors, found = planted(r's/variable m_eff equal v_m"/variable m_eff equal v_m\/2"/')
    assert set(errors) == INCLINES
    assert {case_of(check) for check in failed(found)} == INCLINES
    for check in failed(found):
        assert check.triage == f"{Triage.ENGINE_ERROR}: bad output"
        assert "says that it ran with damping_coefficient_N_s_per_m = " in check.note
    assert {record.name for record in measured} == TOWERS


def test_nan_after_a_thousand_steps(planted):
    measured, errors, found = planted(rf"s/^fix plane .*all .*enforce2d$/&\n{NAN}/")
    assert not measured
    assert set(errors) == EVERYTHING
    assert {check.triage for check in failed(found)} == {Triage.NAN}
    assert {case_of(check) for check in failed(found)} == EVERYTHING


@pytest.mark.parametrize("release", ["2022", "2023"])
def test_release_without_coeff_restitution_by_its_recorded_log(release, recorded, script_file):
    """The releases of 2022 and 2023 refuse the damping model, each in its own words."""
    log = recorded(f"no-coeff-restitution-{release}.log")
    help_text = recorded(f"help-{release}.txt")
    program = (
        f"if [ \"$1\" = -h ]; then cat <<'END'\n{help_text}\nEND\nexit 0\nfi\n"
        f"cat > \"$(sed -n 's/^log //p' batch.in | head -1)\" <<'END'\n{log}\nEND\nexit 1\n"
    )
    with Lammps(lmp=script_file(program), workers=1) as engine:
        measured, errors = measure(engine)
    found = regression(measured, errors)
    assert {case_of(check) for check in failed(found)} == EVERYTHING
    for check in failed(found):
        assert check.triage == f"{Triage.WRONG_INPUT}: refused"
        assert "damping model" in check.note or "Illegal model type" in check.note


@pytest.mark.parametrize(
    ("body", "limits", "triage"),
    [
        ("sleep 30", {"seconds": 0.2}, Triage.OUT_OF_TIME),
        ("echo std::bad_alloc >&2; exit 1", {}, Triage.OUT_OF_MEMORY),
        ("kill -SEGV $$", {}, f"{Triage.ENGINE_ERROR}: crashed"),
    ],
    ids=["hangs", "asks for too much", "crashes"],
)
def test_a_lammps_that_dies_is_classed_by_how(body, limits, triage, recorded, script_file):
    help_text = recorded("help-2025.txt")
    program = f"if [ \"$1\" = -h ]; then cat <<'END'\n{help_text}\nEND\nexit 0\nfi\n{body}\n"
    with Lammps(lmp=script_file(program), workers=2, limits=Limits(**limits)) as engine:
        measured, errors = measure(engine)
    found = regression(measured, errors)
    assert {check.triage for check in failed(found)} == {triage}
    assert {case_of(check) for check in failed(found)} == EVERYTHING


@pytest.mark.slow
def test_no_false_alarm_in_five_repetitions(plain, lammps):
    """The spread is nothing at all: every repetition gives the bits of the first."""
    for _ in range(5):
        measured, errors = measure(lammps)
        found = regression(measured, errors)
        assert {check.verdict for check in found.checks} == {Verdict.PASS}
        assert bits(measured) == bits(plain[0])


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [0, 1, 2], ids=["executable", "1 rank", "2 ranks"])
def test_no_false_alarm_of_the_executable_and_on_mpi_ranks(plain, lmp, mpirun, ranks):
    with Lammps(lmp=lmp, launcher=f"{mpirun} -np {ranks}" if ranks else None) as engine:
        measured, errors = measure(engine)
    assert not errors
    found = regression(measured, errors)
    assert {check.verdict for check in found.checks} == {Verdict.PASS}
    assert bits(measured) == bits(plain[0])


@pytest.mark.slow
def test_four_ranks_give_the_same_bits(lammps, lmp, mpirun):
    """Coarse steps: ranks that wait for each other on fewer cores take a second for a few steps."""
    soft = Incline(angle=10.2, stiffness=1e4, steps_per_contact=15.0)
    towers = [case.replace(stiffness=1e5) for case in TOWER_CASES]

    def run(engine):
        passage = inclines_measured(engine, [soft], "passage")
        runs = run_towers(engine, towers, 3.0, steps_per_contact=40.0)
        forces = [run.grain_force.tobytes() for run in runs]
        return passage[0].margin_J, passage[0].steps, forces

    with Lammps(lmp=lmp, launcher=f"{mpirun} -np 4", limits=Limits(seconds=1200)) as engine:
        four = run(engine)
    assert four == run(lammps)
