from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from harness.errors import RequestError
from harness.solvers.chain import forces, motion
from harness.solvers.chain.forces import closed_contacts
from harness.solvers.chain.motion import compliance

overlaps = st.integers(1, 30).flatmap(
    lambda n: arrays(float, n, elements=st.floats(-0.3, 0.4, allow_subnormal=False))
)


def centres(overlap_):
    return np.concatenate(([0.0], np.cumsum(1 - np.asarray(overlap_))))


def matrix(diagonal, coupling):
    return np.diag(diagonal) + np.diag(coupling[:-1], 1) + np.diag(coupling[:-1], -1)


def norm_of_inverse(n):
    """Return the norm of T^-1 for n touching contacts."""
    return 1 / (2 * np.sin(np.pi / (2 * (n + 1))) ** 2)


def by_enumeration(overlap_, law):
    """Try all contact sets: slow, and beyond doubt."""
    n = overlap_.size
    for closed in itertools.product((False, True), repeat=n):
        held, force = np.flatnonzero(closed), np.zeros(n)
        if held.size:
            force[held] = np.linalg.solve(law[np.ix_(held, held)], overlap_[held])
        if (force >= -1e-12).all() and (law @ force - overlap_ >= -1e-12).all():
            return force
    raise AssertionError("no contact set")


def random_overlaps(rng, kind, n):
    """Separated chains, dense ones, strongly unequal compressions, near contacts."""
    if kind == 0:
        return 0.1 * rng.uniform(-0.3, 1, n)
    if kind == 1:
        return 0.2 * rng.uniform(0.5, 1, n)
    if kind == 2:
        return 10 ** rng.uniform(-9, -0.5, n) * rng.choice([1, 1, -1], n)
    return 0.1 + 1e-6 * rng.normal(size=n)


def test_both_ways_agree_on_two_thousand_configurations():
    """To rounding: a few eps of the positions, times the norm of T^-1."""
    rng = np.random.default_rng(20240913)
    worst = 0.0
    for count in range(2_000):
        particles = int(rng.integers(2, 41))
        x = centres(random_overlaps(rng, count % 4, particles - 1))
        readable = forces.compressions(x, 1.0)
        fast = forces.contact_forces(x, 1.0, 1.0)
        allowed = 4 * np.finfo(float).eps * x[-1] * norm_of_inverse(particles - 1)
        assert np.abs(readable - fast).max() <= allowed
        worst = max(worst, float(np.abs(readable - fast).max() / allowed))
    assert worst > 0  # they do not share their arithmetic


@settings(max_examples=150, deadline=None)
@given(overlaps)
def test_both_ways_agree_on_awkward_configurations(overlap_):
    x = centres(overlap_)
    allowed = 4 * np.finfo(float).eps * x[-1] * norm_of_inverse(x.size - 1)
    assert forces.compressions(x, 1.0) == pytest.approx(
        forces.contact_forces(x, 1.0, 1.0), abs=allowed
    )


def test_merging_by_what_overlaps_now_would_be_wrong():
    """The smallest case in which chains may not simply be joined from the closest pair on.

    After contact 3, contact 2 seems closed (0.6 > 1/2), then 1 as well; all three
    closed would need a pull at contact 2. It is open: 1 and 3 press against it.
    """
    d = np.array([0.9, 0.6, 1.0]) / 10
    together = np.linalg.solve(matrix(np.ones(3), np.full(3, 0.5)), d)
    assert together[1] < 0
    x = centres(d)
    assert forces.compressions(x, 1.0) == pytest.approx([0.09, 0, 0.1], abs=1e-15)
    assert forces.contact_forces(x, 1.0, 1.0) == pytest.approx([0.09, 0, 0.1], abs=1e-15)


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 8))
def test_against_enumeration_with_unequal_particles(seed, n):
    rng = np.random.default_rng(seed)
    diagonal, coupling = compliance(10 ** rng.uniform(-1, 1, n + 1), True)
    d = rng.normal(size=n) * rng.choice([1, 0.1, 0.01], n)
    expected = by_enumeration(d, matrix(diagonal, coupling))
    assert forces.forces_of_overlaps(d, diagonal, coupling) == pytest.approx(expected, abs=1e-9)
    closed = np.zeros(n, bool)
    closed_contacts(d, diagonal, coupling, closed)
    assert (closed == (expected > 1e-12)).all()


@settings(max_examples=100, deadline=None)
@given(overlaps, st.integers(0, 2**32 - 1))
def test_the_solution_is_one_from_every_warm_start(d, seed):
    rng = np.random.default_rng(seed)
    n = d.size
    diagonal, coupling = compliance(np.ones(n + 1), True)
    expected = forces.forces_of_overlaps(d, diagonal, coupling)
    for _ in range(5):
        closed, force, factor = rng.random(n) < 0.5, np.empty(n), np.empty((3, n))
        assert forces.solve(d, diagonal, coupling, closed, factor, force, 1e-15) >= 0
        assert force == pytest.approx(expected, abs=1e-12 * n)


