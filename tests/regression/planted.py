"""What the tests of planted changes share: a LAMMPS build with a change in it, and a few cases.

A change is planted as a user's would come: an executable of their own that does
something else than it is told. Here it edits the script that it is given, then
runs the real LAMMPS.
"""

from pathlib import Path

from harness.comparison.evidence import InclineEvidence
from harness.workflows.verification.baseline_rows import here

from harness.cases.incline.passages import passages
from harness.cases.tower.records import tower_case, tower_name
from harness.comparison.regression import Baseline, against_baseline
from harness.errors import EngineError
from harness.parameters.tower import Tower
from harness.store.baseline import read_baseline

COMMITTED = Path(__file__).parents[2] / "reports" / "baseline"
TOWER_CASES = [Tower(height=height, law="overlap") for height in (2, 19)]
SOURCE, CLIPPED, PLASTIC = (
    f"lammps/incline-path-{contact}-10.2-deg" for contact in ("source", "clipped", "plastic")
)
SHORT, TALL = (tower_name(case, "lammps") for case in TOWER_CASES)
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
    evidence = InclineEvidence(closed_form_deg=10.2078)
    passages(engine, evidence)
    measured, errors = list(evidence.measured), dict(evidence.errors)
    for case, run in zip(towers, engine.towers(towers, 3.0, profiles=True), strict=True):
        if isinstance(run, EngineError):
            errors[tower_name(case, "lammps")] = run
        else:
            measured.append(tower_case(run, ""))
    return [case.at("quick", here()) for case in measured], errors


def regression(measured, errors=None):
    """Hold what was measured against the committed baseline of the same cases."""
    names = {case.name for case in measured} | set(errors or {})
    known = read_baseline(COMMITTED)
    chosen = Baseline({name: known.cases[name] for name in names}, known.where, known.overrides)
    return against_baseline(measured, chosen, "quick", engines={"lammps"}, errors=errors)


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
