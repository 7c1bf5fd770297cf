"""Each convention, each known defect and other coefficients in a scene that they move."""
# ruff: noqa: I001

import math

import numpy as np
import pytest

from harness.model.conventions import Faults, Rules
from harness.model.law import COEFFICIENTS
from harness.model.scene import Scene, Segment, Stage, Wall, sphere
from harness.solvers import reference
from tests.cases.contacts.common import CASES
from tests.solvers.reference.scenes import (
    DAMPED, DMT, HERTZ, HOOKE, JKR, LEADS, LINEAR, MASS, MDR, MINDLIN, R, RHO, ROLLS, STILL, TORQUE,
    TWISTS, VISCOUS, YIELDS, difference, guided, impact,
)  # fmt: skip

ASLANT, ALL = (0.5, 0.3, -1.0), {**ROLLS, **TWISTS}
TORSION, RESCALED = LINEAR.replace(**ALL), MINDLIN.replace(tangential="mindlin_rescale")
TSUJI = HERTZ.replace(damping="tsuji", restitution=0.5)
CLASSIC = LINEAR.replace(tangential="linear_history_classic")
DASHPOT = HOOKE.replace(**DAMPED)
ADHERES, DOWN = MDR.replace(surface_energy=0.5), (0.0, 0.0, -1.0)


def led(law, factor=1, partner="sphere", step=1e-5, **more):
    """Return a sphere led past another, in ``factor`` times as many steps as need be."""
    pieces = [(factor * n, v, w) for n, v, w in LEADS]
    return guided(law, *pieces, partner=partner, step=step / factor, every=factor, **more)


def rolled(factor=1, law=TORSION, turns=0.5, legs=40):
    """Return a sphere that is led on an arc about another, and rolls, slips and twists there."""
    law = law.replace(friction=1e3, rolling_friction=1e3, twisting_friction=1e3)
    reach, steps, h = 2 * R - 1e-5, 5 * factor, 1e-4 / factor
    angles = np.linspace(0.0, turns, legs + 1)
    places = np.stack([0.8 * np.sin(angles), 0.6 * np.sin(angles), np.cos(angles)], axis=1)
    ways = np.diff(reach * places - [0.0, 0.0, R], axis=0) / (steps * h)
    spin = (30.0, 45.0, 25.0)
    return guided(law, *((steps, tuple(way), spin) for way in ways), partner="sphere", step=h,
                  every=steps)  # fmt: skip


def slanted(law, factor=1, partner="wall", **more):
    every = 20 * factor
    return impact(law, ASLANT, 100 * factor, partner=partner, every=every, spin=(9.0, 5.0, 7.0),
                  **more)  # fmt: skip


def disc():
    """Return a disc that hits the floor aslant."""
    scene = slanted(LINEAR)
    body = scene.bodies[0].replace(inertia=0.5 * MASS * R**2)
    return scene.replace(bodies=(body,))


def touching(overlap, speed=1.0, law=DASHPOT, partner="wall"):
    """Return a sphere that just touches the floor, or another sphere, and leaves it."""
    scene = impact(law, DOWN, 100, every=1, partner=partner)
    first = sphere(R, RHO, position=(0.0, 0.0, R - overlap), velocity=(0.0, 0.0, speed))
    return scene.replace(bodies=(first, *scene.bodies[1:]))


def sliding(factor):
    """Return a sphere that slides on the floor as the run begins."""
    body = sphere(R, RHO, position=(0.0, 0.0, R - 1e-6), velocity=(1.0, 0.0, 0.0))
    return slanted(LINEAR, factor).replace(bodies=(body,))


def watched(factor):
    """Return a sphere that a look finds on its way back, before its impact is over."""
    body = sphere(R, RHO, position=(-R, 0.0, 0.0), velocity=(1.0, 0.0, 0.0))
    scene = impact(DASHPOT, DOWN, 80 * factor)
    return scene.replace(bodies=(body,), walls=(Wall(direction=(-1.0, 0.0, 0.0)),), every=10,
                         steps=100 * factor, stages=(Stage(place=1.0, floor=-1.0),))  # fmt: skip


def pressed(law, depth, steps=2000, back=0.5):
    """Return a sphere that is pressed to a depth [m] and pulled back."""
    h, lift = 1e-6, back * depth / (steps * 1e-6)
    return guided(law, (steps, (0.0, 0.0, -depth / (steps * h)), STILL),
                  (steps, (0.0, 0.0, lift), STILL), overlap=1e-9, every=20)  # fmt: skip


