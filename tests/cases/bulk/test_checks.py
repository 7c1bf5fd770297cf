"""Checks of bulk cases on stand-ins: planted faults, comparisons and laws of codes, sections."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from harness.cases.bench import Bench
from harness.cases.bulk import plane_discs
from harness.cases.bulk.comparison import bulk_law, stated_law, with_tail
from harness.model.law import damping_ratio
from harness.results.rows import Failure, Verdict
from tests.cases.bulk.doubles import CASES, StandIn, comparison_rows, own_rows
from tests.cases.common import made

PASS, FAIL, NOT_TESTED = Verdict.PASS, Verdict.FAIL, Verdict.NOT_TESTED
FINDING = Verdict.FINDING
SOUND = {
    "silo": {
        "energy_rise_ratio": PASS, "bed_kinetic_ratio": PASS, "bed_solid_fraction": PASS,
        "arching": FINDING, "beverloo_factor": FINDING, "shaft_load_ratio": FINDING,
    },
    "drum": {
        "drum_energy_gain_ratio": PASS, "bed_kinetic_ratio": PASS, "bed_solid_fraction": PASS,
        "surface_angle_deg": PASS,
    },
    "heap": {
        "heap_energy_rise_ratio": PASS, "filling_kinetic_ratio": PASS, "angle_deg": PASS,
        "heap_kinetic_ratio": PASS,
    },
    "penetration": {
        "energy_gain_ratio": PASS, "bed_kinetic_ratio": PASS, "bed_solid_fraction": PASS,
        "fall_error_steps": PASS, "flight_loss_ratio": PASS,
    },
}  # fmt: skip
# case, changed outputs by seed, the row that turns, its verdict: a bed that still moves is the
# fault of the time that it had to settle
FAULTS = [
    ("silo", {3: {"rise": 1e-3}}, "energy_rise_ratio", FAIL),
    ("silo", {2: {"bed_kinetic_J": 2e-5}}, "bed_kinetic_ratio", NOT_TESTED),
    ("silo", {2: {"mean_height_m": 0.06}}, "bed_solid_fraction", FAIL),
    ("silo", {2: {"bed_kinetic_J": 0.0}}, "bed_kinetic_ratio", FAIL),
    ("drum", {4: {"lift": 2e-3}}, "drum_energy_gain_ratio", FAIL),
    ("drum", {4: {"aslant": 1e-3}}, "surface_angle_deg", FAIL),
    ("drum", {1: {"bed_kinetic_J": 1e-5}}, "bed_kinetic_ratio", NOT_TESTED),
    ("heap", {3: {"rise": 5e-3}}, "heap_energy_rise_ratio", FAIL),
    ("heap", {3: {"bed_kinetic_J": 1e-3}}, "filling_kinetic_ratio", NOT_TESTED),
    ("heap", {seed: {"moving": 1e-4} for seed in (1, 2, 4)}, "heap_kinetic_ratio", FAIL),
    ("penetration", {1: {"gained": 1e-5}}, "energy_gain_ratio", FAIL),
    ("penetration", {4: {"bed_kinetic_J": 2e-6}}, "bed_kinetic_ratio", NOT_TESTED),
    ("penetration", {2: {"late": 1}}, "fall_error_steps", FAIL),
    ("penetration", {2: {"lighter": 0.5}}, "flight_loss_ratio", FAIL),
    ("heap", {3: {"angle": 3.0}}, "angle_deg", FAIL),
]


@pytest.mark.parametrize("case", CASES)
def test_sound_runs_pass(case):
    assert {name: row.verdict for name, row in own_rows(StandIn(case)).items()} == SOUND[case]


@pytest.mark.parametrize(("case", "faults", "quantity", "verdict"), FAULTS)
def test_a_planted_fault_turns_its_row_alone(case, faults, quantity, verdict):
    rows = own_rows(StandIn(case, faults=faults))
    assert {name: row.verdict for name, row in rows.items()} == {**SOUND[case], quantity: verdict}
    if verdict is NOT_TESTED:
        assert rows[quantity].note.startswith("the bed is not at rest: it has ")


def test_slow_codes_leave_setups_to_longer_levels():
    def levels(code):
        checks = CASES["penetration"].checks(StandIn("penetration", code))
        found = {check.setup: check.level for check in checks}
        return found["4 seeds"], found["published, 4 places, 40 ms"]

    assert levels("lammps") == ("quick", "default")
    assert levels("yade") == ("default", "full")


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


def test_a_code_that_arches_more_often_is_not_equivalent():
    faults = {seed: {"stop": 900.0} for seed in range(1, 13)}
    pair = StandIn("silo"), StandIn("silo", "liggghts", faults=faults)
    rows = comparison_rows(*pair, setup="16 seeds")
    row = rows["lammps", "over Liggghts", "runs_without_value"]
    assert row.verdict is FAIL
    assert "0 of 16 and 12 of 16" in row.note
    assert rows["lammps", "over Liggghts", "discharge_rate_per_s"].verdict is PASS


# ---- codes against one another

RATE = "discharge_rate_per_s"
# 1.049: the interval is partly beyond the margin: undecided, never a pass
EQUIVALENCE = [(1.03, PASS), (1.2, FAIL), (0.8, FAIL), (1.049, NOT_TESTED)]


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
    """Yade's against LIGGGHTS's; springs of rolling that differ."""
    rows = comparison_rows(StandIn("silo", "liggghts"), StandIn("silo", "yade"), quantity=RATE)
    assert {key[1]: row.verdict for key, row in rows.items()} == {"over Yade": FINDING}
    rows = comparison_rows(StandIn("heap"), StandIn("heap", "liggghts", factor=1.2))
    assert {key[1] for key in rows} == {"over Liggghts"}
    assert {key[2] for key in rows} == {"angle_deg", "remaining_ratio", "runs_without_value"}
    assert rows["lammps", "over Liggghts", "angle_deg"].verdict is FINDING


# ---- the law of a code


def test_lammps_and_liggghts_state_one_law_yade_and_kratos_others():
    laws = {c: stated_law(StandIn("silo", c), bulk_law()) for c in ("liggghts", "yade", "kratos")}
    assert laws["liggghts"] == stated_law(StandIn("silo"), bulk_law())
    assert laws["liggghts"].law == bulk_law()
    found = {code: (one.law.tangential, one.law.clipped, bool(one.lacks))
             for code, one in laws.items()}  # fmt: skip
    assert found["yade"] == ("mindlin/force", True, False)
    assert found["kratos"] == ("mindlin_rescale/force", True, True)
    rolling = [stated_law(StandIn("heap", c), bulk_law(0.2, 0.1)) for c in ("lammps", "liggghts")]
    assert rolling[0].rules == rolling[1].rules
    assert not rolling[0].lacks
    assert "rolling" in rolling[1].lacks  # springs of rolling are two laws


def rebound(restitution, attracts):
    """Return the restitution of Hertz's spring with the dashpot of one that has a tail, or not.

    x'' = -x^1.5 - 2 sqrt(5/6) zeta sqrt(1.5) x^0.25 x' from x = 0 at speed 1, until the overlap is
    gone, or the force.
    """
    eta = 2.0 * math.sqrt(1.25) * damping_ratio(restitution)

    def force(_, state):
        x = max(state[0], 0.0)
        return [state[1], -(x**1.5) - eta * x**0.25 * state[1]]

    def over(time, state):
        x = max(state[0], 0.0)
        left = x if attracts else x**1.25 + eta * state[1]
        return 1.0 if time < 1e-3 else left

    over.terminal = True
    options = {"rtol": 1e-10, "atol": 1e-12, "max_step": 0.05}
    return -solve_ivp(force, (0, 50), [1e-12, 1.0], events=over, **options).y[1, -1]


@pytest.mark.parametrize("restitution", [0.3, 0.4, 0.45, 0.5, 0.8])
def test_a_restitution_without_a_tail_is_that_of_the_same_dashpot(restitution):
    """The fit is within 3e-4 of the restitution; a law with a tail would be off by far more."""
    stated = with_tail(restitution)
    assert rebound(stated, attracts=False) == pytest.approx(restitution, abs=3e-4)
    assert rebound(stated, attracts=True) == pytest.approx(stated, abs=1e-5)
    assert abs(rebound(restitution, attracts=False) - restitution) > 0.005


# ---- report


def test_a_section_shows_the_largest_setup_that_was_run_and_runs_nothing():
    case, engines = CASES["silo"], (StandIn("silo"), StandIn("silo", "liggghts"))
    benches = {engine.name: Bench(engine) for engine in engines}
    assert not case.sections(benches)
    for setup in case.setups[:2]:
        case.sample(benches["lammps"], setup)
    case.sample(benches["liggghts"], case.setups[0])
    ran = [len(engine.ran) for engine in engines]
    (section,) = case.sections(benches)
    assert [len(engine.ran) for engine in engines] == ran
    (table,), (drawing,) = section.tables, section.drawings
    assert list(table.frame) == ["quantity", "Lammps"]
    assert len(table.frame) == len(case.quantities)
    assert len(drawing.draw().axes[0].lines) == 16


def test_a_particle_is_the_circle_that_the_plane_cuts_from_it():
    """Eight grains on top of one another and a larger one next to them, which rises."""
    place = np.zeros((3, 9, 3))
    place[:, :8, 2] = np.arange(8) * 2e-3
    place[:, 8] = 5e-3, 0.6e-3, 1e-3
    place[2, 8, 2] = 3e-3
    columns = {f"{axis}_m": place[:, :, k] for k, axis in enumerate("xyz")}
    radius = np.tile([1e-3] * 8 + [2e-3], (3, 1))
    frames = made({}, {"step": np.array([5.0, 10.0, 20.0]), "radius_m": radius, **columns})
    lines = [((0.0, 1e-2, 1e-2), (0.0, 0.0, 1e-2))]
    time = 1e-3 * (frames.table(("step",))["step"] - 10)
    discs = plane_discs("grains", frames, time, 0.6e-3, lines)
    assert discs.time == pytest.approx([0.0, 0.01])  # from the release on
    # the plane is 0.6 mm from the grains' centres: sqrt(1 - 0.6^2) = 0.8
    assert discs.radius[0] == pytest.approx([0.8e-3] * 8 + [2e-3])
    assert (discs.x[1, 8], discs.y[1, 8]) == pytest.approx((5e-3, 3e-3))
    assert discs.value[1].tolist() == discs.value[0].tolist() == discs.y[0].tolist()
    assert discs.lines.tolist() == [[[0, 0], [1e-2, 0]], [[1e-2, 0], [1e-2, 1e-2]]]
    next_to = plane_discs("grains", frames, time, 1.5e-3, lines)
    assert next_to.radius[0] == pytest.approx([0.0] * 8 + [1e-3 * np.sqrt(4 - 0.81)])
