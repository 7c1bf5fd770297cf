"""Laws in Yade's words, and the script that Yade runs, with a stand-in for Yade."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

from harness.engines.yade import run_scenes
from harness.engines.yade.engine import Yade as Engine
from harness.engines.yade.engine import words
from harness.errors import Unsupported
from harness.model.motion import Motion
from harness.model.scene import Scene, Wall
from harness.solvers import reference
from tests.engines.struck import struck_floor, struck_pair
from tests.solvers.reference.scenes import HERTZ, HOOKE, climbing, difference, guided

SPRING = {"tangential": "linear_history", "tangential_stiffness": 3e4, "friction": 0.3}
ROLLS = {"rolling": "sds", "rolling_damping": 0.0, "rolling_friction": 0.1,
         "rolling_stiffness": 2e4}  # fmt: skip


class Vector(np.ndarray):
    def __new__(cls, *values):
        return np.array(values, float).view(cls)


class Yade:
    """What the script uses of Yade, with bodies that fly without contacts."""

    def __init__(self):
        self.O = SimpleNamespace(reset=lambda: None, dt=0.0, iter=0, bodies=[], engines=[])
        self.O.forces = SimpleNamespace(f=self.no_force, t=self.no_force)
        self.O.run, self.steps = self.run, []
        self.utils = SimpleNamespace(sphere=self.sphere, wall=self.part("Wall"),
                                     box=self.part("Box"))  # fmt: skip

    def __getattr__(self, name):
        return Vector if name == "Vector3" else self.part(name)

    @staticmethod
    def part(name):
        return lambda *given, **words: SimpleNamespace(kind=name, given=given, **words)

    def no_force(self, number, summed):
        assert summed
        assert number is not None
        return Vector(0.0, 0.0, 0.0)

    def sphere(self, place, radius, material, fixed, mask):
        assert mask in (1, 3)
        state = SimpleNamespace(pos=place, vel=None, angVel=None)
        return SimpleNamespace(id=len(self.O.bodies), state=state, radius=radius,
                               material=material, dynamic=not fixed)  # fmt: skip

    def run(self, steps, wait):
        assert wait
        newton = self.O.engines[-1]
        runners = [engine for engine in self.O.engines if engine.kind == "PyRunner"]
        due, self.paused = dict.fromkeys(range(len(runners)), 0), False
        self.O.pause = lambda: setattr(self, "paused", True)
        for _ in range(steps):
            self.steps.append(self.O.dt)
            for number, runner in enumerate(runners):
                if self.O.iter == due[number]:
                    getattr(self.simulation, runner.command[len("simulation.") : -2])()
                    due[number] = self.O.iter + runner.iterPeriod
            if self.paused:
                return
            for body in (body for body in self.O.bodies if hasattr(body, "state")):
                if body.dynamic:
                    body.state.vel = body.state.vel + self.O.dt * newton.gravity
                body.state.pos = body.state.pos + self.O.dt * body.state.vel
            self.O.iter += 1


def run_in_stand_in(scene):
    """Return the stand-in and the motion of a scene in which nothing touches."""
    yade = Yade()
    row = json.loads(scene.model_dump_json()) | {"code": words(scene)}
    yade.simulation = run_scenes.Simulation(yade, row)
    samples = yade.simulation.run()
    stages = np.array(samples["stages"])
    steps = np.arange(0, 1 + (stages[-1, 0] if scene.stages else scene.steps), scene.every)
    assert samples.pop("step") == steps.tolist()
    parts = (np.array(samples[name]) for name in run_scenes.PARTS)
    return yade, Motion(scene.step * steps, *parts, stages=stages if scene.stages else None)


def without_contact(scene):
    return scene.replace(walls=(Wall(point=(0.0, 0.0, -1.0)),))


FREE_FALL = without_contact(struck_floor(HOOKE))
LED = without_contact(
    guided(
        HOOKE,
        (20, (0.1, 0.0, 0.2), (1.0, 2.0, 3.0)),
        (30, (0.0, -0.1, 0.0), (0.0, 0.0, 4.0)),
        every=5,
    )
)


@pytest.mark.parametrize("scene", [FREE_FALL, LED, FREE_FALL.replace(every=7, steps=98)])
def test_samples_are_those_of_velocity_verlet(scene):
    _, motion = run_in_stand_in(scene)
    assert difference(motion, reference.run(scene)) < 1e-13


@pytest.mark.parametrize(
    ("steps", "stages"),
    [(1000, ((0.1, 0.0), (0.15, 0.0))), (1000, ((0.1, 0.0), (9.0, 1.1))), (333, ((9.0, 0.0),))],
)
def test_stages_are_those_of_the_reference(steps, stages):
    scene = climbing(*stages, steps=steps)
    _, motion = run_in_stand_in(scene)
    expected = reference.run(scene, Engine.rules(scene))
    assert motion.stages == pytest.approx(expected.stages, abs=1e-12)
    assert difference(motion, expected) < 1e-12


def test_first_forces_are_of_moving_bodies_in_a_step_of_no_length():
    yade, motion = run_in_stand_in(FREE_FALL)
    assert yade.steps[0] < 1e-40
    assert set(yade.steps[1:]) == {FREE_FALL.step}
    np.testing.assert_array_equal(motion.velocity[0, 0], FREE_FALL.bodies[0].velocity)


def test_segments_begin_where_others_end():
    row = json.loads(LED.model_dump_json())
    assert list(run_scenes.segments_by_step(row)) == [0, 20]
    assert run_scenes.segments_by_step(row)[20][0] == [[0.0, -0.1, 0.0]]


def test_samples_are_written_whole(tmp_path):
    run_scenes.write(tmp_path / "0.json", {"step": [0]})
    assert [path.name for path in tmp_path.iterdir()] == ["0.json"]


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
    assert Engine.rules(struck_floor(HOOKE)).wall_lever == "height"
    assert Engine.rules(struck_floor(HOOKE)).wall_curvature == 0.0
    assert Engine.rules(struck_floor(HERTZ)).wall_curvature == 1e-8
    assert (
        Engine.rules(struck_floor(HOOKE.replace(**SPRING, **ROLLS))).wall_lever == "contact_point"
    )


EACH = {"damping": "coeff_restitution", "restitution": 0.5, "partner_restitution": 0.9,
        "clipped": True}  # fmt: skip


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (struck_floor(HERTZ.replace(tangential="mindlin")), "tangential = none or mindlin/force"),
        (struck_floor(HOOKE.replace(tangential="linear_history_classic")), "linear_history, not"),
        (struck_floor(HOOKE.replace(**SPRING, **ROLLS).replace(rolling_damping=0.1)), "without a"),
        (struck_floor(HERTZ.replace(normal="dmt", surface_energy=0.1, tangential="mindlin/force")),
         "has dmt without dashpot and friction only"),
        (struck_floor(HERTZ.replace(normal="jkr", surface_energy=0.1)), "not jkr"),
        (struck_pair(HOOKE.replace(**SPRING, **ROLLS)).replace(walls=(Wall(),)), "has one R"),
        (struck_floor(HOOKE.replace(**EACH)), "of two free spheres without friction"),
        (struck_pair(HERTZ.replace(**EACH)), "gets the restitution of each pair, and mixes none"),
    ],
)  # fmt: skip
def test_scene_that_it_cannot_state(scene: Scene, reason):
    with pytest.raises(Unsupported, match=reason):
        words(scene)
