"""Batches that are run in processes: each item has its result, whatever becomes of the others."""

import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.engines.parallel import dealt, in_batches


@given(st.integers(1, 50), st.integers(1, 8))
def test_every_index_is_dealt_once_and_hands_differ_by_one_at_most(count, hands):
    shares = dealt(count, hands)
    assert sorted(i for share in shares for i in share) == list(range(count))
    assert max(map(len, shares)) - min(map(len, shares)) <= 1
    assert len(shares) == min(count, hands)


@given(st.lists(st.booleans(), min_size=1, max_size=20), st.integers(1, 4))
def test_a_batch_that_ends_early_costs_only_the_item_it_was_at(deadly, hands):
    started, lock = [], threading.Lock()

    def run(batch):
        """Return results up to the first item that kills the process, and its error."""
        with lock:
            started.append(len(batch))
        done = []
        for number, dies in batch:
            done.append(f"died at {number}" if dies else f"did {number}")
            if dies:
                break
        return done

    items = list(enumerate(deadly))
    results = in_batches(items, dealt(len(items), hands), run)
    assert results == [f"died at {n}" if dies else f"did {n}" for n, dies in items]
    assert len(started) <= len(dealt(len(items), hands)) + sum(deadly)


def test_an_exception_of_the_runner_is_not_lost():
    def run(_):
        raise RuntimeError("no folder")

    with pytest.raises(RuntimeError, match="no folder"):
        in_batches([1, 2], dealt(2, 2), run)
