"""Scripts of scenes for LIGGGHTS: the law in its words, and coefficients by the law's formulas."""

import math
import re

import pytest

from harness.engines.liggghts.engine import script, words
from harness.errors import Unsupported
from tests.engines.struck import ROLLS, SPRING, TWISTS, struck_floor, struck_pair
from tests.solvers.reference.scenes import HERTZ, HOOKE, VISCOUS, guided, resting


def matrix(scene, name):
    """Return the coefficients of a property by pair of types."""
    line = re.search(rf"property/global {name} peratomtypepair (\d+) (.*)", script(scene))
    size, values = int(line[1]), [float(word) for word in line[2].split()]
    return [values[size * k : size * (k + 1)] for k in range(size)]


@pytest.mark.parametrize("damping", ["damping_ratio", "mass_velocity"])
def test_dashpots_are_those_of_the_law(damping):
    law = HOOKE.replace(damping=damping, damping_coefficient=0.2)
    scene = struck_pair(law, 0.6)
    first, second = (body.mass for body in scene.bodies)
    etas = matrix(scene, "gamman_abs")
    both = first * second / (first + second)
    for row, column, mass in ((0, 1, both), (1, 0, both), (0, 2, first), (1, 2, second)):
        share = 2.0 * math.sqrt(1e5 * mass) if damping == "damping_ratio" else mass
        assert etas[row][column] == pytest.approx(0.2 * share, rel=1e-14)


def test_frozen_mass_is_infinite_and_a_prescribed_one_its_own():
    law = HOOKE.replace(damping="mass_velocity", damping_coefficient=1.0)
    frozen = struck_pair(law, 1.0, "frozen")
    mass = frozen.bodies[0].mass
    assert matrix(frozen, "gamman_abs")[0][1] == mass
    led = guided(law, (10, (0.0, 0.0, -0.1), (0.0, 0.0, 0.0)), partner="sphere")
    assert matrix(led, "gamman_abs")[0][0] == pytest.approx(led.bodies[0].mass / 2.0)


@pytest.mark.parametrize(
    ("law", "models"),
    [
        (HOOKE, "model hooke/stiffness tangential off rolling_friction off"),
        (HOOKE.replace(**SPRING, **ROLLS, rolling_stiffness=3e4), "rolling_friction epsd2"),
        (HOOKE.replace(**SPRING, **ROLLS, rolling_stiffness=2250.0), "rolling_friction epsd"),
        (HOOKE.replace(**SPRING, **ROLLS, rolling_stiffness=1001.0), "rolling_friction epsd3"),
        (HERTZ.replace(rolling="constant", rolling_friction=0.1), "rolling_friction cdt"),
        (HERTZ.replace(**VISCOUS), "model hertz/stiffness tangential off"),
        (HERTZ.replace(tangential="mindlin"), "model hertz/stiffness tangential history"),
        (HERTZ.replace(damping="coeff_restitution"), "model hertz tangential off"),
    ],
)
def test_models(law, models):
    assert models in words(struck_floor(law)).models


def test_twisting_springs_need_the_vertical_line_of_centres():
    law = HOOKE.replace(**SPRING, **TWISTS, twisting_stiffness=3.0)
    assert "epsd2" in words(resting(law, 1e-3, 100, spin=(0.0, 0.0, 1.0))).models
    with pytest.raises(Unsupported, match="resist rolling as well"):
        words(resting(law, 1e-3, 100, spin=(0.1, 0.0, 1.0)))
