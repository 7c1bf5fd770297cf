"""Laws in Kratos's words, by the formulas of Kratos, and the end of its processes."""

import math

import pytest

from harness.engines.kratos.engine import AT_WALLS, BETWEEN_SPHERES, Kratos, words
from harness.engines.process import Ended
from harness.errors import EngineInputError, EngineMissingError, EngineNaNError, Unsupported
from harness.model.scene import Wall
from tests.engines.struck import struck_floor, struck_pair
from tests.solvers.reference.scenes import HOOKE

SPRING = {"tangential": "linear_history", "friction": 0.3}


def test_stiffness_of_spheres_and_walls_is_the_law_s():
    scene = struck_pair(HOOKE, 0.6).replace(walls=(Wall(point=(0.0, 0.0, -1.1e-2)),))
    code = words(scene)
    one, other = (body.radius for body in scene.bodies)
    share = 1.0 - code["poisson"] ** 2
    both = code["young"] / (2.0 * share)
    assert BETWEEN_SPHERES * both * one * other / (one + other) == pytest.approx(1e5)
    with_wall = 1.0 / (share / code["young"] + share / code["wall_young"][0])
    assert AT_WALLS * with_wall * one == pytest.approx(1e5)


@pytest.mark.parametrize("motion", ["free", "frozen"])
def test_dashpots_are_the_law_s(motion):
    law = HOOKE.replace(damping="damping_ratio", damping_coefficient=0.2, clipped=True)
    scene = struck_pair(law, 0.6, motion)
    first, second = (body.mass for body in scene.bodies)
    own = first * second / (first + second)
    gamma = words(scene)["gamma"][0][1]
    expected = law.dashpot(first if motion == "frozen" else own, 1.0, 0.0)
    assert 2.0 * gamma * math.sqrt(own * 1e5) == pytest.approx(expected)


def test_coefficient_of_rolling_is_over_the_radius():
    law = HOOKE.replace(**SPRING, rolling="constant", rolling_friction=0.1)
    assert words(struck_floor(law))["values"]["ROLLING_FRICTION"] == 0.1
    assert words(struck_pair(law))["values"]["ROLLING_FRICTION"] == pytest.approx(0.05)
    with pytest.raises(Unsupported, match="for spheres of one size"):
        words(struck_pair(law, 0.6))


@pytest.mark.parametrize(("stiffness", "law"), [(1.2e5, "viscous_Coulomb"), (1.4e5, "Custom")])
def test_law_goes_by_the_ratio_of_stiffnesses(stiffness, law):
    code = words(struck_floor(HOOKE.replace(**SPRING, tangential_stiffness=stiffness)))
    assert law in code["law"]
    if law == "viscous_Coulomb":
        nu = code["poisson"]
        assert 1e5 * 2.0 * (1.0 - nu) / (2.0 - nu) == pytest.approx(stiffness)


@pytest.mark.parametrize(
    ("said", "kind"),
    [
        ("ModuleNotFoundError: No module named 'KratosMultiphysics'", EngineMissingError),
        ("RuntimeError: Error: value is not a number", EngineNaNError),
        ("RuntimeError: Error: The element has no neighbour", EngineInputError),
    ],
)
def test_end_of_a_process(said, kind):
    with Kratos() as engine:
        assert isinstance(engine.error_of(Ended(said, 1, 0.1, timed_out=False), ""), kind)
        assert engine.error_of(Ended("", 0, 0.1, timed_out=False), "") is None
