"""Checks of each engine in the bulk cases: a planted fault in any one seed turns its row alone."""

import math

import pytest

from harness.cases.bulk.seeds import Runs
from harness.cases.registry import get_case
from harness.comparison.verdicts import Verdict
from tests.cases.bulk.doubles import SMALL, recorded_row

SOUND = {
    "silo": {"energy_rise_ratio": 0.0, "bed_kinetic_ratio": 1e-3},
    "drum": {"drum_energy_gain_ratio": 0.01, "elastic_ratio": 0.012, "bed_kinetic_ratio": 1e-3},
    "penetration": {"energy_gain_ratio": 0.0, "bed_kinetic_ratio": 1e-3},
    "heap": {
        "heap_energy_rise_ratio": 0.0,
        "filling_kinetic_ratio": 1e-3,
        "heap_kinetic_ratio": 1e-4,
    },
}
FAULTS = [
    ("silo", "energy_rise_ratio", 0.05, 0),
    ("silo", "energy_rise_ratio", math.nan, 0),
    ("silo", "bed_kinetic_ratio", 0.02, 1),
    ("drum", "drum_energy_gain_ratio", 0.1, 0),
    ("drum", "drum_energy_gain_ratio", math.nan, 0),
    ("drum", "bed_kinetic_ratio", 0.02, 1),
    ("drum", "bed_kinetic_ratio", math.nan, 1),
    ("penetration", "energy_gain_ratio", 0.06, 0),
    ("penetration", "energy_gain_ratio", math.nan, 0),
    ("penetration", "bed_kinetic_ratio", 0.02, 1),
    ("heap", "heap_energy_rise_ratio", 0.2, 0),
    ("heap", "heap_energy_rise_ratio", math.nan, 0),
    ("heap", "filling_kinetic_ratio", 0.02, 1),
    ("heap", "heap_kinetic_ratio", 0.002, 2),
    ("heap", "heap_kinetic_ratio", math.nan, 2),
]


def verdicts(name, fault, faulty=1):
    """Return the verdicts that an engine decides, of five seeds; the last ones have a fault."""
    case = get_case(name)
    row = {**recorded_row("yade", case), **SOUND[name]}
    sound = tuple({**row, "seed": seed} for seed in range(5 - faulty))
    rows = (*sound, *({**row, **fault, "seed": 4 - seed} for seed in range(faulty)))
    judged = case.judge(case.judged, Runs("LAMMPS", rows), SMALL[name])
    return [check.verdict for check in judged if check.verdict in (Verdict.PASS, Verdict.FAIL)]


@pytest.mark.parametrize("name", SOUND)
def test_sound_runs_hold(name):
    assert set(verdicts(name, {})) == {Verdict.PASS}


@pytest.mark.parametrize(("name", "quantity", "value", "turned"), FAULTS)
def test_a_planted_fault_turns_its_check(name, quantity, value, turned):
    # whether the heap is at rest is decided by the median seed
    found = verdicts(name, {quantity: value}, faulty=3 if quantity == "heap_kinetic_ratio" else 1)
    assert [place for place, one in enumerate(found) if one is Verdict.FAIL] == [turned]
    assert found.count(Verdict.PASS) == len(found) - 1
