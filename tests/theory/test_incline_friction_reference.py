"""Friction and sizes on the incline: the reference DEM against shock and critical angle.

The plastic contact has dashpots far stronger than its springs. Its tangential dashpot is
beta / (1 + beta) of the normal one unless a test changes it.
"""

import math

import numpy as np
import pytest

from harness.model.law import Law
from harness.model.scene import Body, Scene
from harness.solvers import reference
from harness.theory import incline as coulomb
from harness.theory import incline as theory
from harness.theory.incline import Grain, State

SPHERE, DISC, GRAVITY = 0.4, 0.5, 9.81
ROW = tuple(Body(radius=1.0, mass=1.0, position=(x, 0, 0), motion="frozen") for x in (0.0, 2.0))
SYSTEMS = pytest.mark.parametrize(
    ("inertia", "ratio"), [(SPHERE, 1.0), (DISC, 1.0), (SPHERE, 2.0), (DISC, 0.85)]
)


def half_angle(ratio):
    return math.radians(theory.well_half_angle(ratio))


def contact(friction, inertia, zeta, stiffness, dashpot=None):
    share = inertia / (1 + inertia) if dashpot is None else dashpot
    law = Law.linear(stiffness, zeta, clipped=True)
    slider = {"tangential_damping": share, "friction": friction}
    return law.replace(tangential="linear_history", **slider) if friction else law


def on_sphere(angle, speed, rim, inertia, radius, overlap=0.0, ahead=0.0):
    """Return a grain of 1 kg on the first sphere, at an angle [rad] from the row's normal."""
    along = np.array([math.cos(angle), 0.0, -math.sin(angle)])
    outwards = np.array([math.sin(angle), 0.0, math.cos(angle)])
    place = (1.0 + radius - overlap) * outwards - ahead * along
    return Body(radius=radius, mass=1.0, inertia=inertia * radius**2, position=tuple(place),
                velocity=tuple(speed * along),
                angular_velocity=(0.0, rim / radius, 0.0))  # fmt: skip


def after_shock(friction, inertia, ratio, zeta=100.0, stiffness=1e6, dashpot=None):
    """Return speeds of centre and rim after the shock, of a grain that rolled at 1 m/s."""
    phi, count = half_angle(ratio), int(1000 * zeta)
    step = 2 * math.pi / math.sqrt(stiffness) / count
    grain = on_sphere(phi, 1.0, 1.0, inertia, ratio, ahead=0.5 * step)
    law = contact(friction, inertia, zeta, stiffness, dashpot)
    scene = Scene(bodies=(grain, *ROW), law=law, step=step, steps=count, every=count)
    motion = reference.run(scene)
    along = np.array([math.cos(phi), 0.0, math.sin(phi)])
    return motion.velocity[-1, 0] @ along, motion.angular_velocity[-1, 0, 1] * ratio


@SYSTEMS
@pytest.mark.parametrize("share", [0.0, 0.5, 0.95, 1.05, 10.0])  # of the friction that sticks
def test_shock(inertia, ratio, share):
    half = theory.well_half_angle(ratio)
    friction = share * theory.sticking_friction(half, inertia)
    expected = coulomb.after_shock(
        State(0.0, 1.0, 1.0), Grain(friction, inertia), half_angle(ratio)
    )
    assert after_shock(friction, inertia, ratio) == pytest.approx(expected, abs=2e-5)
    assert (expected[0] == expected[1]) is (share > 1)
    if share in (0.0, 10.0):
        kept = theory.kept_speed(half, inertia if share else 0.0)
        assert expected[0] == pytest.approx(kept, rel=1e-14)


def test_shock_converges_with_stiffness_and_dashpot():
    soft, stiff = (after_shock(0.5, SPHERE, 1.0, stiffness=k)[0] for k in (1e2, 1e6))
    assert abs(stiff**2 - 81 / 196) < 1e-5 < abs(soft**2 - 81 / 196)
    weak, strong = (after_shock(0.1, SPHERE, 1.0, zeta=z)[0] for z in (5.0, 50.0))
    rigid = coulomb.after_shock(State(0.0, 1.0, 1.0), Grain(0.1, SPHERE), half_angle(1.0))[0]
    assert weak - rigid > 50 * abs(strong - rigid)  # as 1 / zeta^2
    speed, rim = after_shock(1.0, SPHERE, 1.0, zeta=5.0, dashpot=1.0)  # rolls at once thereafter
    assert ((speed + SPHERE * rim) / (1 + SPHERE)) ** 2 == pytest.approx(0.41329, abs=5e-6)


@pytest.mark.parametrize("friction", [0.1, 0.3])
def test_equal_dashpots_transmit_only_a_part_of_coulombs_impulse(friction):
    gained = after_shock(friction, SPHERE, 1.0, dashpot=1.0)[0] - 0.5
    limit = friction * math.sin(2 * half_angle(1.0))
    assert gained == pytest.approx(SPHERE / (1 + SPHERE) * limit, abs=2e-5)
