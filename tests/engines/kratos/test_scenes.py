"""Laws in Kratos's words, and the script that runs them, with a stand-in for Kratos."""

import json
import math
from unittest.mock import MagicMock

import numpy as np
import pytest

from harness.engines.kratos import run_scenes
from harness.engines.kratos.engine import AT_WALLS, BETWEEN_SPHERES, words
from harness.engines.kratos.engine import Kratos as Engine
from harness.engines.process import Ended
from harness.errors import EngineInputError, EngineMissingError, EngineNaNError, Unsupported
from harness.model.motion import Motion
from harness.model.scene import Wall
from harness.solvers import reference
from tests.engines.struck import struck_floor, struck_pair
from tests.solvers.reference.scenes import HERTZ, HOOKE, LINEAR, difference, guided

SPRING = {"tangential": "linear_history", "friction": 0.3}


class Node:
    """A node of Kratos: its place, and values of variables by name."""

    def __init__(self, number, x, y, z):
        self.number, self.X, self.Y, self.Z = number, x, y, z
        self.values, self.fixed = {}, set()

    def SetSolutionStepValue(self, name, _, value):
        self.values[name] = value

    def GetSolutionStepValue(self, name):
        return self.values.get(name, 0.0)

    def Fix(self, name):
        self.fixed.add(name)


class Kratos:
    """What the script uses of Kratos, with spheres that fly without contacts.

    The forces of the stand-in are weights: Kratos's total forces have them too.
    """

    def __init__(self, scene):
        self.scene, self.nodes = scene, []
        parts = [MagicMock() for _ in run_scenes.PARTS]
        parts[0].CreateNewNode.side_effect = self.add
        self.core = MagicMock(spec_set=["Model", "Properties", "VariableUtils", "Array3",
                                        "Parameters", *self.names("core")])  # fmt: skip
        self.core.Model.return_value.CreateModelPart.side_effect = parts
        self.dem = MagicMock()
        self.dem.IterativeSolverStrategy.return_value.SolveSolutionStep.side_effect = self.step
        self.dem.IterativeSolverStrategy.return_value.Initialize.side_effect = self.weigh
        for module, where in ((self.core, "core"), (self.dem, "dem")):
            for name in self.names(where):
                setattr(module, name, name)

    @staticmethod
    def names(where):
        moved = [
            f"{n}_{a}" for n in ("VELOCITY", "ANGULAR_VELOCITY", "TOTAL_FORCES") for a in "XYZ"
        ]
        moments = [f"PARTICLE_MOMENT_{axis}" for axis in "XYZ"]
        return [*moved, "RADIUS", "TIME_STEPS"] if where == "core" else moments

    def add(self, *given):
        self.nodes.append(Node(*given))
        return self.nodes[-1]

    def weigh(self):
        for node, body in zip(self.nodes, self.scene.bodies, strict=True):
            for axis, g in zip("XYZ", self.scene.gravity, strict=True):
                node.values[f"TOTAL_FORCES_{axis}"] = body.mass * g

    def step(self):
        h = self.scene.step
        for node in self.nodes:
            for axis, g in zip("XYZ", self.scene.gravity, strict=True):
                name = f"VELOCITY_{axis}"
                kick = 0.0 if name in node.fixed else 0.5 * h * g
                middle = node.values[name] + kick
                setattr(node, axis, getattr(node, axis) + h * middle)
                node.values[name] = middle + kick


def motion_in_stand_in(scene):
    row = json.loads(scene.model_dump_json()) | {"code": words(scene)}
    kratos = Kratos(scene)
    samples = run_scenes.Simulation(kratos.core, kratos.dem, row).run()
    assert samples.pop("step") == list(range(0, scene.steps + 1, scene.every))
    time = scene.step * scene.every * np.arange(scene.steps // scene.every + 1)
    names = ("position", "velocity", "angular_velocity", "force", "torque")
    return Motion(time, *(np.array(samples[name]) for name in names))


def without_contact(scene):
    return scene.replace(walls=(Wall(point=(0.0, 0.0, -1.0)),))


STILL = (0.0, 0.0, 0.0)
LED = guided(HOOKE, (20, (0.1, 0.0, 0.2), (1.0, 2.0, 3.0)), (30, (0.0, -0.1, 0.0), STILL), every=5)


@pytest.mark.parametrize("scene", [without_contact(struck_floor(HOOKE)), without_contact(LED)])
def test_samples_are_those_of_velocity_verlet(scene):
    assert difference(motion_in_stand_in(scene), reference.run(scene)) < 1e-13


def test_both_scripts_read_segments_alike():
    from harness.engines.yade.run_scenes import segments_by_step

    row = json.loads(LED.model_dump_json())
    assert run_scenes.segments_by_step(row) == segments_by_step(row)


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
    ("law", "reason"),
    [
        (LINEAR.replace(clipped=True), "tied to the normal one, and limited twice"),
        (HERTZ.replace(tangential="mindlin"), "takes tangential = none or mindlin_rescale/force"),
        (HERTZ.replace(damping="tsuji", restitution=0.5), "none or coeff_restitution, not tsuji"),
        (HOOKE.replace(**SPRING, partner_friction=0.1), "of each pair, and mixes none"),
        (HERTZ.replace(normal="jkr", surface_energy=0.1), "takes normal = dmt, not jkr"),
    ],
)
def test_law_that_it_cannot_state(law, reason):
    with pytest.raises(Unsupported, match=reason):
        words(struck_floor(law))


@pytest.mark.parametrize(
    ("said", "kind"),
    [
        ("ModuleNotFoundError: No module named 'KratosMultiphysics'", EngineMissingError),
        ("RuntimeError: Error: value is not a number", EngineNaNError),
        ("RuntimeError: Error: The element has no neighbour", EngineInputError),
    ],
)
def test_end_of_a_process(said, kind):
    with Engine() as engine:
        assert isinstance(engine.error_of(Ended(said, 1, 0.1, timed_out=False), ""), kind)
        assert engine.error_of(Ended("", 0, 0.1, timed_out=False), "") is None
