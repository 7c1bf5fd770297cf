"""Checks of bulk cases: planted faults that turn one row, comparisons of codes, undecided runs."""

import math

import pytest

from harness.cases.bulk.law import bulk_law, stated_law
from harness.results.rows import Failure, Verdict
from tests.cases.bulk.doubles import CASES, StandIn, comparison_rows, own_rows

PASS, FAIL, FINDING, NOT_TESTED = (
    Verdict.PASS, Verdict.FAIL, Verdict.FINDING, Verdict.NOT_TESTED,
)  # fmt: skip
SOUND = {
    "silo": {
        "energy_rise_ratio": PASS, "bed_kinetic_ratio": PASS, "arching": FINDING,
        "beverloo_factor": FINDING, "shaft_load_ratio": FINDING,
    },
    "drum": {"drum_energy_gain_ratio": PASS, "bed_kinetic_ratio": PASS},
    "heap": {
        "heap_energy_rise_ratio": PASS, "filling_kinetic_ratio": PASS, "heap_kinetic_ratio": PASS,
    },
    "penetration": {
        "energy_gain_ratio": PASS, "bed_kinetic_ratio": PASS, "friction_by_depth": FINDING,
    },
}  # fmt: skip
# case, changed outputs by seed, the row that turns
FAULTS = [
    ("silo", {3: {"rise": 1e-3}}, "energy_rise_ratio"),
    ("silo", {2: {"bed_kinetic_J": 2e-5}}, "bed_kinetic_ratio"),
    ("drum", {4: {"spin": -4.08}}, "drum_energy_gain_ratio"),
    ("drum", {1: {"bed_kinetic_J": 1e-5}}, "bed_kinetic_ratio"),
    ("heap", {3: {"rise": 5e-3}}, "heap_energy_rise_ratio"),
    ("heap", {3: {"bed_kinetic_J": 1e-3}}, "filling_kinetic_ratio"),
    ("heap", {seed: {"moving": 1e-4} for seed in (1, 2, 4)}, "heap_kinetic_ratio"),
    ("penetration", {1: {"gained": 1e-5}}, "energy_gain_ratio"),
    ("penetration", {4: {"bed_kinetic_J": 2e-6}}, "bed_kinetic_ratio"),
]


@pytest.mark.parametrize("case", CASES)
def test_sound_runs_pass(case):
    assert {name: row.verdict for name, row in own_rows(StandIn(case)).items()} == SOUND[case]


@pytest.mark.parametrize(("case", "faults", "quantity"), FAULTS)
def test_a_planted_fault_turns_its_row_alone(case, faults, quantity):
    rows = own_rows(StandIn(case, faults=faults))
    turned = {name for name, row in rows.items() if row.verdict is not SOUND[case][name]}
    assert turned == {quantity}
    assert rows[quantity].verdict is FAIL


@pytest.mark.parametrize("case", CASES)
def test_each_level_has_a_setup_and_other_efforts_are_other_setups(case):
    setups = CASES[case].setups()
    names = [setup.name for setup in setups]
    assert len(set(names)) == len(names)
    for setup in setups[:3]:
        assert setup.name == f"{CASES[case].seeds[setup.level]} seeds"
        assert len({p.seed for p in setup.runs}) == CASES[case].seeds[setup.level]


@pytest.mark.parametrize(("code", "level"), [("lammps", "quick"), ("yade", "default")])
def test_slow_codes_leave_setups_to_longer_levels(code, level):
    case, engine = CASES["penetration"], StandIn("penetration", code)
    levels = {check.setup: check.level for check in case.checks(engine)}
    assert levels["4 seeds"] == level
    slow = code == "yade"
    assert levels["published, 4 places, 40 ms"] == ("full" if slow else "default")


def test_a_gain_is_judged_by_the_springs_of_its_own_seed_or_by_a_bound():
    faults = {seed: {"gained": 3e-6, "elastic_J": 4e-6} for seed in range(1, 5)}
    row = own_rows(StandIn("penetration", faults=faults))["energy_gain_ratio"]
    assert row.verdict is PASS
    weak = {**faults, 2: {"gained": 3e-6, "elastic_J": 1e-6}}
    failed = own_rows(StandIn("penetration", faults=weak))["energy_gain_ratio"]
    assert failed.verdict is FAIL
    assert failed.tolerance == pytest.approx(row.tolerance / 4.0)
    heap = own_rows(StandIn("heap"))["heap_energy_rise_ratio"]  # no springs measured: the bound
    p = CASES["heap"].default
    above = p.weight * 0.5 * p.layers * p.pitch
    assert heap.tolerance == pytest.approx(p.largest_elastic_energy / above)


# ---- runs without a value, and runs that die


