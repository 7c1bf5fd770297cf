"""Laws in Yade's words, by the formulas that Yade mixes and combines them with."""

import math

import pytest

from harness.engines.yade.engine import Yade, words
from harness.errors import Unsupported
from harness.model.scene import Wall
from tests.engines.struck import SPRING, struck_floor, struck_pair
from tests.solvers.reference.scenes import HERTZ, HOOKE

ROLLS = {"rolling": "sds", "rolling_damping": 0.0, "rolling_friction": 0.1,
         "rolling_stiffness": 2e4}  # fmt: skip


def series(first, second):
    """Return a coefficient of two materials as Yade makes it: one of 0 is left out."""
    shares = [1.0 / value for value in (first, second) if value]
    return 1.0 / sum(shares) if shares else 0.0


@pytest.mark.parametrize("damping", ["velocity", "mass_velocity", "damping_ratio"])
@pytest.mark.parametrize("size", [1.0, 0.6])
def test_dashpots_in_series_are_those_of_the_law(damping, size):
    law = HOOKE.replace(damping=damping, damping_coefficient=0.3, clipped=True)
    ceiling = Wall(point=(0.0, 0.0, 3.3e-2), direction=(0.0, 0.0, -1.0))
    pair = struck_pair(law, size)
    scene = pair.replace(walls=(Wall(point=(0.0, 0.0, -1.1e-2)), ceiling))
    first, second, floor, top = (material["cn"] for material in words(scene)["materials"])
    masses = [body.mass for body in scene.bodies]
    both = masses[0] * masses[1] / sum(masses)
    expected = [(first, second, both), (first, floor, masses[0]), (second, top, masses[1])]
    for one, other, mass in expected:
        assert series(one, other) == pytest.approx(law.dashpot(mass, 1.0, 0.0), rel=1e-12)


def test_rolling_and_twisting_springs_are_those_of_the_law():
    law = HOOKE.replace(**SPRING, **ROLLS)
    scene = struck_pair(law, 0.6)
    first, second = words(scene)["materials"]
    one, other = (body.radius for body in scene.bodies)
    reduced = one * other / (one + other)
    assert 2.0 * series(first["young"] * one, second["young"] * other) == pytest.approx(1e5)
    assert first["alphaKr"] * 3e4 * one * other == pytest.approx(2e4 * reduced**2)
    limits = first["etaRoll"] * one, second["etaRoll"] * other
    assert limits == pytest.approx((0.1 * reduced, 0.1 * reduced))


def test_restitution_and_friction_of_each_body():
    law = HOOKE.replace(damping="coeff_restitution", restitution=0.5, partner_restitution=0.9,
                        clipped=True)  # fmt: skip
    scene = struck_pair(law)
    first, second = words(scene)["materials"]
    assert (first["en"], second["en"]) == (0.5, 0.9)
    mass = 0.5 * scene.bodies[0].mass  # Pournin and others (2001), equation 19
    assert mass * (math.pi**2 + math.log(0.7) ** 2) / first["tc"] ** 2 == pytest.approx(1e5)
    law = HOOKE.replace(**{**SPRING, "friction": 0.6}, partner_friction=0.2)
    angles = [material["frictionAngle"] for material in words(struck_floor(law))["materials"]]
    assert angles == [math.atan(0.6), math.atan(0.2)]


def test_constant_torque_of_rolling_has_one_arm():
    law = HOOKE.replace(**SPRING, rolling="constant", rolling_friction=0.1)
    scene = struck_pair(law, 0.6)
    one, other = (body.radius for body in scene.bodies)
    arms = [material["mR"] for material in words(scene)["materials"]]
    assert arms == pytest.approx([0.1 * one * other / (one + other)] * 2)
    with pytest.raises(Unsupported, match="of one R"):
        words(scene.replace(walls=(Wall(),)))


def test_conventions_go_by_the_law():
    assert Yade.rules(struck_floor(HOOKE)).wall_lever == "height"
    assert Yade.rules(struck_floor(HOOKE)).wall_curvature == 0.0
    assert Yade.rules(struck_floor(HERTZ)).wall_curvature == 1e-8
    assert Yade.rules(struck_floor(HOOKE.replace(**SPRING, **ROLLS))).wall_lever == "contact_point"
