"""Runs in slices: the same to the last bit, told and interrupted in between."""

import numpy as np
import pytest

from harness.errors import RequestError
from harness.observables.tower import COLUMNS
from harness.parameters.tower import Tower
from harness.solvers.chain import exact, motion, rk4
from harness.solvers.chain.rk4_deformable import BLOCK

RUNS = {
    "overlap": lambda **more: rk4.run(Tower(height=5, law="overlap"), 2e-3, **more),
    "deformable": lambda **more: rk4.run(Tower(height=5), 2e-3, **more),
    "long rows": lambda **more: rk4.run(
        Tower(height=2 * BLOCK), 1e-4, longest_chain=9, samples=7, **more
    ),
    "exact": lambda **more: exact.run(Tower(height=9), 0.02, samples=300, **more),
}


@pytest.mark.parametrize("name", RUNS)
def test_a_run_in_slices_is_the_same_to_the_last_bit(monkeypatch, name):
    whole, told = RUNS[name](), []
    monkeypatch.setattr(motion, "SLICE_SECONDS", 1e-6)
    monkeypatch.setattr(exact, "CUBES", 1.0)
    cut = RUNS[name](progress=lambda done, total: told.append((done, total)))
    assert len(told) > 3
    assert told == sorted(told)
    assert told[-1][0] == told[-1][1]
    for column in COLUMNS:
        assert np.array_equal(getattr(whole, column), getattr(cut, column)), column
    assert np.array_equal(whole.final_velocity, cut.final_velocity)


@pytest.mark.parametrize("name", RUNS)
def test_an_interrupt_between_two_slices_ends_the_run(monkeypatch, name):
    monkeypatch.setattr(motion, "SLICE_SECONDS", 1e-6)
    monkeypatch.setattr(exact, "CUBES", 1.0)

    def interrupted(done, total):
        assert done < total
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        RUNS[name](progress=interrupted)


def test_what_the_exact_solver_cannot_do_is_said_in_a_line():
    with pytest.raises(RequestError, match=r"^height = 5000: must be less than 5000 .*$"):
        exact.run(Tower(height=5000), 0.01)
    tower = Tower(height=100)  # of 30 it is a matter of the processor's rounding
    with pytest.raises(RequestError, match=r"^duration = .* is below rounding before .*$"):
        exact.run(tower, 1000 * tower.contact_time, samples=10)