def squeezed(law, depth, steps=4000):
    """Return a sphere that two plates press flat, one to a depth [m], the other less deep."""
    speed, top = depth / steps / 1e-6, (0.0, 0.0, 2 * R)
    walls = (Wall(velocity=(0.0, 0.0, speed)),
             Wall(point=top, direction=DOWN, velocity=(0.0, 0.0, -0.8 * speed)))  # fmt: skip
    still = Segment(steps=steps, velocities=(STILL,), angular_velocities=(STILL,))
    return Scene(bodies=(sphere(R, RHO, position=(0.0, 0.0, R)),), walls=walls, law=law, step=1e-6,
                 steps=steps, every=50, segments=(still,))  # fmt: skip


def taken_along():
    """Return a sphere on a wall that moves, with a second setup on the way."""
    body = sphere(R, RHO, position=(0.04 + 1e-6, 0.0, 0.0))
    drum = Wall(shape="cylinder", radius=0.05, hollow=True, spin=(0.0, 0.0, 2.0))
    return Scene(bodies=(body,), walls=(drum,), law=LINEAR, step=1e-6, steps=200, every=20,
                 setups=(100,))  # fmt: skip


RULES = {  # field: (value, scene of a factor of steps, least difference, one limit of small steps)
    "scheme": [
        ("mfix_euler", lambda k: slanted(HERTZ.replace(**VISCOUS), k), 1e-3, True),
        ("mfix_adams_bashforth", lambda k: slanted(HERTZ.replace(**VISCOUS), k), 1e-4, True),
    ],
    "restitution_mean": [
        ("arithmetic", lambda k: slanted(TSUJI.replace(partner_restitution=0.9), k), 1e-3, False),
        ("least", lambda k: slanted(TSUJI.replace(partner_restitution=0.9), k), 1e-2, False),
    ],
    "friction_mean": [
        ("arithmetic", lambda k: slanted(MINDLIN.replace(partner_friction=0.1), k), 1e-3, False),
        ("least", lambda k: slanted(MINDLIN.replace(partner_friction=0.1), k), 1e-2, False),
    ],
    "damping_in_cap": [("sticking_only", lambda k: slanted(LINEAR, k), 5e-3, False)],
    "slides_in_setup": [(True, sliding, 0.1, False)],  # the first force, at any step
    "torque_lever": [("radius", lambda k: slanted(MINDLIN, k, "sphere"), 1e-4, False)],
    "velocity_lever": [("contact_point", lambda k: slanted(MINDLIN, k, "sphere"), 1e-4, False)],
    "wall_lever": [
        ("contact_point", lambda k: slanted(MINDLIN, k), 1e-3, False),
        ("height", lambda k: slanted(MINDLIN, k), 1e-3, False),
    ],
    "wall_spin": [("levered", lambda k: led(TORSION, k, "wall"), 1e-5, False)],
    "rolling_axis": [
        ("projected", lambda k: slanted(LINEAR.replace(**TORQUE), k), 1e-3, False),
        ("whole", lambda k: slanted(LINEAR.replace(**TORQUE), k), 1e-3, False),
    ],
    "rolling_load": [("elastic", lambda k: slanted(LINEAR.replace(**TORQUE), k), 1e-3, False)],
    "rolling_lever": [("shortened", lambda k: slanted(LINEAR.replace(**TORQUE), k), 1e-4, False)],
    "frozen_mass": [("own", lambda k: slanted(HERTZ.replace(**VISCOUS), k, "frozen"), 1e-2, False)],
    "wall_curvature": [(1e-8, lambda k: slanted(HERTZ, k), 1e-9, False)],
    "least_overlap": [(1e-15, lambda _: touching(R - np.nextafter(R, 0.0)), 1e-3, False)],
    "wall_touches_at_zero": [(True, lambda _: touching(0.0), 1e-3, False)],
    "bodies_touch_at_zero": [(True, lambda _: touching(0.0, partner="sphere"), 1e-3, False)],
    "spring_frame": [
        ("projected", lambda k: rolled(k), 1e-7, True),
        ("rotated", lambda k: rolled(k), 1e-4, False),
        ("finite_rotation", lambda k: rolled(k), 1e-9, True),
    ],
    "torsion_frame": [
        ("room", lambda k: rolled(k), 1e-5, False),
        ("rotated", lambda k: rolled(k), 1e-9, False),
    ],
    "slip_step": [("turned_arms", lambda k: rolled(k), 1e-7, True)],
    "rescaled_from": [("displacement", lambda k: slanted(RESCALED, k, "sphere"), 1e-7, True)],
    "looks_set_up": [(False, watched, 1e-5, True)],
    "mdr_wall_force": [("plain", lambda _: pressed(MDR, 0.02 * R), 1e-6, False)],
    "mdr_growth": [("whole", lambda _: squeezed(YIELDS, 0.8 * R), 1e-4, False)],
    "mdr_growth_steps": [(1.0, lambda _: pressed(YIELDS, 0.05 * R), 1e-6, True)],
}


