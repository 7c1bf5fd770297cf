"""Scenes: what is refused and how, laws by types, the largest step."""

import math

import pytest

from harness.errors import RequestError
from harness.model.conventions import Faults, Rules
from harness.model.law import Law
from harness.model.scene import Body, Scene, Segment, Wall, sphere
from harness.solvers import reference

LINEAR = Law(normal_stiffness=1e5)
BALL = sphere(0.01, 2500.0, position=(0.0, 0.0, 0.01), velocity=(0.0, 0.0, -1.0))
GOOD = {"bodies": (BALL,), "walls": (Wall(),), "law": LINEAR, "step": 1e-6, "steps": 10}
STILL = (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("values", "line"),
    [
        ({"step": 0.0}, "step = 0.0 s: must be greater than or equal to"),
        ({"step": 1e-3}, "step = 0.001 s: must be at most 0.000647"),
        ({"steps": 0}, "steps = 0: must be greater than or equal to 1"),
        ({"every": 0}, "every = 0: must be"),
        ({"gravity": (0.0, 0.0, math.nan)}, "gravity = nan m/s2: must be"),
        ({"bodies": ()}, "bodies = (): "),
        ({"bodies": (BALL.replace(motion="frozen"),)}, "bodies: at least one must be free"),
        ({"period": (0.03, None, None)}, "period = 0.03 m: must be at least 0.04 m"),
        ({"pairs": ((0, 1),)}, "pairs: must be two different indices from 0 to 0"),
        ({"walls": (Wall(shape="sphere", radius=0.005, hollow=True),)}, "greater than 0.01"),
        ({"law": Law.linear(1e5, 1.0, clipped=False)}, "must be below 1, critical damping"),
        ({"law": Law.linear(1e5, 1.5, clipped=False)}, "damping_coefficient = 1.5: must be"),
        ({"law": Law(normal="mdr"), "laws": {(1, 2): LINEAR}}, "laws: must be one"),
        ({"segments": (Segment(steps=9, velocities=(STILL,), angular_velocities=(STILL,)),)},
         "steps = 10: must be 9"),
        ({"segments": (Segment(steps=10, velocities=(), angular_velocities=()),)}, "of 1 bodies"),
    ],
)  # fmt: skip
def test_refused_in_one_line(values, line):
    with pytest.raises(RequestError) as error:
        Scene(**{**GOOD, **values})
    assert line in str(error.value)
    assert "\n" not in str(error.value)


def test_refused_walls_and_bodies():
    for make in (
        lambda: Wall(direction=STILL), lambda: Wall(radius=1.0), lambda: Wall(shape="sphere"),
        lambda: Wall(hollow=True), lambda: Wall(spin=(0.0, 0.0, 1.0)),
        lambda: Body(radius=-1.0, mass=1.0), lambda: Body(radius=1.0, mass=math.inf),
        lambda: Body(radius=1.0, mass=1.0, type=0), lambda: Rules(wall_lever="circle"),
        lambda: Faults(shear_factor=0.0), lambda: Rules(mdr_growth_steps=0.5),
    ):  # fmt: skip
        with pytest.raises(RequestError, match=": must "):
            make()


@pytest.mark.parametrize("partner", ["wall", "frozen", "held"])
@pytest.mark.parametrize("ratio", [0.0, 0.5, 0.9])
def test_steps_beyond_the_largest_are_unstable(partner, ratio):
    """A sphere held down by its weight stays below it, and leaves it above.

    A held partner has its mass in the dashpot alone: m/2 for m, the spring moves m.
    """
    below, walls = (), (Wall(),)
    if partner != "wall":
        base = BALL.replace(position=(0.0, 0.0, -0.01), velocity=STILL, motion=partner)
        below, walls = (base,), ()
    law, rest = Law.linear(1e5, ratio, clipped=False), 0.01 - BALL.mass * 9.81 / 1e5
    values = {"walls": walls, "law": law, "gravity": (0.0, 0.0, -9.81), "steps": 4000}
    scene = Scene(**{**GOOD, **values, "bodies": (BALL, *below)})
    for share, stays in ((0.98, True), (1.02, False)):
        near = BALL.replace(position=(0.0, 0.0, rest - 1e-8), velocity=STILL)
        step = share * scene.largest_step[0]
        trial = Scene.model_construct(**{**dict(scene), "bodies": (near, *below), "step": step})
        height = reference.run(trial).position[:, 0, 2]
        assert (abs(height - rest).max() < 2e-7) == stays


def test_overdamped_is_allowed_where_it_ends():
    assert Scene(**{**GOOD, "law": Law.linear(1e5, 1.5, clipped=True)}).duration > 0.0
    falls = {**GOOD, "gravity": (0.0, 0.0, -9.81), "law": Law.linear(1e5, 1.5, clipped=False)}
    assert Scene(**falls).duration == pytest.approx(1e-5)


def test_laws_by_types():
    scene = Scene(**GOOD, laws={(2, 1): Law(normal_stiffness=2.0)})
    assert scene.law_of(1, 2).normal_stiffness == scene.law_of(2, 1).normal_stiffness == 2.0
    assert scene.law_of(2, 2) == LINEAR
    assert hash(scene) == hash(scene.replace())
    assert Wall(direction=(0.0, 0.0, 3.0)).direction == (0.0, 0.0, 1.0)
