"""Penetration: the longest step, readings, small impacts in LAMMPS."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from harness.cases.bulk.beds import RAYLEIGH_SHARE, Sphere
from harness.cases.bulk.penetration import CASE, Penetration
from harness.errors import EngineLostAtomsError, EngineOutputError
from harness.results.rows import Verdict
from tests.cases.bulk.doubles import StandIn, own_rows, penetration_output, penetration_series

TINY = Penetration(
    along=6, across=5, layers=3, start_height=0.0115, settle_time=0.06, duration=0.05
)


def test_the_longest_step_is_by_rayleigh_waves_of_steel_or_by_an_impact():
    # 0.2 pi r sqrt(rho/G)/(0.1631 nu + 0.8766), the sphere's
    wave = math.pi * 4e-3 * math.sqrt(7200 * 2.4 / 2.1e9) / (0.1631 * 0.2 + 0.8766)
    assert Penetration().longest_step == pytest.approx(0.2 * wave)
    # a fast sphere: Hertz's contact time of a grain on steel, by its two moduli
    p = Penetration(speed=100.0, step_size=1e-6)
    modulus = 1 / ((1 - 0.04) / 1e7 + (1 - 0.04) / 2.1e9)
    speed = math.hypot(100.0, math.sqrt(2 * 9.81 * 0.026))
    deepest = (15 * p.grain.mass * speed**2 / (16 * math.sqrt(p.radius) * modulus)) ** 0.4
    assert p.longest_step == pytest.approx(2.9432 * deepest / speed / 20, rel=1e-3)


@pytest.mark.parametrize("nu", [0.0, 0.2, 0.35, 0.49])
def test_the_rayleigh_wave_of_the_step_is_the_root_of_rayleighs_equation(nu):
    """(2 - s)^2 = 4 sqrt(1 - s) sqrt(1 - s c), s = (speed over that of shear)^2."""
    pressed = (1 - 2 * nu) / (2 - 2 * nu)

    def secular(s):
        return (2 - s) ** 2 - 4 * math.sqrt((1 - s) * (1 - s * pressed))

    speed = math.sqrt(brentq(secular, 0.5, 1 - 1e-12))
    grain = Sphere(2e-3, 2500.0, 1e9, nu)
    shear = math.sqrt(1e9 / (2 * (1 + nu)) / 2500.0)
    assert grain.rayleigh_step == pytest.approx(
        RAYLEIGH_SHARE * math.pi * 2e-3 / (speed * shear), rel=4e-3
    )


def test_the_elastic_energy_of_columns_is_below_its_bound():
    """One column of grains, the k-th contact from above bears k grains."""
    p = Penetration()
    modulus, reduced = 1e7 / (2 * (1 - 0.04)), p.radius / 2
    weights = p.grain.mass * p.gravity * np.arange(1, p.layers + 1)
    overlaps = (weights / (4 / 3 * modulus * math.sqrt(reduced))) ** (2 / 3)
    columns = p.along * p.across
    assert columns * (0.4 * weights * overlaps).sum() < p.largest_elastic_energy
    one_layer = p.replace(layers=1, along=4, across=4)
    assert one_layer.largest_elastic_energy == pytest.approx(
        3 * 16 * 0.4 * weights[0] * overlaps[0]
    )


def measure(table=None, **changes):
    p = Penetration()
    return CASE.measure(p, penetration_output(p, table, **{"lower": 0.0, **changes}))


def test_quantities_follow_from_the_series_and_the_state_of_the_bed():
    p, found = Penetration(), measure()
    last = penetration_series(p)["z_m"][-1]
    assert found["final_height_m"] == pytest.approx(last)
    assert found["final_depth_m"] == pytest.approx(0.012 + 0.004 - last)
    assert found["peak_deceleration_m_per_s2"] == pytest.approx(p.speed / 0.02)
    assert found["slowed_time_s"] == pytest.approx(0.018, abs=2 * p.duration / 600)
    assert found["energy_gain_ratio"] == 0.0
    assert found["dissipated_ratio"] == pytest.approx(1.0)
    # one grain in a cell of the lattice, which shrank from 9 * 2.4 mm to 12 mm
    assert found["bed_solid_fraction"] == pytest.approx(math.pi / 6 / 1.2**3 * 21.6 / 12)
    assert found["microseconds_per_particle_step"] == pytest.approx(0.1, rel=1e-2)
    assert math.isnan(found["friction_by_depth"])  # the sphere stays above the bed


def test_the_balance_takes_the_springs_into_account():
    impact = Penetration().impact_energy
    found = measure(elastic_J=0.3 * impact, end_elastic_J=0.1 * impact)
    assert found["balance_ratio"] == pytest.approx(1.0 + 0.3 - 0.1)


def test_the_friction_by_depth_takes_the_fall_to_the_surface_and_the_bed_with_its_voids():
    p, found = Penetration(), measure(lower=0.015)
    depth = 0.012 + p.steel_radius - (penetration_series(p)["z_m"][-1] - 0.015)
    assert found["final_depth_m"] == pytest.approx(depth)
    height = p.start_height - p.steel_radius - 0.012 + p.speed**2 / (2 * p.gravity)
    ratio = p.steel_density / p.density / found["bed_solid_fraction"]
    expected = 0.14 * math.sqrt(ratio) * 0.008 ** (2 / 3) * (height + depth) ** (1 / 3) / depth
    assert found["friction_by_depth"] == pytest.approx(expected)


def test_damaged_runs_are_errors_and_no_results():
    with pytest.raises(EngineLostAtomsError, match="a particle passed a wall at step_size = 5e-06"):
        measure(outside=1)
    with pytest.raises(EngineOutputError, match="grains = 1079"):
        measure(grains=1079)
    falling = {**penetration_series(Penetration()), "vz_m_per_s": np.full(600, -0.3)}
    with pytest.raises(EngineOutputError, match="still falls at a tenth"):
        measure(falling)


@pytest.mark.parametrize(("grains", "verdict"), [(1.9, Verdict.NOT_TESTED), (2.1, Verdict.FINDING)])
def test_the_known_depth_is_not_tested_where_the_floor_ends_the_fall(grains, verdict):
    p = Penetration()
    lowest = penetration_series(p)["z_m"].min()
    lower = lowest - p.steel_radius - grains * p.radius
    faults = {seed: {"lower": lower} for seed in range(1, 5)}
    row = own_rows(StandIn("penetration", faults=faults))["friction_by_depth"]
    assert row.verdict is verdict
    if verdict is Verdict.NOT_TESTED:
        assert "stops 1.9 mm above it, less than a grain's diameter of 2 mm" in row.note


@pytest.mark.live
def test_a_small_impact_in_lammps_loses_energy_and_comes_to_rest(lammps):
    (output,) = lammps.run([CASE.job(TINY)])
    found = CASE.measure(TINY, output)
    assert found["energy_gain_ratio"] == 0.0
    assert found["dissipated_ratio"] > 0.5
    assert 0.4 < found["bed_solid_fraction"] < 0.7