def moved(scene, field, value):
    """Return how far a convention moves a scene, beside the others that it needs."""
    needs = Rules(wall_lever="height") if field == "rolling_lever" else Rules()
    plain = reference.run(scene, needs)
    return difference(plain, reference.run(scene, needs.replace(**{field: value})))


def test_every_convention_has_a_case():
    assert set(RULES) == set(Rules.model_fields)


@pytest.mark.parametrize("field", RULES)
def test_convention(field):
    for value, scene, least, one_limit in RULES[field]:
        far = moved(scene(1), field, value)
        assert far >= least
        if one_limit and field != "mdr_growth_steps":
            assert moved(scene(4), field, value) < 0.4 * far
    if field in ("damping_in_cap", "rescaled_from", "wall_spin", "frozen_mass"):
        assert moved(slanted(HERTZ), field, value) == 0.0  # which has no part that it concerns


def test_linear_dashpot_of_a_restitution_acts_where_bodies_just_touch():
    law = HOOKE.replace(damping="coeff_restitution", restitution=0.5)
    motion = reference.run(touching(0.0, -1.0, law), Rules(wall_touches_at_zero=True))
    assert motion.force[0, 0, 2] == pytest.approx(law.dashpot(MASS, R, 0.0), rel=1e-12)


AGAIN = ((5, (10.0, 0.0, 0.0), STILL), (2, (0.0, 0.0, 20.0), STILL), (10, (0.0, 20.0, 0.0), STILL),
         (2, (0.0, 0.0, -20.0), STILL))  # fmt: skip


def touched_again():
    """Return a sphere that is led along another, lifted off, and put back aside."""
    law = LINEAR.replace(friction=1e3, tangential_damping=0.0, damping="none",
                         damping_coefficient=None)  # fmt: skip
    return guided(law, *AGAIN, partner="sphere", overlap=2e-5)


FAULTS = {  # field: (value, scene, least difference)
    "tsuji_effective_mass": (True, lambda: impact(TSUJI, DOWN), 1e-2),
    "marshall_without_radius": (
        True, lambda: led(MINDLIN.replace(twisting="marshall"), partner="wall"), 1e-3),
    "twisting_limit_by_rate": (
        True, lambda: led(TORSION.replace(twisting_damping=0.0), partner="wall"), 1e-4),
    "tangential_radius": ("walls", lambda: slanted(CLASSIC), 1e-2),
    "cap_without_radius": ("all", lambda: slanted(MINDLIN.replace(friction=0.1)), 1e-3),
    "shear_factor": (1.1, lambda: slanted(MINDLIN, partner="sphere"), 1e-3),
    "wall_modulus_factor": (1.3, lambda: slanted(MINDLIN), 1e-2),
    "wall_shear_factor": (1.3, lambda: slanted(MINDLIN), 1e-3),
    "dmt_limit_without_pull_off": (
        True, lambda: led(DMT.replace(tangential="mindlin", friction=0.05)), 1e-3),
    "longest_neck": (0.0, lambda: pressed(JKR, 1e-6, back=2.0), 1e-2),
    "torsion_reversed_at": ((100,), lambda: led(TORSION), 1e-4),
    "springs_lost_in_setup": (
        True, lambda: slanted(MINDLIN, partner="sphere").replace(setups=(60,)), 1e-3),
    "wall_at_rest_in_setup": (True, taken_along, 1e-5),
    "parted_springs_kept": (True, touched_again, 1e-2),
    "rolling_by_rate": (True, lambda: slanted(LINEAR.replace(**TORQUE)), 1e-2),
    "forgets_setup": (True, lambda: rolled(1), 1e-5),
    "tsuji_again_in_setup": (True, lambda: impact(TSUJI, DOWN).replace(setups=(50,)), 1e-2),
    "setup_torque": ((0.0, 1e-3, 0.0), taken_along, 1e-4),
    "later_setup_torque": (
        (0.0, 1e-3, 0.0), lambda: taken_along().replace(setups=(50,)), 1e-4),
    "cylinder_shear": ((0.0, 0.0, 0.1), taken_along, 1e-2),
    "small_angle_quaternion": (True, lambda: rolled(20), 1e-9),
    "discs_turn_as_spheres": (True, disc, 1e-2),
    "mdr_damping_interchanged": (
        True, lambda: pressed(MDR.replace(damping="mdr", damping_coefficient=0.2), 1e-5), 1e-3),
    "mdr_sticking_share": (0.99, lambda: pressed(ADHERES, 1e-6, back=2.0), 1e-3),
    "mdr_newton_error": (1e-8, lambda: pressed(ADHERES, 1e-6, back=2.0), 1e-7),
    "mdr_parts_at_zero": (True, lambda: pressed(ADHERES, 1e-6, back=2.0), 1e-3),
}  # fmt: skip