def test_seeds_that_arch_have_no_rate_and_are_counted_by_wilson():
    rows = own_rows(StandIn("silo", faults={2: {"stop": 900.0}}))
    assert rows["arching"].value == 0.25
    z = 1.959964
    centre, spread = (1 + z**2 / 2) / (4 + z**2), z * math.sqrt(0.25 * 0.75 * 4 + z**2 / 4)
    assert rows["arching"].uncertainty == pytest.approx(centre + spread / (4 + z**2) - 0.25)
    assert rows["energy_rise_ratio"].verdict is PASS
    rows = own_rows(StandIn("silo", faults={seed: {"stop": 900.0} for seed in range(1, 5)}))
    assert rows.pop("arching").value == 1.0
    assert {row.verdict for row in rows.values()} == {NOT_TESTED}
    assert rows["beverloo_factor"].note.startswith("4 of 4 runs have no value; seed 1: undecided")


def test_a_seed_that_dies_fails_each_row_with_its_reason():
    rows = own_rows(StandIn("silo", faults={3: {"grains": 1199}}))
    assert {(row.verdict, row.failure) for row in rows.values()} == {(FAIL, Failure.ENGINE)}
    assert "a grain is beyond the walls" in rows["arching"].note


@pytest.mark.parametrize(("arches", "verdict"), [(1, PASS), (12, FAIL)])
def test_a_code_that_arches_more_often_is_not_equivalent(arches, verdict):
    faults = {seed: {"stop": 900.0} for seed in range(1, arches + 1)}
    pair = StandIn("silo"), StandIn("silo", "liggghts", faults=faults)
    rows = comparison_rows(*pair, setup="16 seeds")
    row = rows["lammps", "over Liggghts", "runs_without_value"]
    assert row.verdict is verdict
    assert f"0 of 16 and {arches} of 16" in row.note
    rate = rows["lammps", "over Liggghts", "discharge_rate_per_s"]
    assert rate.verdict is PASS


# ---- codes against one another

RATE = "discharge_rate_per_s"
EQUIVALENCE = [
    (1.0, PASS),
    (1.03, PASS),
    (1.2, FAIL),
    (0.8, FAIL),
    (1.049, NOT_TESTED),  # the interval is partly beyond the margin: undecided, never a pass
    (1.055, NOT_TESTED),
]


@pytest.mark.parametrize(("factor", "verdict"), EQUIVALENCE)
def test_codes_of_one_law_are_equivalent_where_the_whole_interval_is_within(factor, verdict):
    pair = StandIn("silo"), StandIn("silo", "liggghts", factor=1.0 / factor)
    row = comparison_rows(*pair, quantity=RATE)["lammps", "over Liggghts", RATE]
    assert row.verdict is verdict
    assert row.expected == 1.0


def test_runs_that_are_all_the_same_are_one_run():
    """A code that ignores the seed, or answers all jobs with one output, has no spread."""
    same = {seed: {"rate": 2000.0} for seed in range(1, 5)}
    pair = StandIn("silo"), StandIn("silo", "liggghts", faults=same)
    rows = comparison_rows(*pair, quantity="discharge_rate_per_s")
    (row,) = rows.values()
    assert row.verdict is NOT_TESTED
    assert "different runs gave a value in Liggghts" in row.note


EFFECT = {"mindlin/force": 1.1, "mindlin_rescale/force": 1.1}
UNDER = [  # another code, its factor, verdict under its rules
    ("yade", 1.1, PASS),
    ("yade", 1.3, FAIL),
    ("yade", 1.157, NOT_TESTED),
    ("kratos", 1.3, FINDING),  # LAMMPS states its rules in part
]


@pytest.mark.parametrize(("code", "factor", "verdict"), UNDER)
def test_a_code_is_compared_under_its_own_rules(code, factor, verdict):
    """The verdict is that of the code; the effect of the rules is a finding of a size."""
    main = StandIn("silo", of_rules=EFFECT)
    rows = comparison_rows(main, StandIn("silo", code, factor=factor), quantity=RATE)
    title = code.capitalize()
    assert rows["lammps", f"over {title}", RATE].verdict is FINDING
    under = rows["lammps", f"under the rules of {title}, over {title}", RATE]
    assert under.verdict is verdict
    assert under.value == pytest.approx(1.1 / factor, rel=1e-3)
    effect = rows["lammps", f"the rules of {title}", RATE]
    assert (effect.verdict, effect.value) == (FINDING, pytest.approx(1.1, rel=1e-3))
    law = stated_law(StandIn("silo", code), bulk_law())
    ruled = [job for job in main.ran if "tangential" in job.values]
    assert len(ruled) == 4
    assert {name: ruled[0].values[name] for name in law.rules} == law.rules


def test_codes_that_state_no_other_rules_leave_findings_alone():
    rows = comparison_rows(StandIn("silo", "liggghts"), StandIn("silo", "yade"), quantity=RATE)
    assert {key[1]: row.verdict for key, row in rows.items()} == {"over Yade": FINDING}


def test_springs_of_rolling_that_differ_leave_a_finding():
    rows = comparison_rows(StandIn("heap"), StandIn("heap", "liggghts", factor=1.2))
    assert set(rows) == {
        ("lammps", "over Liggghts", name)
        for name in ("angle_deg", "remaining_ratio", "runs_without_value")
    }
    assert rows["lammps", "over Liggghts", "angle_deg"].verdict is FINDING


# ---- report
