"""Mixing index and angle of a surface: limits, and second routes."""

import math

import numpy as np
import pytest

from harness.cases.bulk.mixing import cells_of, lacey_index, surface_angle

RNG = np.random.default_rng(7)


def test_kinds_apart_have_the_index_zero():
    cells = np.repeat(np.arange(10), 30)
    assert lacey_index(cells, cells < 4) == pytest.approx(0.0, abs=1e-12)


def test_kinds_that_are_dealt_out_at_random_have_the_index_one_in_the_mean():
    """Whatever the cells hold: 300 deals of 400 grains over cells of 1 to 60."""
    cells = np.repeat(np.arange(20), RNG.integers(1, 61, 20))
    chosen = np.arange(len(cells)) < 0.7 * len(cells)
    found = [lacey_index(cells, RNG.permutation(chosen)) for _ in range(300)]
    assert np.mean(found) == pytest.approx(1.0, abs=4 * np.std(found) / math.sqrt(300))


def test_between_them_it_is_that_of_lacey_for_cells_of_one_content():
    """(s0^2 - s^2)/(s0^2 - sr^2) with s0^2 = p(1-p), sr^2 = p(1-p)/n, up to 1/N."""
    n, shares = 500, np.array([0.2, 0.4, 0.6, 0.8])
    cells = np.repeat(np.arange(4), n)
    chosen = np.concatenate([np.arange(n) < share * n for share in shares])
    apart, variance = 0.25, np.mean((shares - 0.5) ** 2)
    lacey = (apart - variance) / (apart - apart / n)
    assert lacey_index(cells, chosen) == pytest.approx(lacey, rel=1e-3)


def test_grains_of_one_kind_have_no_index():
    assert math.isnan(lacey_index(np.arange(5) // 2, np.ones(5, dtype=bool)))
    assert math.isnan(lacey_index(np.arange(5), np.arange(5) < 2))


def test_a_cell_holds_what_is_within_its_edges():
    x, z = np.array([0.1, 0.9, 1.1, -0.1, 0.1]), np.array([0.1, 0.9, 0.1, 0.1, -0.1])
    first, *others = cells_of(x, z, 1.0)
    assert others[0] == first
    assert len({*others[1:], first}) == 4


@pytest.mark.parametrize("angle", [-20.0, 0.0, 35.0])
def test_the_angle_is_that_of_the_plane_under_which_grains_lie(angle):
    x, depth = RNG.uniform(-1, 1, 20000), RNG.uniform(0, 0.5, 20000)
    z = -x * math.tan(math.radians(angle)) - depth - 0.01
    assert surface_angle(x, z, np.full(20000, 0.01), 0.5, 0.05) == pytest.approx(angle, abs=0.5)


def test_a_surface_of_two_columns_has_no_angle():
    x = np.array([0.05, 0.15])
    assert math.isnan(surface_angle(x, x, np.zeros(2), 0.5, 0.1))