def test_every_known_defect_has_a_case():
    assert set(FAULTS) == set(Faults.model_fields)


NEEDS = {"small_angle_quaternion": {"slip_step": "turned_arms"},
         "forgets_setup": {"torsion_frame": "room"}}  # fmt: skip


@pytest.mark.parametrize("field", FAULTS)
def test_known_defect(field):
    value, scene, least = FAULTS[field]
    rules = Rules(**NEEDS.get(field, {}))
    plain = reference.run(scene(), rules)
    assert difference(plain, reference.run(scene(), rules, Faults(**{field: value}))) >= least
    if field in ("tangential_radius", "cap_without_radius"):  # of walls alone it leaves pairs
        pair, faults = slanted(CLASSIC, partner="sphere"), Faults(**{field: "walls"})
        assert difference(reference.run(pair), reference.run(pair, None, faults)) == 0.0


@pytest.mark.parametrize("frame", ["projected", "finite_rotation"])
def test_a_contact_begins_with_the_spring_of_the_last_one_or_its_whole_force(frame):
    scene, rules = touched_again(), Rules(spring_frame=frame)
    motion = reference.run(scene, rules, Faults(parted_springs_kept=True))
    kept = motion.force[-1, 0] - reference.run(scene, rules).force[-1, 0]
    arms = motion.position[[5, -1], 0] + [0.0, 0.0, R]
    before, now = arms / np.linalg.norm(arms, axis=1)[:, None]
    force = motion.force[5, 0]
    stored = force if frame == "finite_rotation" else force - (force @ before) * before
    assert kept == pytest.approx(stored - (stored @ now) * now, abs=1e-4 * np.linalg.norm(force))
    assert np.linalg.norm(kept) > 0.1 * np.linalg.norm(force)


def test_short_neck_of_jkr_has_eight_ninths_of_the_tension():
    """At overlap 0 the tension is 8/9 of 3 pi gamma R*, where a list without a skin cuts a neck."""
    scene = pressed(JKR, 1e-6, 20_000, back=2.5).replace(every=1)
    force = reference.run(scene, None, Faults(longest_neck=0.0)).force[:, 0, 2]
    assert -force.min() == pytest.approx(8 / 9 * 3 * math.pi * 0.5 * R, rel=2e-3)


def test_setup_of_an_elastic_contact_changes_nothing():
    scene = impact(MDR.replace(bulk_share=1.0), (0.0, 0.0, -0.9), 100, partner="sphere")
    again = reference.run(scene.replace(setups=(scene.steps // 4,)))
    assert np.array_equal(again.velocity, reference.run(scene).velocity)


# ---- coefficients that no contact case has: off by 1e-6 they move a scene


SHALLOW = 4 * R - 5.1e-4  # psi of an elastic side at the depth d is (4 R - 2 d) / (4 R - d)
SHARE = (SHALLOW - 5.1e-4) / SHALLOW * (1.0 - 5e-7)


def confined(law):
    """Return a sphere on its way into the floor, which it leaves dented."""
    return guided(law, (1000, (0.0, 0.0, -1.0), STILL), (200, (0.0, 0.0, 1.0), STILL), every=20)


SCENES = [
    ("normal_modulus", slanted(HERTZ.replace(normal_modulus=1e8))),
    ("tangential_modulus", slanted(MINDLIN.replace(tangential_modulus=3e8))),
    ("bulk_share", confined(MDR.replace(bulk_share=SHARE))),
    *((name, confined(YIELDS.replace(bulk_share=0.3)))
      for name in ("yield_stress", "youngs_modulus", "poisson_ratio")),
]  # fmt: skip


def test_every_coefficient_is_tested_here_or_in_a_contact_case():
    laws = [trial.parameters.stated_law for case in CASES for trial in case.trials]
    in_cases = {name for name in COEFFICIENTS for law in laws if getattr(law, name)}
    assert in_cases | {name for name, _ in SCENES} == COEFFICIENTS


@pytest.mark.parametrize(("name", "scene"), SCENES)
def test_coefficient(name, scene):
    off = scene.law.replace(**{name: getattr(scene.law, name) * (1.0 + 1e-6)})
    assert difference(reference.run(scene), reference.run(scene.replace(law=off))) > 1e-9


def test_inertia_and_position():
    scene = slanted(MINDLIN)
    (body,), (x, y, z) = scene.bodies, scene.bodies[0].position
    for change in ({"inertia": body.moment_of_inertia * (1.0 + 1e-6)},
                   {"position": (x, y, z * (1.0 + 1e-6))}):  # fmt: skip
        off = scene.replace(bodies=(body.replace(**change),))
        assert difference(reference.run(scene), reference.run(off)) > 1e-10
