"""Functions over items side by side, and the shares that are dealt out."""

import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.engines.jobs import dealt, parallel_map


@given(st.integers(1, 50), st.integers(1, 8))
def test_every_index_is_dealt_once_and_hands_differ_by_one_at_most(count, hands):
    shares = dealt(count, hands)
    assert sorted(i for share in shares for i in share) == list(range(count))
    assert max(map(len, shares)) - min(map(len, shares)) <= 1
    assert len(shares) == min(count, hands)


def test_an_exception_of_the_function_is_not_lost():
    def fail(_):
        raise RuntimeError("no folder")

    with pytest.raises(RuntimeError, match="no folder"):
        parallel_map(fail, [1, 2], 2)


def test_results_are_in_order_whoever_is_first():
    def slow(item):
        time.sleep(0.05 if item == 0 else 0.0)
        return item

    assert parallel_map(slow, range(4), 4) == [0, 1, 2, 3]
