"""Bouncing and stacked spheres in closed form, against the integration of the law."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from harness.theory import contact
from tests.theory import closed_forms
from tests.theory.sliding import MASS, G

OMEGA = math.sqrt(1e5 / MASS)
ZETA = contact.damping_ratio(0.8)


def contact_of(speed):
    """Return duration, speed at the end and largest overlap of a contact, by integration."""

    def leaves(_, y):
        return y[0]

    def turns(_, y):
        return y[1]

    leaves.terminal, leaves.direction = True, -1.0
    found = solve_ivp(
        lambda _, y: [y[1], G - 2.0 * ZETA * OMEGA * y[1] - OMEGA**2 * y[0]],
        (0.0, 1.0), [0.0, speed], "DOP853", rtol=1e-13, atol=1e-18, events=[leaves, turns],
        first_step=1e-9,
    )  # fmt: skip
    return found.t[-1], -found.y[1, -1], found.y_events[1][0, 0]


def test_every_bounce_of_a_falling_sphere():
    height = 0.05
    apexes = closed_forms.apexes(OMEGA, ZETA, G, height, 4)
    speed, time = math.sqrt(2.0 * G * height), 0.0
    for bounce in range(4):
        time += speed / G
        duration, after, overlap = contact_of(speed)
        if bounce == 0:
            first = contact.rebound(OMEGA, ZETA, G, speed)
            assert duration == pytest.approx(first.duration, rel=1e-10)
            assert overlap == pytest.approx(first.overlap, rel=1e-12)
        time += duration + after / G
        speed = after
    assert time == pytest.approx(apexes[-1][0], rel=1e-10)
    assert speed**2 / (2.0 * G) == pytest.approx(apexes[-1][1], rel=1e-10)


def test_without_gravity_it_is_the_dashpot_alone():
    one = contact.rebound(OMEGA, ZETA, 0.0, 2.0)
    assert one.speed / 2.0 == pytest.approx(0.8, rel=1e-12)
    assert one.duration == pytest.approx(math.pi / OMEGA / math.sqrt(1.0 - ZETA**2), rel=1e-12)


def test_a_hard_sphere_rises_to_the_square_of_the_restitution():
    hard = closed_forms.apexes(1e6, ZETA, G, 0.05, 3)
    assert [height for _, height in hard] == pytest.approx(
        [0.05 * 0.64**n for n in range(4)], rel=1e-4
    )


def test_a_slow_sphere_stays():
    assert contact.rebound(OMEGA, ZETA, G, 1e-5) is None
    assert len(closed_forms.apexes(OMEGA, 0.5, G, 1e-8, 5)) == 1


def test_spheres_pressed_between_plates():
    radii, masses, heights, top = (0.01, 0.012), (0.01, 0.03), (0.0099, 0.0315), 0.043
    zeta = contact.damping_ratio(0.9)
    pair_mass = masses[0] * masses[1] / sum(masses)
    dashpots = [2.0 * zeta * math.sqrt(1e4 * m) for m in (masses[0], pair_mass, masses[1])]

    def rates(_, y):
        (low, high), (u, w) = y[:2], y[2:]
        overlaps = radii[0] - low, sum(radii) - (high - low), high + radii[1] - top
        closing = -u, u - w, w
        floor, between, ceiling = (
            1e4 * d + eta * c for d, eta, c in zip(overlaps, dashpots, closing, strict=True)
        )
        return [u, w, (floor - between) / masses[0] - G, (between - ceiling) / masses[1] - G]

    times = 1e-3 * np.arange(21)
    found = solve_ivp(
        rates, (0.0, times[-1]), [*heights, 0.0, 0.0], "DOP853", t_eval=times, rtol=1e-13,
        atol=1e-16,
    ).y.T  # fmt: skip
    places, velocities = closed_forms.stacked_motion(
        times, heights, masses, radii, (0.0, top), (1e4, dashpots, G)
    )
    assert found[:, :2] == pytest.approx(places, abs=1e-12)
    assert found[:, 2:] == pytest.approx(velocities, abs=1e-11)
    # at rest, springs bear the weights; the exponential has a round-off of omega t = 1e3
    rest, still = closed_forms.stacked_motion(
        [1.5], heights, masses, radii, (0.0, top), (1e4, dashpots, G)
    )
    overlaps = radii[0] - rest[0, 0], sum(radii) - np.diff(rest[0])[0], rest[0, 1] + radii[1] - top
    assert 1e4 * np.diff(overlaps[::-1]) == pytest.approx([masses[1] * G, masses[0] * G], rel=1e-8)
    assert np.abs(still).max() < 1e-12
