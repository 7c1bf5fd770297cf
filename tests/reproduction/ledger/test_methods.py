import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from harness.reproduction.claims import PRINTED, SOURCES
from harness.reproduction.ledger import methods
from harness.reproduction.ledger.appendix import impulse_ratio_at
from harness.reproduction.ledger.background import collide
from harness.reproduction.ledger.methods import peak_error, pushes, rise_time
from harness.theory.incline import steady_energy


def test_rigidity_of_a_pressure_changes_with_the_unit_of_length():
    metres, centimetres = (
        SOURCES["eq-10"].printed(k=k, P=p) for k, p in ((1e5, 9.81), (1e3, 9.81e-4))
    )
    assert centimetres / metres == pytest.approx(100)


def test_crest_time_is_far_from_what_is_printed():
    time = SOURCES["eq-11"].printed(r=1.0, g=9.81)
    assert time == pytest.approx(0.0292157, abs=1e-7)
    # it grows as the root of r
    assert (0.41 / time) ** 2 == pytest.approx(197, abs=0.5)


@pytest.mark.parametrize("angle", [10.5, 12.0, 15.0])
def test_rise_time_by_integrating_the_motion(angle):
    start = math.radians(30 - angle)
    speed = math.sqrt(2 * steady_energy(angle, 0.25) * 9.81)

    def crest(_, state):
        return state[0]

    crest.terminal, crest.direction = True, -1
    # the angle left to the crest, on a sphere of 1 m about the one below
    motion = solve_ivp(
        lambda _, s: [s[1], 9.81 * math.sin(s[0])],
        (0, 60), [start, -speed], events=crest, rtol=1e-11, atol=1e-13,
    )  # fmt: skip
    assert motion.t[-1] == pytest.approx(rise_time(angle), rel=1e-8)


@pytest.mark.parametrize("ratio", [0.3, 0.54, 1.0])
def test_part_of_the_impulse_of_a_collision_leaves_the_energy_in_vectors(ratio):
    before = np.array([math.sqrt(3) / 2, -0.5])
    impulse = collide(before, 0.0) - before
    after = before + ratio * impulse
    assert after @ after == pytest.approx(0.25 + 0.75 * (1 - ratio) ** 2, abs=1e-15)
    (row,) = [
        r for r in methods.methods_scales_statements(PRINTED) if r.source.key == "eq-13-direction"
    ]
    assert row.found == pytest.approx(0.25 + 0.75 * 0.5**2)  # furthest off at one half


def test_pushes_obey_newtons_third_law():
    forces = pushes(np.array([0.0, 0.95, 1.88]))
    assert forces.sum() == pytest.approx(0, abs=0.05)
    assert forces[0] < 0 < forces[2]


def test_peak_error_depends_on_the_step_in_contact_times_alone():
    errors = [peak_error(k, 50.0) for k in (1e2, 1e4, 1e6)]
    assert errors == pytest.approx([errors[0]] * 3, rel=1e-6)


def test_impulse_ratio_depends_on_one_parameter_alone():
    values = [impulse_ratio_at(0.01, 4, "overlap", k) for k in (1e4, 1e7)]
    assert values[0] == pytest.approx(values[1], abs=1e-9)