@settings(max_examples=150, deadline=None)
@given(overlaps)
def test_conditions_and_closest_pair(d):
    x = centres(d)
    force = forces.contact_forces(x, 1.0, 1.0)
    rounding = 4 * np.finfo(float).eps * x[-1] * norm_of_inverse(d.size)
    law = matrix(np.ones(d.size), np.full(d.size, 0.5))
    gap = law @ force - d
    assert (force >= 0).all()
    assert (gap >= -1e-13).all()
    assert np.abs(force * gap).max() < 1e-13
    # the closest pair touches, if it is closer than a diameter
    if d.max() > 1e-9:
        assert force[np.argmax(d)] > 0
    else:
        assert force.max() <= max(d.max(), 0) + rounding


@pytest.mark.parametrize("n", [2, 3, 4, 5, 8])
def test_boundary_formula(n):
    rng = np.random.default_rng(n)
    c = rng.uniform(0.01, 0.1, n - 1)
    deformation = np.convolve(c, [1, 1])
    half = 0.5 - deformation / 2
    x = np.concatenate(([0], np.cumsum(half[1:] + half[:-1])))
    assert motion.first_boundary(x, 0.5) == pytest.approx(-half[0], abs=1e-14)
    edges = motion.boundaries(x, 0.5)
    assert edges[1:] - x == pytest.approx(half, abs=1e-13)
    assert motion.partial_compressions(x, 0.5) == pytest.approx(c, abs=1e-13)


def test_boundary_formula_of_the_source_is_off():
    """Its r0 term: -r0 for odd n as here, but + r0 for even n, where there must be none."""
    x = np.array([0.0, 0.9, 1.8, 2.7])
    i, n = np.arange(1, 5), 4
    printed = (0.5 + np.sum((-1.0) ** (i + 1) * (2 * (n - i) + 1) * x)) / n
    example = (-x[3] + 3 * x[2] - 5 * x[1] + 7 * x[0]) / 4
    assert motion.first_boundary(x, 0.5) == pytest.approx(example)
    assert printed != pytest.approx(example)


def test_overlap_law_is_the_diagonal():
    rng = np.random.default_rng(3)
    d = rng.normal(size=30) * 0.1
    x = centres(d)
    expected = np.maximum(1.0 - np.diff(x), 0.0)
    assert forces.contact_forces(x, 1.0, 5.0, deformable=False) == pytest.approx(
        5 * expected, rel=1e-12
    )


def test_unequal_radii_and_stiffness_of_two():
    force = forces.contact_forces([0.0, 1.4], [1.0, 2.0], [3.0, 6.0])
    assert force == pytest.approx([0.1 * 2 * 3 * 6 / 9])


@pytest.mark.parametrize("solver", [forces.compressions, forces.contact_forces])
@pytest.mark.parametrize(
    ("positions", "diameter", "said"),
    [
        ([0.0], 1.0, "two particles"),
        ([0.0, 1.0, 0.5], 1.0, r"positions\[2\] = 0.5"),
        ([0.0, 1.0, 1.0], 1.0, r"positions\[2\] = 1.0"),
        ([0.0, 0.3], 1.0, "0.3 m: must be at least 0.5"),
        ([0.0, np.nan], 1.0, r"positions\[1\] = nan"),
        ([0.0, np.inf], 1.0, r"positions\[1\] = inf"),
        ([0.0, 1.0], 0.0, r"diameter\[0\] = 0.0"),
        ([0.0, 1.0], -1.0, r"diameter\[0\] = -1.0"),
        ([0.0, 1.0], np.nan, r"diameter\[0\] = nan"),
        ([[0.0, 1.0]], 1.0, "shape"),
    ],
)
def test_bad_positions_are_named(solver, positions, diameter, said):
    more = {} if solver is forces.compressions else {"stiffness": 1.0}
    with pytest.raises(RequestError, match=said):
        solver(positions, diameter, **more)


@pytest.mark.parametrize("stiffness", [0.0, -1.0, np.nan, [1.0, 2.0, 3.0]])
def test_bad_stiffness_is_named(stiffness):
    with pytest.raises(RequestError, match="stiffness"):
        forces.contact_forces([0.0, 1.0], 1.0, stiffness)


def test_values_that_are_not_finite_end():
    diagonal, coupling = compliance(np.ones(4), True)
    with pytest.raises(RequestError, match="overlaps"):
        forces.forces_of_overlaps(np.array([0.1, np.nan, 0.2]), diagonal, coupling)


def test_a_hundred_thousand_contacts_at_once():
    rng = np.random.default_rng(5)
    d = rng.normal(0.05, 0.1, 100_000)
    diagonal, coupling = compliance(np.ones(d.size + 1), True)
    force = forces.forces_of_overlaps(d, diagonal, coupling)
    gap = force - d
    gap[1:] += 0.5 * force[:-1]
    gap[:-1] += 0.5 * force[1:]
    assert force.min() >= 0
    assert gap.min() > -1e-12
    closed = np.zeros(d.size, bool)
    closed_contacts(d, diagonal, coupling, closed)
    assert (closed == (force > 0)).all()
