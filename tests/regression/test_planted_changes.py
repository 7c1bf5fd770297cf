"""Each planted change is caught by the rows against the baseline, and classed rightly.

A change is planted as a user's would come: an executable that edits the script that it is given,
then runs the real LAMMPS.
"""

from dataclasses import dataclass
from pathlib import Path

import pytest

from harness.cases.incline.checks import InclineEvidence, Verifying, passages
from harness.cases.registry import get_case
from harness.cases.tower.run import record_name, run_towers, tower_record
from harness.cases.verification import Study
from harness.comparison.regression import Baseline, Expected, against_baseline
from harness.comparison.verdicts import Triage, Verdict
from harness.comparison.verification import Findings
from harness.engines.lammps.engine import Lammps
from harness.errors import EngineError
from harness.parameters.tower import Tower
from harness.store.baseline import read_baseline
from harness.workflows.verification import here

pytestmark = pytest.mark.live

COMMITTED = Path(__file__).parents[2] / "reports" / "baseline"
TOWER_CASES = [Tower(height=height, law="overlap") for height in (2, 19)]
SOURCE, CLIPPED, PLASTIC = (
    f"lammps/incline-path-{contact}-10.2-deg" for contact in ("source", "clipped", "plastic")
)
SHORT, TALL = (record_name(case, "lammps") for case in TOWER_CASES)
EVERYTHING = {SOURCE, CLIPPED, PLASTIC, SHORT, TALL}


TOWERS = {SHORT, TALL}


@dataclass(frozen=True)
class Plant:
    """A change of the script, the cases that it moves, and the class of their series."""

    sed: str
    moved: frozenset[str]
    triage: Triage


PLANTS = {
    "clipping switched on": Plant(
        r"s/linear_nohistory 0.0 0.0\"$/linear_nohistory 0.0 0.0 limit_damping\"/",
        {SOURCE},  # the two others are clipped already, the towers have no damping
        Triage.LATE,
    ),
    "one contact dropped": Plant(
        r"s/^neigh_modify delay.*/&\ngroup two id 2\ngroup three id 3\n"
        r"neigh_modify exclude group two three/",
        TOWERS,  # two fixed spheres of the incline have no contact to lose
        Triage.LATE,
    ),
}


def editing(lmp, sed):
    """Return a shell script that passes for LAMMPS and edits every script by a sed program."""
    return (
        'for script in *.in; do [ "$script" = batch.in ] || [ ! -f "$script" ] || '
        f"sed -i '{sed}' \"$script\"; done\n"
        f'exec "{lmp}" "$@"\n'
    )


def measure(engine, towers=TOWER_CASES):
    """Run three passages and two towers; return the cases, and the errors by case."""
    found, evidence = Findings("incline", engine.name), InclineEvidence("LAMMPS", 10.2078)
    passages(Verifying(engine, Study(), found, evidence))
    measured, errors = list(found.records), dict(found.errors)
    for case, run in zip(towers, run_towers(engine, towers, 3.0, profiles=True), strict=True):
        if isinstance(run, EngineError):
            errors[record_name(case, "lammps")] = run
        else:
            measured.append(tower_record(run))
    return [record.at("quick", here()) for record in measured], errors


def regression(measured, errors=None):
    """Hold what was measured against the committed baseline of the same records."""
    names = {record.name for record in measured} | set(errors or {})
    known = read_baseline(COMMITTED)
    chosen = Baseline({name: known.records[name] for name in names}, known.where)
    cases = ("incline", "tower")
    expected = Expected(engines={"lammps"}, cases=cases, errors=errors or {})
    tolerances = {name: get_case(name).verification.regression for name in cases}
    return against_baseline(measured, chosen, "quick", expected, tolerances)


def case_of(check):
    """Return the name of the case that a row is about."""
    return check.name.removeprefix("baseline: ").split(":")[0]


def bits(measured):
    """Return every number of the cases, and every sample of their series."""
    found = {}
    for case in measured:
        for name, quantity in case.quantities.items():
            found[case.name, name] = quantity.value
        for name, column in case.series.columns.items():
            found[case.name, name] = column.tobytes()
    return found


@pytest.fixture(scope="module")
def lammps(lammps_here):  # noqa: ARG001
    with Lammps(workers=2) as engine:
        yield engine


@pytest.fixture(scope="module")
def plain(lammps):
    return measure(lammps)


@pytest.fixture
def planted(lmp, script_file):
    """Return a function that measures with a changed LAMMPS; cases, errors and the regression."""

    def run(sed):
        with Lammps(lmp=script_file(editing(lmp, sed)), workers=2) as engine:
            measured, errors = measure(engine)
        return measured, errors, regression(measured, errors)

    return run


def failed(found):
    return [check for check in found.checks if check.verdict is Verdict.FAIL]


def test_nothing_planted_nothing_found(plain):
    found = regression(*plain)
    assert {check.verdict for check in found.checks} == {Verdict.PASS}
    assert not any(check.triage for check in found.checks)
    assert found.divergences == ()


@pytest.mark.parametrize("plant", PLANTS.values(), ids=PLANTS)
def test_a_change_is_caught_where_it_acts_and_nowhere_else(planted, plant):
    _, errors, found = planted(plant.sed)
    assert not errors
    assert {case_of(check) for check in failed(found)} == plant.moved
    for check in failed(found):
        assert check.triage.startswith(plant.triage), check.name
    assert {series.case for series in found.divergences} == plant.moved


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


@pytest.mark.slow
def test_no_false_alarm_of_the_executable_on_two_mpi_ranks(plain, lmp, mpirun):
    with Lammps(lmp=lmp, launcher=f"{mpirun} -np 2") as engine:
        measured, errors = measure(engine)
    assert not errors
    assert {check.verdict for check in regression(measured).checks} == {Verdict.PASS}
    assert bits(measured) == bits(plain[0])
