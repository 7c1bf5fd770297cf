import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.comparison.series import RETURN, Series, compare_series, part
from harness.errors import RequestError

TIME = np.linspace(0.0, 10.0, 1001)


def growing(start, rate):
    """A difference that is 0 until ``start``, then swings with a growing amplitude."""
    return np.where(start < TIME, np.expm1(rate * (TIME - start)) * np.cos(20 * TIME), 0.0)


@given(start=st.floats(0.1, 9.0), rate=st.floats(0.2, 2.0), band=st.floats(1e-9, 1e-2))
def test_divergence_is_where_the_difference_first_leaves_for_good(start, rate, band):
    difference = growing(start, rate)
    found = part("x", TIME, difference, band)
    assert found.time > start
    first = int(np.searchsorted(TIME, found.time))
    assert abs(difference[first]) > band
    assert found.last_inside == TIME[first - 1]
    # before it, no stretch outside that was not followed by a return
    outside = TIME[:first][np.abs(difference[:first]) > band]
    assert outside.size == 0 or found.time - outside[-1] > RETURN * TIME[-1]


def test_crossing_zero_is_no_return():
    found = part("x", TIME, np.where(TIME > 3.0, np.sin(7 * TIME), 0.0), 1e-3)
    assert found.time == pytest.approx(3.01)
    assert found.stays
    assert not found.from_first_step


def test_spike_before_the_divergence_is_left_out_and_a_lone_spike_came_back():
    spike = np.where(np.abs(TIME - 2.0) < 0.03, 1.0, 0.0)
    both = part("x", TIME, spike + growing(6.0, 1.0), 1e-3)
    assert both.time > 6.0
    alone = part("x", TIME, spike, 1e-3)
    assert alone.time == pytest.approx(1.98, abs=0.011)
    assert not alone.stays


@pytest.mark.parametrize(
    ("first", "expected"), [(0, True), (1, True), (2, False), (500, False)]
)  # fmt: skip
def test_first_step(first, expected):
    difference = np.where(np.arange(TIME.size) >= first, 1.0, 0.0)
    assert part("x", TIME, difference, 0.5).from_first_step is expected


def test_what_is_not_a_number_is_outside():
    difference = np.where(TIME > 4.0, np.nan, 0.0)
    assert part("x", TIME, difference, 1.0).time == pytest.approx(4.01)


def test_thinning_keeps_the_first_samples_and_is_done_once():
    series = Series(TIME, {"x": np.sin(TIME)})
    thin = series.thinned(first=8, rows=100)
    assert thin.time[:8].tolist() == TIME[:8].tolist()
    assert thin.time[-1] == TIME[-1]
    assert thin.time.size <= 109
    assert thin.thinned(first=8, rows=100) is thin


def test_run_with_twice_the_step_shares_most_times_of_a_thinned_reference():
    reference = Series(TIME, {"x": np.sin(TIME)}).thinned()
    run = Series(TIME[::2], {"x": np.sin(TIME[::2])})
    (found,) = compare_series("case", run, reference, 1e-9)
    assert found.time.size > 0.9 * reference.time.size
    assert found.holds


def test_other_times_are_interpolated_and_the_band_says_by_how_much():
    reference = Series(TIME, {"x": np.sin(TIME)})
    other = np.linspace(0.0, 10.0, 777)
    (found,) = compare_series("case", Series(other, {"x": np.sin(other)}), reference, 1e-15)
    assert found.holds
    assert 1e-15 < found.band < 1e-6
    (moved,) = compare_series("case", Series(other, {"x": np.sin(other + 1e-3)}), reference, 1e-15)
    assert not moved.holds


@pytest.mark.parametrize("count", [201, 399, 401])
@pytest.mark.parametrize("noise", ["alternating", "random"])
def test_noise_at_other_times_widens_no_band(count, noise):
    """Splines through every second sample miss noise by more than it differs by."""
    time = np.linspace(0.0, 1.0, 201)
    other = np.linspace(0.0, 1.0, count)
    other[1:-1] += 0.37 * other[1]
    values = {
        "alternating": 5.0 * (-1.0) ** np.arange(count),
        "random": np.random.default_rng(0).normal(0.0, 5.0, count),
    }[noise]
    smooth = Series(time, {"x": np.sin(6.0 * time)})
    (noisy,) = compare_series("case", Series(other, {"x": values}), smooth, 1e-3)
    assert not noisy.holds
    (same,) = compare_series("case", Series(other, {"x": np.sin(6.0 * other)}), smooth, 1e-3)
    assert same.holds


def test_band_is_relative_to_the_largest_value_of_the_reference():
    reference = Series(TIME, {"x": 1000.0 * np.sin(TIME)})
    run = Series(TIME, {"x": 1000.0 * np.sin(TIME) + 0.5})
    (found,) = compare_series("case", run, reference, 1e-3, absolute=0.1)
    assert found.band == pytest.approx(1.1, rel=1e-3)
    assert found.holds
    assert found.largest == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("run", "said"),
    [(Series(TIME, {"y": TIME}), "no column x"), (Series(TIME + 100.0, {"x": TIME}), "from 100")],
)
def test_series_with_nothing_in_common_are_incomplete(run, said):
    with pytest.raises(RequestError, match=f"case: series incomplete: {said}"):
        compare_series("case", run, Series(TIME, {"x": TIME}), 1.0)


def without(rows):
    """Return the times of a run with some rows removed."""
    return np.delete(TIME, rows)


@pytest.mark.parametrize(
    "time",
    [
        TIME[:30],
        TIME[::200],
        TIME[:-1],
        without(slice(400, 600)),
        without(500),
    ],
)
@pytest.mark.parametrize("thin", [False, True])
def test_run_that_lacks_samples_is_incomplete(time, thin):
    reference = Series(TIME, {"x": np.sin(TIME)})
    reference = reference.thinned() if thin else reference
    run = Series(time, {"x": np.sin(time)})
    with pytest.raises(RequestError, match="series incomplete"):
        compare_series("case", run, reference, 1e-3)


def test_run_that_ends_early_since_it_went_another_way_says_where():
    reference = Series(TIME, {"x": np.sin(TIME)})
    run = Series(TIME[:800], {"x": (np.sin(TIME) + 0.1 * (TIME > 6.0))[:800]})
    (found,) = compare_series("case", run, reference, 1e-3)
    assert found.divergence.time == pytest.approx(6.01)


def test_nan_in_a_run_never_holds():
    reference = Series(TIME, {"x": TIME})
    (found,) = compare_series("c", Series(TIME, {"x": np.full_like(TIME, np.nan)}), reference, 1.0)
    assert not found.holds
    assert math.isnan(found.largest)
    assert found.divergence.from_first_step
