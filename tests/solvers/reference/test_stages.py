"""Stages that end a run, a run in pieces, and the grain that rolls into a well."""

import math

import numpy as np
import pytest

from harness.errors import EngineNaNError
from harness.model.scene import LOOK
from harness.solvers import reference
from tests.solvers.reference.scenes import climbing, on_row


def test_stages_end_at_looks():
    motion = reference.run(climbing((0.1, 0.0), (0.15, 0.0)))
    steps, times, x, _, vx, _, spin = motion.stages.T
    assert steps.tolist() == [0, 150, 200]  # 0.1 m is passed at step 143, 0.15 m at 187
    assert times == pytest.approx(steps * 1e-3)
    assert x == pytest.approx(times - 1.05 * times**2, abs=1e-12)
    assert vx == pytest.approx(1.0 - 2.1 * times)
    assert (spin == 3.0).all()
    assert len(motion) == 21


@pytest.mark.parametrize(("floor", "last"), [(0.9, 1000), (1.1, 500)])
def test_body_that_moves_back_below_the_floor_ends_the_run(floor, last):
    """Its energy is 1 J: at the first look behind the turn it is below one floor, not the other."""
    motion = reference.run(climbing((10.0, floor)))
    assert motion.stages[:, 0].tolist() == [0, last]
    assert last % LOOK == 0


def test_last_look_is_at_the_last_step():
    motion = reference.run(climbing((10.0, 0.0), steps=333))
    assert motion.stages[-1, 0] == 333
    assert len(motion) == 34


def test_overflow_is_an_error():
    scene = climbing((1e300, 0.0)).replace(step=1e10, gravity=(1e300, 0.0, 0.0))
    for each in (scene, scene.replace(stages=())):
        with pytest.raises(EngineNaNError, match="finite"):
            reference.run(each)


def test_simulation_in_pieces_is_the_same():
    scene = on_row(wells=3, steps=80_000, every=7)
    whole = reference.run(scene)
    parts = reference.Simulation(scene)
    while not parts.over:
        parts.advance(777)
    motion = parts.motion()
    assert np.array_equal(motion.stages, whole.stages)
    assert np.array_equal(motion.position, whole.position)
    assert motion.stages[-1, 2] > 3.0
    assert len(motion) == int(motion.stages[-1, 0]) // 7 + 1


def test_friction_makes_the_grain_roll():
    """A shock from a well without slip leaves the share (c + beta) / (1 + beta) of the speed.

    c = cos 60 deg, beta = 2/5 (Quartier et al., Phys. Rev. E 62, 8299 (2000), with a rolling
    grain): 9/14 of a grain that rolls into the well, 1/2 without friction.
    """
    shares = []
    for friction in (None, 1e4):
        scene = on_row(1e7, angle=0.0, friction=friction, per_contact=200.0, steps=400)
        scene = scene.replace(gravity=(0.0, 0.0, 0.0))
        along = 1.0  # along the tangent at the sphere behind, into the sphere ahead
        grain = scene.bodies[0].replace(
            velocity=(along * math.sqrt(0.75), -0.5 * along, 0.0),
            angular_velocity=(0.0, 0.0, 0.0 if friction is None else -along / 0.5),
        )
        end = reference.run(scene.replace(bodies=(grain, *scene.bodies[1:]))).velocity[-1, 0]
        shares.append(math.sqrt(0.75) * end[0] + 0.5 * end[1])
    assert shares[0] == pytest.approx(0.5, abs=1e-3)
    assert shares[1] == pytest.approx(9.0 / 14.0, abs=5e-3)
