"""Closed forms against a second route each, none of it the chain solvers."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from harness.theory import chain
from tests.theory import closed_forms


def test_two_spheres_against_an_integrator():
    m, k, v = 0.3, 2e5, 1.7

    def motion(_, y):
        force = k * max(y[0] - y[1], 0.0)
        return [y[2], y[3], -force / m, force / m]

    def parted(_, y):
        return y[0] - y[1] + 1e-300

    parted.terminal, parted.direction = True, -1
    end = solve_ivp(motion, (0, 1), [1e-15, 0, v, 0], events=parted, rtol=1e-12, atol=1e-15)
    assert end.t[-1] == pytest.approx(chain.contact_time(m, k), rel=1e-8)
    assert end.y[2:, -1] == pytest.approx(closed_forms.velocities_after((m, m), v), abs=1e-8)
    energy = 0.5 * k * chain.peak_overlap(m, k, v) ** 2
    assert energy == pytest.approx(0.25 * m * v**2)  # what is not in the centre of mass


@pytest.mark.parametrize("gravity", [0.0, 9.81, 1e4])
def test_contact_on_fixed(gravity):
    m, k, v = 1.3, 1e5, 2.0
    t0, omega = chain.contact_time_on_fixed(m, k, v, gravity), math.sqrt(k / m)

    def place(t):
        return gravity / omega**2 * (1 - math.cos(omega * t)) + v / omega * math.sin(omega * t)

    assert place(t0) == pytest.approx(0, abs=1e-15)
    impulse, _ = quad(lambda t: k * place(t), 0, t0)
    assert impulse == pytest.approx(chain.impulse_on_fixed(m, k, v, gravity), rel=1e-10)


@pytest.mark.parametrize(
    ("deformable", "expected"),
    [
        (False, [-0.130262, 0.150230, 0.980032]),
        (False, [-0.132275, -0.064975, 0.236978, 0.960272]),
        (True, [-0.185761, 0.230611, 0.955150]),
    ],
)
def test_free_chain_table(deformable, expected):
    velocity = chain.final_velocities(len(expected), deformable)
    assert velocity == pytest.approx(expected, abs=1e-6)
    assert velocity.sum() == pytest.approx(1, abs=1e-12)
    assert velocity @ velocity == pytest.approx(1, abs=1e-12)


def test_semi_infinite_chain_against_a_long_row():
    n, end = 60, chain.DETACHMENT_TAU

    def motion(_, y):
        force = y[: n - 1] - y[1:n]
        a = np.zeros(n)
        a[:-1] -= force
        a[1:] += force
        return np.concatenate((y[n:], a))

    start = np.zeros(2 * n)
    start[n] = 1.0
    run = solve_ivp(motion, (0, end / 2), start, rtol=1e-12, atol=1e-14, dense_output=True)
    tau = np.linspace(0, end, 30)
    state = run.sol(tau / 2)
    assert state[n] == pytest.approx(chain.grain_velocity(tau), abs=1e-9)
    assert state[0] - state[1] == pytest.approx(chain.grain_force(tau), abs=1e-9)
    assert end == pytest.approx(5.135622, abs=1e-6)
    assert chain.grain_velocity(end) == pytest.approx(-0.1322795, abs=1e-7)


@pytest.mark.parametrize("deformable", [False, True])
@pytest.mark.parametrize("contacts", [1, 2, 3, 9])
def test_static_tower_and_series_stiffness(contacts, deformable):
    law = chain.compliance(contacts, deformable)
    force = chain.static_forces(contacts, 2.0, 9.81)
    overlap = closed_forms.static_overlaps(contacts, 2.0, 9.81, 1e5, deformable)
    assert overlap == pytest.approx(law @ force / 1e5)
    approach = (law @ np.ones(contacts)).sum() / 1e5  # under a force of 1 N
    assert 1 / approach == pytest.approx(chain.series_stiffness(contacts, 1e5, deformable))
