"""What the tests of planted changes share: a LAMMPS build with a change in it, and a few cases.

A change is planted as a user's would come: an executable of their own that does
something else than it is told. Here it edits the script that it is given, then
runs the real LAMMPS.
"""

from pathlib import Path

from harness.cases.incline.checks import InclineEvidence, Verifying, passages
from harness.cases.registry import get_case
from harness.cases.tower.run import record_name, run_towers, tower_record
from harness.cases.verification import Study
from harness.comparison.regression import Baseline, Expected, against_baseline
from harness.comparison.verification import Findings
from harness.errors import EngineError
from harness.parameters.tower import Tower
from harness.store.baseline import read_baseline
from harness.workflows.verification import here

COMMITTED = Path(__file__).parents[2] / "reports" / "baseline"
TOWER_CASES = [Tower(height=height, law="overlap") for height in (2, 19)]
SOURCE, CLIPPED, PLASTIC = (
    f"lammps/incline-path-{contact}-10.2-deg" for contact in ("source", "clipped", "plastic")
)
SHORT, TALL = (record_name(case, "lammps") for case in TOWER_CASES)
EVERYTHING = {SOURCE, CLIPPED, PLASTIC, SHORT, TALL}


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
    chosen = Baseline({name: known.records[name] for name in names}, known.where, known.overrides)
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
