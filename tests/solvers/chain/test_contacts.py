"""The contact set: by pivoting, by the sweeps of the source, and by trying all."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from harness.errors import RequestError
from harness.solvers import chain
from harness.solvers.chain import compliance, contact_forces, forces_of_overlaps

EPS = np.finfo(float).eps
overlaps = st.integers(1, 30).flatmap(
    lambda n: arrays(float, n, elements=st.floats(-0.3, 0.4, allow_subnormal=False))
)


def centres(overlap):
    return np.concatenate(([0.0], np.cumsum(1 - np.asarray(overlap))))


def matrix(diagonal, coupling):
    return np.diag(diagonal) + np.diag(coupling[:-1], 1) + np.diag(coupling[:-1], -1)


def by_enumeration(overlap, law):
    """Try all contact sets: slow, and beyond doubt."""
    n = overlap.size
    for closed in itertools.product((False, True), repeat=n):
        held, force = np.flatnonzero(closed), np.zeros(n)
        if held.size:
            force[held] = np.linalg.solve(law[np.ix_(held, held)], overlap[held])
        if (force >= -1e-12).all() and (law @ force - overlap >= -1e-12).all():
            return force
    raise AssertionError("no contact set")


@settings(max_examples=60)
@given(overlaps)
def test_both_agree_on_awkward_configurations_which_fulfil_the_conditions(overlap):
    x = centres(overlap)
    force = contact_forces(x, 1.0, 1.0)
    rounding = 4 * EPS * x[-1] / (2 * np.sin(np.pi / (2 * x.size)) ** 2)  # of x, times |T^-1|
    assert chain.compressions_by_sweeps(x, 1.0) == pytest.approx(force, abs=rounding)
    gap = matrix(np.ones(overlap.size), np.full(overlap.size, 0.5)) @ force - overlap
    assert force.min() >= 0.0
    assert gap.min() >= -1e-13
    assert np.abs(force * gap).max() < 1e-13
    if overlap.max() > 1e-9:  # the closest pair touches
        assert force[np.argmax(overlap)] > 0.0


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.integers(1, 8))
def test_against_enumeration_with_unequal_particles_from_any_warm_start(seed, n):
    rng = np.random.default_rng(seed)
    law = compliance(10 ** rng.uniform(-1, 1, n + 1), True)
    d = rng.normal(size=n) * rng.choice([1, 0.1, 0.01], n)
    expected = by_enumeration(d, matrix(*law))
    assert forces_of_overlaps(d, *law) == pytest.approx(expected, abs=1e-9)
    for _ in range(3):
        closed, force, factor = rng.random(n) < 0.5, np.empty(n), np.empty((3, n))
        chain.factorise(closed, *law, factor)
        assert chain.solve(d, *law, closed, factor, force, 1e-14)
        assert force == pytest.approx(expected, abs=1e-9)
        assert (closed == (expected > 1e-12)).all()


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.integers(1, 25))
def test_exchanging_one_by_one_finds_the_same_set(seed, n):
    rng = np.random.default_rng(seed)
    law, d = compliance(np.ones(n + 1), True), rng.normal(0.02, 0.1, n)
    expected = forces_of_overlaps(d, *law)
    closed, force, factor = np.zeros(n, bool), np.empty(n), np.zeros((3, n))
    for _ in range(1000 * n):
        chain.substitute(d, factor, force)
        wrong = chain._exchange_wrong(d, *law, force, closed, 1e-15 * n, True)
        if not wrong:
            break
        chain.factorise(closed, *law, factor)
    assert np.maximum(force, 0.0) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("n", [2, 3, 4, 5, 8])
def test_the_boundary_formula(n):
    c = np.random.default_rng(n).uniform(0.01, 0.1, n - 1)
    half = 0.5 - np.convolve(c, [1, 1]) / 2
    x = np.concatenate(([0], np.cumsum(half[1:] + half[:-1])))
    assert chain.first_boundary(x, 0.5) == pytest.approx(-half[0], abs=1e-14)
    assert chain.boundaries(x, 0.5)[1:] - x == pytest.approx(half, abs=1e-13)
    assert chain.partial_compressions(x, 0.5) == pytest.approx(c, abs=1e-13)


@pytest.mark.parametrize("positions", [[0.0, 1.0, 0.5], [0.0, 0.3], [0.0, np.nan]])
def test_bad_positions(positions):
    for solver in (chain.compressions_by_sweeps, lambda x, d: contact_forces(x, d, 1.0)):
        with pytest.raises(RequestError, match="at least half"):
            solver(positions, 1.0)
