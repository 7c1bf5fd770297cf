"""Readings of bulk cases from made-up outputs: quantities, profiles, errors; second routes."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from harness.cases.bulk import energy_rise
from harness.cases.bulk.drum import Drum, energy_and_work, surface_angle
from harness.cases.bulk.heap import Heap, slope_angles
from harness.cases.bulk.penetration import Penetration
from harness.cases.bulk.silo import (
    BEVERLOO_MARGIN,
    STRESS_RATIO,
    Silo,
    beverloo_scale,
    janssen_share,
)
from harness.errors import EngineLostAtomsError, EngineOutputError, EngineUndecidedError
from tests.cases.bulk.doubles import (
    CASES,
    SERIES,
    drum_bed,
    grains_below_a_plane,
    measure,
    ridge,
    turning,
)  # fmt: skip
from tests.cases.common import made

# ---- damaged and undecided outputs


def astray(name, row):
    """Return the series of a case in which a grain is beyond a wall from a row on."""
    table = SERIES[name](CASES[name].default)
    table["astray"][row] = 1
    return table


def cut_silo():
    """Return a series that lacks three rows."""
    return {n: np.delete(v, range(200, 203)) for n, v in SERIES["silo"](Silo()).items()}


def falling():
    table = SERIES["penetration"](Penetration())
    return {**table, "vz_m_per_s": np.minimum(table["vz_m_per_s"], -0.3)}


def constant(name, column):
    """Return the series of a case in which a column has the value of the first row in all."""
    table = SERIES[name](CASES[name].default)
    return {**table, column: np.repeat(table[column][:1], len(table[column]), axis=0)}


def wrong_clock(name, factor):
    table = SERIES[name](CASES[name].default)
    return {**table, "time_s": factor * table["time_s"]}


def at_rest_in_the_drum():
    return turning(Drum(), drum_bed(Drum()), 0.0)


def turned_too_far():
    table = turning(Drum(), drum_bed(Drum()), 4.08, most=0.5)
    return {**table, "step": Drum().settle_steps + 1.02 * (table["step"] - Drum().settle_steps)}


def drum_beyond(column, value):
    table = turning(Drum(), grains_below_a_plane(Drum()), Drum().speed)
    table[column][50, 0] = value
    return table


LOST, OUTPUT, UNDECIDED = EngineLostAtomsError, EngineOutputError, EngineUndecidedError
WRONG = [  # case, series, changed results, error, its words
    ("silo", lambda: astray("silo", 100), {}, LOST, r"a grain is beyond the walls at 0.202 s"),
    ("silo", None, {"grains": 1199}, LOST, r"beyond the walls at 0 s: the walls leave a hole"),
    ("silo", None, {"grains": 1201}, OUTPUT, "grains = 1201"),
    ("silo", cut_silo, {}, OUTPUT, "lacks rows"),
    ("silo", None, {"stop": 900.0}, UNDECIDED, "arching, .* 900 grains of 1200 remain"),
    ("silo", None, {"rate": 500.0}, UNDECIDED, "duration = 1 s is too short: .* left at 1 s"),
    ("heap", lambda: astray("heap", 50), {}, LOST, r"through the glued layer at 0.918 s"),
    ("heap", None, {"grains": 1151}, LOST, r"through the glued layer at 0 s"),
    ("heap", None, {"grains": 1153}, OUTPUT, "grains = 1153"),
    ("heap", None, {"running": 10}, UNDECIDED, "still moves: 10 grains ran off in"),
    ("heap", None, {"mean_height_m": 0.013}, UNDECIDED, "no ridge: .* layers = 24 are too few for"),
    ("penetration", None, {"outside": 1}, LOST, "a particle passed a wall at step_size = 5e-06"),
    ("penetration", None, {"grains": 1079}, OUTPUT, "grains = 1079"),
    ("penetration", falling, {}, OUTPUT, "still falls at a tenth"),
    ("drum", lambda: drum_beyond("x_m", 0.03), {}, LOST, "beyond the walls after 90 deg"),
    ("drum", lambda: drum_beyond("y_m", 0.011), {}, LOST, "beyond the walls after 90 deg"),
    ("drum", None, {"small": 1}, OUTPUT, "small = 1"),
    # a frozen or wrong column, and a clock that is not that of the steps
    ("silo", lambda: constant("silo", "kinetic_J"), {}, OUTPUT, "kinetic_J never changes"),
    ("heap", lambda: constant("heap", "height_m"), {}, OUTPUT, "height_m never changes"),
    ("penetration", lambda: constant("penetration", "z_m"), {}, OUTPUT, "z_m never changes"),
    ("drum", at_rest_in_the_drum, {}, OUTPUT, "x_m never changes"),
    *(
        (name, lambda name=name: wrong_clock(name, 1.01), {}, OUTPUT, "whose clock is wrong")
        for name in SERIES
    ),
    ("heap", lambda: wrong_clock("heap", 0.99), {}, OUTPUT, "whose clock is wrong"),
    ("drum", turned_too_far, {}, OUTPUT, "whose clock is wrong"),
]


@pytest.mark.parametrize(("name", "series", "changes", "error", "words"), WRONG)
def test_damaged_and_undecided_runs_have_no_quantities(name, series, changes, error, words):
    with pytest.raises(error, match=words) as raised:
        measure(name, series and series(), **changes)
    assert isinstance(raised.value, UNDECIDED) is (error is UNDECIDED)


@pytest.mark.parametrize("name", CASES)
def test_all_quantities_are_measured(name):
    assert set(measure(name)) == {quantity.name for quantity in CASES[name].quantities}


# ---- silo


def test_the_rate_is_the_slope_of_the_number_that_remains():
    p, found = Silo(), measure("silo")
    assert found["discharge_rate_per_s"] == pytest.approx(2000.0, rel=1e-3)
    assert found["discharge_rate_kg_per_s"] == pytest.approx(2000.0 * p.grain.mass, rel=1e-3)
    assert found["half_time_s"] == pytest.approx(0.1 + 0.5 * p.grains / 2000.0, abs=3e-3)
    assert found["passed_ratio"] == 1.0
    assert found["energy_rise_ratio"] == 0.0
    assert found["bed_kinetic_ratio"] == pytest.approx(1e-3)
    assert found["walls_load_ratio"] == pytest.approx(1.0)
    height = found["bed_height_m"]
    share = janssen_share(height - p.cone_height, p.silo_radius, p.steel_friction, STRESS_RATIO)
    volume = p.cone_volume + math.pi * p.silo_radius**2 * (height - p.cone_height)
    share *= 1.0 - p.cone_volume / volume
    assert found["janssen_load_ratio"] == pytest.approx(share)
    assert measure("silo", p=Silo(steel_friction=0.0))["janssen_load_ratio"] == 0.0
    for later, rise in (([2.0, 1.0], 0.0), ([1.0, 1.5, 0.5], 0.5), ([4.0], 1.0)):
        table = {"kinetic_J": np.zeros(len(later)), "potential_J": np.array(later)}
        assert energy_rise(made({"released_J": 3.0}), table) == rise


@pytest.mark.parametrize("height", [0.01, 0.1, 1.0])
def test_janssens_share_is_the_balance_of_slices_integrated(height):
    """d(stress)/dz = rho g - 2 mu K stress / R from the surface down; the floor bears the rest."""
    radius, friction, ratio, weight = 0.05, 0.3, 0.5, 1.5e4
    found = solve_ivp(
        lambda _, stress: weight - 2 * friction * ratio * stress / radius,
        (0, height), [0.0], rtol=1e-10, atol=1e-9,
    )  # fmt: skip
    on_floor = found.y[0, -1] / (weight * height)
    assert janssen_share(height, radius, friction, ratio) == pytest.approx(1 - on_floor, rel=1e-7)


def test_beverloos_scale_is_that_of_a_free_fall_from_the_orifice():
    """By dimensions: density, sqrt(g) and the free width to 5/2; nothing below k diameters."""
    grain, width = 2e-3, 0.03
    wide = BEVERLOO_MARGIN * grain + width
    one = beverloo_scale(wide, grain, 1500.0, 9.81)
    assert one == pytest.approx(1500 * width**2 * math.sqrt(9.81 * width))
    assert beverloo_scale(wide, grain, 3000.0, 4 * 9.81) == pytest.approx(4 * one)
    assert beverloo_scale(BEVERLOO_MARGIN * grain, grain, 1500.0, 9.81) == 0.0


# ---- penetration


def test_depth_deceleration_and_balance_follow_from_the_series_and_the_bed():
    p, found = Penetration(), measure("penetration", depth=0.008)
    fastest = math.sqrt(p.speed**2 + 2 * p.gravity * 0.01)
    assert found["final_height_m"] == pytest.approx(0.012 + 0.004 - 0.008)
    assert found["final_depth_m"] == pytest.approx(0.008)
    assert found["peak_deceleration_m_per_s2"] == pytest.approx(fastest**2 / 0.016)
    slowed = (fastest - p.speed) / p.gravity + 0.9 * 0.016 / fastest
    assert found["slowed_time_s"] == pytest.approx(slowed, abs=2 * p.duration / 600)
    assert found["energy_gain_ratio"] == 0.0
    lost = 1.0 + p.steel.mass * p.gravity * 0.018 / p.impact_energy
    assert found["dissipated_ratio"] == pytest.approx(lost, rel=1e-4)
    # one grain in a cell of the lattice, which shrank from 9 * 2.4 mm to 12 mm
    assert found["bed_solid_fraction"] == pytest.approx(math.pi / 6 / 1.2**3 * 21.6 / 12)
    assert found["microseconds_per_particle_step"] == pytest.approx(0.1, rel=1e-2)
    springs = {"elastic_J": 0.3 * p.impact_energy, "end_elastic_J": 0.1 * p.impact_energy}
    balance = measure("penetration", **springs)["balance_ratio"]
    assert balance == pytest.approx(lost + 0.3 - 0.1, rel=1e-4)


# ---- heap


@pytest.mark.parametrize("angle", [0.0, 5.76, 20.0, 35.0])
def test_the_angle_of_a_ridge_is_that_of_its_slopes(angle):
    assert slope_angles(Heap(), ridge(angle, Heap())) == pytest.approx((angle, angle))


@pytest.mark.parametrize("angle", [10.0, 25.0, 38.0])
def test_grains_strewn_below_slopes_have_their_angle_by_means_and_by_tops(angle):
    """Two routes of the same places: mean heights and highest grains."""
    p, generator = Heap(), np.random.default_rng(5)
    x, z = generator.uniform(0.0, [p.span, 0.06], (200_000, 2)).T
    slope = math.tan(math.radians(angle))
    below = z < 6e-3 + slope * (0.5 * p.span - np.abs(x - 0.5 * p.span))
    x, z = x[below], z[below]
    column = np.floor(20 * x / p.span).astype(int)
    mean = np.bincount(column, z, minlength=20) / np.bincount(column, minlength=20)
    assert slope_angles(p, mean) == pytest.approx((angle, angle), abs=0.7)
    right, width = x > 0.5 * p.span, 0.2 * p.span
    points = np.zeros(right.sum())
    tops = surface_angle(x[right] - 0.75 * p.span, z[right], points, width, 4e-4)
    assert tops == pytest.approx(angle, abs=0.7)


def test_angle_and_share_that_remains_are_read_from_the_series():
    found = measure("heap")
    for name in ("angle_deg", "left_angle_deg", "right_angle_deg"):
        assert found[name] == pytest.approx(30.0)
    assert found["angle_change_deg"] == 0.0
    assert found["remaining_ratio"] == pytest.approx(0.6)
    assert found["heap_energy_rise_ratio"] == 0.0
    # two grains of seven hundred are no flow
    assert measure("heap", running=2)["angle_deg"] == pytest.approx(30.0)


# ---- drum


def test_grains_at_random_below_a_plane_are_mixed_and_have_its_angle():
    table = turning(Drum(), grains_below_a_plane(Drum()), Drum().speed, most=1e-5)
    found = measure("drum", table)
    assert found["mixing_index"] == pytest.approx(1.0, abs=0.05)
    assert found["mixing_index"] == pytest.approx(found["first_mixing_index"])
    assert found["surface_angle_deg"] == pytest.approx(math.degrees(math.atan(0.5)), abs=5.0)


def test_a_drum_that_sets_a_rigid_body_in_motion_loses_its_kinetic_energy():
    """As a belt under grains that are laid on it: work = speed L = 2 E_kin, and the lift."""
    p = Drum()
    table = turning(p, grains_below_a_plane(p), p.speed)
    energy, work = energy_and_work(p, table)
    inertia = (p.of_each("mass") * (table["x_m"][0] ** 2 + table["z_m"][0] ** 2)).sum()
    kinetic = 0.5 * inertia * p.speed**2
    lost = work[1:-1] - (energy[1:-1] - energy[0])
    # of differences over turns of 1.8 deg: 0.031^2/6 at most
    assert np.abs(lost - kinetic).max() < 2e-4 * work[-1]
    assert measure("drum", table)["loss_ratio"] == pytest.approx(kinetic / work[-1], abs=4e-4)
    against = measure("drum", turning(p, grains_below_a_plane(p), -p.speed))
    assert against["work_ratio"] < 0.0
    assert against["drum_energy_gain_ratio"] > 0.5
