"""The first divergence of a series: from the first step, late, or not at all."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.results.rows import Failure
from harness.results.series import RETURN, excursion_start, first_divergence

TIME = np.linspace(0.0, 10.0, 1001)


def divergence(difference, band):
    zero = {"x": np.zeros_like(TIME)}
    return first_divergence(TIME, {"x": difference}, zero, absolute=band)


@given(start=st.floats(0.1, 9.0), rate=st.floats(0.2, 2.0), band=st.floats(1e-9, 1e-2))
def test_a_growing_swing_diverges_where_it_leaves_the_band_to_stay(start, rate, band):
    swing = np.where(start < TIME, np.expm1(rate * (TIME - start)) * np.cos(20 * TIME), 0.0)
    found = divergence(swing, band)
    first = int(np.searchsorted(TIME, found.time))
    assert found.time > start
    assert abs(swing[first]) > band
    assert found.largest == np.abs(swing).max()
    outside = TIME[:first][np.abs(swing[:first]) > band]
    assert outside.size == 0 or found.time - outside[-1] > RETURN * TIME[-1]


def test_crossing_zero_is_no_return_and_a_spike_before_is_left_out():
    spike = np.where(np.abs(TIME - 2.0) < 0.03, 1.0, 0.0)
    swing = np.where(TIME > 6.0, np.sin(7 * TIME), 0.0)
    assert divergence(spike + swing, 1e-3).time == pytest.approx(6.01)
    assert divergence(spike, 1e-3).time == pytest.approx(1.98)


@pytest.mark.parametrize("first", [0, 1, 2, 500])
def test_the_class_of_a_divergence(first):
    found = divergence(np.where(np.arange(TIME.size) >= first, 1.0, 0.0), 0.5)
    assert found.failure is (Failure.FROM_FIRST_STEP if first <= 1 else Failure.LATE)
    assert str(found.failure) in found.note


def test_a_number_that_is_none_is_outside():
    assert divergence(np.where(TIME > 4.0, np.nan, 0.0), 1.0).time == pytest.approx(4.01)
    assert excursion_start(TIME, np.zeros(TIME.size, bool)) is None


def test_the_earliest_of_several_columns_counts_and_the_band_is_of_each():
    reference = {"x": 1000.0 * np.sin(TIME), "v": np.cos(TIME)}
    run = {"x": reference["x"] + 0.5, "v": reference["v"] + 1e-2 * (TIME > 3.0)}
    assert first_divergence(TIME, run, reference, relative=1e-3, absolute=0.1) is None
    found = first_divergence(TIME, run, reference, relative=1e-3)
    assert (found.column, found.time) == ("v", pytest.approx(3.01))


@pytest.mark.parametrize(
    ("time", "columns", "words"),
    [(TIME, {"y": TIME}, "no column 'x'"), (TIME[:-1], {"x": TIME}, "1000 samples, and 1001"),
     (TIME + 1e-3, {"x": TIME}, "other times")],
)  # fmt: skip
def test_series_that_cannot_be_compared_are_refused(time, columns, words):
    with pytest.raises(ValueError, match=words):
        first_divergence(time, columns, {"x": TIME}, reference_time=TIME)
