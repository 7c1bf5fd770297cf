"""Heap: the estimator of the angle, readings, rolling resistance in LAMMPS and LIGGGHTS."""

import math

import numpy as np
import pytest

from harness.cases.bulk.heap import CASE, Heap, columns_over_sill, slope_angles
from harness.cases.bulk.mixing import surface_angle
from harness.errors import EngineLostAtomsError, EngineOutputError, EngineUndecidedError
from tests.cases.bulk.doubles import (
    heap_output,
    heap_series,
    ridge,
)

TINY = Heap(length=16, width=5, sill=1, layers=20, duration=1.0)


def test_the_mean_mass_is_that_of_an_even_range_of_diameters():
    p = Heap()
    sizes = np.linspace(1.0 - 0.15, 1.0 + 0.15, 100_001)
    mean = p.grain.mass * np.mean(sizes**3)
    assert p.weight / (p.grains * p.gravity) == pytest.approx(mean, rel=1e-5)


@pytest.mark.parametrize("angle", [0.0, 5.76, 20.0, 35.0])
def test_the_angle_of_a_ridge_is_that_of_its_slopes(angle):
    assert slope_angles(Heap(), ridge(angle, Heap())) == pytest.approx((angle, angle))


@pytest.mark.parametrize("angle", [10.0, 25.0, 38.0])
def test_grains_strewn_below_slopes_have_their_angle_by_means_by_tops_and_by_numbers(angle):
    """Three routes of the same places: mean heights, highest grains, numbers in columns."""
    p, generator = Heap(), np.random.default_rng(5)
    x, z = generator.uniform(0.0, [p.span, 0.06], (200_000, 2)).T
    slope = math.tan(math.radians(angle))
    below = z < 6e-3 + slope * (0.5 * p.span - np.abs(x - 0.5 * p.span))
    x, z = x[below], z[below]
    column = np.floor(20 * x / p.span).astype(int)
    count = np.bincount(column, minlength=20)
    mean = np.bincount(column, z, minlength=20) / count
    assert slope_angles(p, mean) == pytest.approx((angle, angle), abs=0.7)
    assert angle_by_numbers(mean, count, p) == pytest.approx(angle, abs=0.7)
    right = x > 0.5 * p.span
    tops = surface_angle(
        x[right] - 0.75 * p.span, z[right], np.zeros(right.sum()), 0.2 * p.span, 4e-4
    )
    assert tops == pytest.approx(angle, abs=0.7)


def angle_by_numbers(mean, count, p):
    """Return the angle [deg] of grains that fill columns evenly, by their numbers.

    Volume over height: the numbers are proportional to the heights, the factor is that of all.
    """
    over = columns_over_sill(p, len(count))
    inner = slice(over, len(count) - over)
    height = count * (2.0 * mean[inner].sum() / count[inner].sum())
    return float(np.mean(slope_angles(p, 0.5 * height)))


def measure(table=None, **changes):
    return CASE.measure(Heap(), heap_output(Heap(), table, **changes))


def test_angle_and_share_that_remains_are_read_from_the_series():
    found = measure()
    assert set(found) == {quantity.name for quantity in CASE.quantities}
    for name in ("angle_deg", "left_angle_deg", "right_angle_deg"):
        assert found[name] == pytest.approx(30.0)
    assert found["angle_change_deg"] == 0.0
    assert found["remaining_ratio"] == pytest.approx(0.6)
    assert found["heap_energy_rise_ratio"] == 0.0


def test_a_heap_that_still_moves_or_has_no_ridge_is_undecided():
    with pytest.raises(EngineUndecidedError, match=r"still moves: 10 grains ran off in"):
        measure(running=10)
    # two grains of seven hundred are no flow
    assert measure(running=2)["angle_deg"] == pytest.approx(30.0)
    with pytest.raises(EngineUndecidedError, match=r"no ridge: .* layers = 24 are too few for"):
        measure(mean_height_m=0.5 * 0.026)


def test_a_grain_beyond_a_side_is_an_error_and_no_result():
    p = Heap()
    table = heap_series(p)
    table["astray"][50] = 1
    with pytest.raises(EngineLostAtomsError, match=r"through the glued layer 0.918 s after"):
        measure(table)
    with pytest.raises(EngineLostAtomsError, match=r"through the glued layer 0 s after"):
        measure(grains=p.grains - 1)
    with pytest.raises(EngineOutputError, match="began with 1153 grains of 1152"):
        measure(grains=p.grains + 1)


@pytest.mark.slow
@pytest.mark.live
def test_a_small_heap_in_lammps_has_one_angle_by_heights_and_by_numbers(lammps):
    """Columns of 0.8 diameters hold some fifteen grains each: numbers alone vary by 5 deg."""
    (found,) = lammps.run([CASE.job(TINY)])
    table = found.table(("count", "height_m"))
    angle = np.mean(slope_angles(TINY, table["height_m"][-1]))
    by_numbers = angle_by_numbers(table["height_m"][-1], table["count"][-1], TINY)
    assert angle == pytest.approx(by_numbers, abs=5.0)
    assert 15.0 < angle < 40.0


@pytest.mark.live
@pytest.mark.slow
def test_the_angle_grows_with_friction_of_sliding_then_of_rolling(lammps):
    """Means of seeds vary by 2 deg; friction 0, 0.2, 0.5, then 0.4 of rolling: 9, 23, 30, 42 deg.

    Packings without friction hold 5.76 deg (Peyneau and Roux, Phys. Rev. E 78, 011307 (2008)), a
    small heap more.
    """
    laws = [(0.0, 0.0), (0.2, 0.0), (0.5, 0.0), (0.5, 0.4)]
    trials = [Heap(friction=mu, rolling_friction=rolling) for mu, rolling in laws]
    found = lammps.run([CASE.job(p) for p in trials])
    angle = [CASE.measure(p, o)["angle_deg"] for p, o in zip(trials, found, strict=True)]
    assert np.diff(angle).min() > 3.0
    assert angle[0] < 15.0
