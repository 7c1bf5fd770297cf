"""Oblique impacts: sticking, partial slip, and sliding throughout."""

import numpy as np
import pytest

from harness.theory.contact import partial_slip_rebound, spring_strains, stiffness_ratio

POISSON = 0.3
CHI = 1.75 * stiffness_ratio(POISSON)


def test_beyond_four_chi_less_one_all_slides():
    psi = np.array([4.0 * CHI - 0.999, 6.0, 9.0])
    assert partial_slip_rebound(psi, POISSON) == pytest.approx(psi - 4.0 * CHI, abs=2e-3)
    less = 4.0 * CHI - 1.5
    assert partial_slip_rebound(less, POISSON) > less - 4.0 * CHI + 1e-3


def test_springs_under_a_constant_load_are_cattaneo_and_mindlin():
    # T / (mu F) = 1 - (1 - s)^(3/2), s the displacement over the one at which all slides; and
    # Mindlin and Deresiewicz on the way back: twice the same at half the way
    overlap, n = 1.0, 20_000
    x = (np.arange(n) + 0.5) / n
    limit, width = overlap - x**2, 2.0 / n
    load = width * limit.sum()
    assert load == pytest.approx(4.0 / 3.0, rel=1e-6)
    for s in (0.1, 0.5, 0.9):
        there = spring_strains(np.full(n, s), limit)
        assert width * there.sum() / load == pytest.approx(1.0 - (1.0 - s) ** 1.5, rel=1e-4)
        back = spring_strains(there - s, limit)
        force = (1.0 - (1.0 - s) ** 1.5) - 2.0 * (1.0 - (1.0 - s / 2.0) ** 1.5)
        assert width * back.sum() / load == pytest.approx(force, abs=1e-6)


def test_the_rebound_is_odd_and_settles_as_steps_and_springs_are_refined():
    psi = np.array([0.3, 1.0, 2.0, 3.0, 4.0])
    coarse, fine, finest = (
        partial_slip_rebound(psi, POISSON, springs, steps)
        for springs, steps in ((100, 1000), (200, 2000), (400, 4000))
    )
    assert partial_slip_rebound(-psi, POISSON) == pytest.approx(-fine, abs=1e-12)
    assert np.abs(finest - fine).max() < 2e-3
    assert np.abs(finest - fine).max() < 0.7 * np.abs(fine - coarse).max()


def test_friction_takes_energy_and_the_contact_comes_back_the_other_way():
    psi = np.linspace(0.05, 4.0, 20)
    found = partial_slip_rebound(psi, POISSON)
    assert (np.abs(found) < psi).all()
    assert (found[psi > 1.2] < 0.0).all()
