"""A coefficient off by 1e-6 moves the motion of a scene: every coefficient of the law."""
# ruff: noqa: I001

import pytest

from harness.model.law import COEFFICIENTS
from harness.model.scene import Scene
from harness.solvers import reference
from tests.solvers.reference.scenes import (
    DMT, HERTZ, JKR, LEADS, LINEAR, MDR, MINDLIN, R, ROLLS, STILL, TWISTS, YIELDS, difference,
    guided, impact,
)  # fmt: skip

ASLANT = (0.5, 0.3, -1.0)
TSUJI = HERTZ.replace(damping="tsuji", restitution=0.5)
WARM = HERTZ.replace(heat="radius", conductance=500.0)


def slanted(law):
    return impact(law, ASLANT, every=20, spin=(9.0, 5.0, 7.0))


def led(law):
    return guided(law, *LEADS, partner="sphere", step=1e-5)


SHALLOW = 4 * R - 5.1e-4  # psi of an elastic side at the depth d is (4 R - 2 d) / (4 R - d)
SHARE = (SHALLOW - 5.1e-4) / SHALLOW * (1.0 - 5e-7)


def confined(law):
    """Return a sphere on its way into the floor, which it leaves dented."""
    return guided(law, (1000, (0.0, 0.0, -1.0), STILL), (200, (0.0, 0.0, 1.0), STILL), every=20)


def warmed(law):
    scene = guided(law, (500, STILL, STILL), partner="sphere", every=50)
    first, second = scene.bodies
    return scene.replace(bodies=(first.replace(temperature=400.0), second))


SCENES = {
    "normal_stiffness": (slanted, LINEAR),
    "normal_modulus": (slanted, HERTZ.replace(normal_modulus=1e8)),
    "youngs_modulus": (slanted, MINDLIN),
    "poisson_ratio": (slanted, MINDLIN),
    "partner_youngs_modulus": (slanted, MINDLIN.replace(partner_youngs_modulus=4e8)),
    "partner_poisson_ratio": (slanted, MINDLIN.replace(partner_poisson_ratio=0.1)),
    "surface_energy": (led, JKR),
    "yield_stress": (confined, YIELDS),
    "bulk_share": (confined, MDR.replace(bulk_share=SHARE)),
    "damping_coefficient": (slanted, LINEAR),
    "restitution": (slanted, TSUJI),
    "partner_restitution": (slanted, TSUJI.replace(partner_restitution=0.8)),
    "tangential_stiffness": (slanted, LINEAR),
    "tangential_modulus": (slanted, MINDLIN.replace(tangential_modulus=3e8)),
    "tangential_damping": (slanted, LINEAR),
    "friction": (slanted, MINDLIN),
    "partner_friction": (slanted, MINDLIN.replace(partner_friction=0.2)),
    "rolling_stiffness": (slanted, LINEAR.replace(**ROLLS)),
    "rolling_damping": (slanted, LINEAR.replace(**ROLLS)),
    "rolling_friction": (slanted, LINEAR.replace(**ROLLS)),
    "twisting_stiffness": (led, LINEAR.replace(**TWISTS)),
    "twisting_damping": (led, LINEAR.replace(**TWISTS)),
    "twisting_friction": (led, LINEAR.replace(**TWISTS)),
    "conductance": (warmed, WARM),
}


def test_every_coefficient_has_a_scene():
    assert set(SCENES) == COEFFICIENTS


@pytest.mark.parametrize("name", SCENES)
def test_coefficient(name):
    make, law = SCENES[name]
    scene = make(law)
    off = law.replace(**{name: getattr(law, name) * (1.0 + 1e-6)})
    assert difference(reference.run(scene), reference.run(scene.replace(law=off))) > 1e-9


@pytest.mark.parametrize(
    "normal", [JKR, DMT, MDR.replace(surface_energy=0.5), YIELDS.replace(bulk_share=0.3)]
)
def test_coefficients_of_every_normal_force(normal):
    scene = confined(normal) if normal.yield_stress else led(normal)
    for name in {"surface_energy", "yield_stress", "youngs_modulus", "poisson_ratio"}:
        value = getattr(normal, name)
        if value is not None:
            off = scene.replace(law=normal.replace(**{name: value * (1.0 + 1e-6)}))
            assert difference(reference.run(scene), reference.run(off)) > 1e-9, name


@pytest.mark.parametrize("name", ["radius", "mass", "inertia", "position", "velocity"])
def test_bodies(name):
    scene = slanted(MINDLIN)
    body = scene.bodies[0]
    value = body.moment_of_inertia if name == "inertia" else getattr(body, name)
    near = value * (1.0 + 1e-6) if isinstance(value, float) else (value[0] * (1 + 1e-6), *value[1:])
    off = scene.replace(bodies=(body.replace(**{name: near}),))
    assert isinstance(off, Scene)
    assert difference(reference.run(scene), reference.run(off)) > 1e-10
