"""Steps in the plane: the same motion as by the steps of any scene, and stages that end a run."""

import math
from itertools import product

import numpy as np
import pytest

from harness.errors import EngineNaNError
from harness.model.conventions import Rules
from harness.model.law import Law
from harness.model.scene import LOOK, Body, Scene, Wall
from harness.solvers import plane, reference
from tests.solvers.reference.scenes import G, climbing, difference, on_row

SCHEMES = ("velocity_verlet", "mfix_euler", "mfix_adams_bashforth")
LEVERS = {"torque_lever": "radius", "velocity_lever": "contact_point"}
SLIDES = Law(normal_stiffness=1e4, damping="coeff_restitution", restitution=0.6,
             tangential="linear_history", friction=0.2, tangential_damping=0.4)  # fmt: skip


def heap(law, **more):
    """Return five spheres that fall onto two held ones, with spins, in a periodic box."""
    places = [(0.4, 0.95), (1.6, 1.0), (1.0, 1.9), (2.5, 1.2), (2.9, 2.3)]
    free = [
        Body(radius=0.5 - 0.02 * k, mass=1.0 + 0.3 * k, position=(x, y, 0.0),
             velocity=(0.3 * k - 0.5, -0.4, 0.0), angular_velocity=(0.0, 0.0, 2.0 - k))
        for k, (x, y) in enumerate(places)
    ]  # fmt: skip
    held = [
        Body(radius=0.5, mass=1.0, position=(x, 0.0, 0.0), motion=motion)
        for x, motion in ((0.0, "held"), (1.1, "frozen"), (2.1, "held"))
    ]
    return Scene(bodies=(*free, *held), law=law, step=5e-4, steps=2000, every=100,
                 gravity=(0.5, -G, 0.0), period=(3.3, None, None), **more)  # fmt: skip


def both(monkeypatch, scene, rules):
    """Return the motion in the plane and that by the steps of any scene."""
    assert reference.Simulation(scene, rules)._plane is not None
    fast = reference.run(scene, rules)
    with monkeypatch.context() as patch:
        patch.setattr(plane, "is_planar", lambda *_: False)
        return fast, reference.run(scene, rules)


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize(
    "law",
    [SLIDES, SLIDES.replace(friction=1e3), SLIDES.replace(clipped=True),
     SLIDES.replace(tangential="linear_nohistory", friction=0.5), Law.linear(1e4, 0.1, False)],
)  # fmt: skip
def test_motion_is_that_of_the_steps_of_any_scene(monkeypatch, scheme, law):
    fast, slow = both(monkeypatch, heap(law), Rules(scheme=scheme))
    assert difference(fast, slow) < 1e-10  # round-off, which collisions multiply
    assert np.ptp(slow.angular_velocity[:, 0, 2]) > 0.1 or law.tangential == "none"


@pytest.mark.parametrize(
    ("cap", "own"), [*product(("inside", "sticking_only"), ("infinite", "own"))]
)
def test_conventions_are_the_same(monkeypatch, cap, own):
    rules = Rules(damping_in_cap=cap, frozen_mass=own, least_overlap=1e-15, **LEVERS)
    scene = on_row(1e5, ratio=0.4, clipped=False, friction=0.15, wells=4, every=50)
    fast, slow = both(monkeypatch, scene, rules)
    assert difference(fast, slow) < 1e-11
    assert fast.stages == pytest.approx(slow.stages, abs=1e-11)


def test_setups_are_the_same(monkeypatch):
    scene = heap(SLIDES, setups=(300, 1111))
    fast, slow = both(monkeypatch, scene, Rules())
    assert difference(fast, slow) < 1e-9
    assert difference(fast, reference.run(scene.replace(setups=()))) > 1e-6


def test_columns_are_the_same(monkeypatch):
    """A grain over columns of three whose spheres move along y alone, neighbours by index."""
    row = on_row(1e5, ratio=0.3, clipped=False, steps=3000, every=50)
    grain, *tops = row.bodies
    below = [
        top.replace(position=(top.position[0], -1.0 * depth, 0.0), axes=(False, True, False),
                    motion="frozen" if depth == 2 else "free")
        for top in tops for depth in range(3)
    ]  # fmt: skip
    pairs = [(0, 1 + 3 * c) for c in range(10)]
    pairs += [(1 + 3 * c + j, 2 + 3 * c + j) for c in range(10) for j in range(2)]
    scene = row.replace(bodies=(grain, *below), pairs=tuple(pairs))
    fast, slow = both(monkeypatch, scene, Rules(least_overlap=1e-15))
    assert difference(fast, slow) < 1e-10
    assert np.ptp(fast.position[:, 1:, 0], axis=0).max() == 0.0
    assert np.ptp(fast.position[:, 1:, 1], axis=0).max() > 1e-5


@pytest.mark.parametrize(
    "change",
    [{"walls": (Wall(),)}, {"drag": 0.1}, {"gravity": (0.0, 0.0, -G)},
     {"law": SLIDES.replace(tangential="linear_history_classic")},
     {"law": Law(normal="hertz", youngs_modulus=1e6, poisson_ratio=0.3)}],
)  # fmt: skip
def test_other_scenes_are_not_of_the_plane(change):
    assert reference.Simulation(heap(SLIDES).replace(**change))._plane is None


def test_projected_springs_are_not_of_the_plane_but_without_friction():
    rules = Rules(spring_frame="projected")
    assert reference.Simulation(heap(SLIDES), rules)._plane is None
    assert reference.Simulation(heap(Law.linear(1e4, 0.1, False)), rules)._plane is not None


# ---- stages


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


def test_overflow_in_the_last_stage_is_an_error():
    scene = climbing((1e300, 0.0)).replace(step=1e10, gravity=(1e300, 0.0, 0.0))
    with pytest.raises(EngineNaNError, match="finite"):
        reference.run(scene)


def test_simulation_in_pieces_is_the_same(monkeypatch):
    """Also where memory for samples is taken in small pieces."""
    scene = on_row(wells=3, steps=80_000, every=7)
    whole = reference.run(scene)
    monkeypatch.setattr(reference, "NUMBERS_AT_ONCE", 5000)
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
