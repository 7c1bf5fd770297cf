"""Scenes of a few spheres and planes: what is refused, and what follows from the rest."""

import math

import pytest

from harness.errors import RequestError
from harness.parameters.law import ContactLaw
from harness.parameters.scene import Body, ContactScene, Plane, Segment, sphere_mass

BALL = Body(radius=0.5, mass=2.0, position=(0.0, 0.0, 0.5))
STILL = (0.0, 0.0, 0.0)


def scene(**changes):
    values = {"bodies": (BALL,), "planes": (), "law": ContactLaw(), "step": 0.1, "steps": 10}
    return ContactScene(**{**values, **changes})


def test_what_follows():
    assert BALL.inertia == pytest.approx(0.2)
    assert sphere_mass(0.5, 6.0 / math.pi) == pytest.approx(1.0)
    assert Plane((0, 0, 0), (0, 3, 4)).direction == pytest.approx((0, 0.6, 0.8))
    assert scene().duration == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Body(0.0, 1.0, STILL), "radius = 0.0: must be a finite number greater than 0"),
        (lambda: Body(1.0, math.inf, STILL), "mass = inf: must be a finite number"),
        (lambda: Body(1.0, 1.0, (0.0, math.nan, 0.0)), "position = .* three finite numbers"),
        (lambda: Plane(STILL, STILL), "normal = .*: a plane needs a direction"),
        (lambda: scene(bodies=(Body(1.0, 1.0, STILL, frozen=True),)), "at least one must be free"),
        (lambda: scene(step=-1.0), "step = -1.0 s: must be a finite number greater than 0"),
        (lambda: scene(steps=0), "steps = 0: must be at least 1"),
        (lambda: scene(segments=(Segment(10, (), ()),)), "for 1 bodies"),
        (lambda: scene(segments=(Segment(9, (STILL,), (STILL,)),)), "steps = 10: must be 9"),
    ],
)
def test_what_is_no_scene_is_refused(make, message):
    with pytest.raises(RequestError, match=message):
        make()
