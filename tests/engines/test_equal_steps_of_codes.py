"""LIGGGHTS, Yade and Kratos against the reference at their own steps: every law that each states.

50 steps a contact, one run of each law in each system, all samples to 1e-9 of the scale.
"""

import numpy as np
import pytest

from harness.engines.base import scene_job
from harness.engines.kratos.engine import FAULTS as KRATOS_FAULTS
from harness.errors import CombinationError, Unsupported
from harness.model.conventions import Faults, Rules
from harness.model.law import Law
from harness.model.scene import Scene, Wall, sphere
from tests.engines.struck import ROLLS, SPRING, TWISTS, error, struck_floor, struck_pair
from tests.solvers.reference.scenes import (
    DAMPED,
    DMT,
    FLOOR,
    HERTZ,
    HOOKE,
    LEADS,
    LINEAR,
    RHO,
    TORQUE,
    VISCOUS,
    R,
    guided,
    resting,
)

pytestmark = [pytest.mark.live, pytest.mark.slow]

ALL = pytest.mark.parametrize("code", ["liggghts", "yade", "kratos"], indirect=True, scope="module")
TOLERANCE = 1e-9
FAULTS = {
    "kratos": KRATOS_FAULTS,
    "liggghts": Faults(forgets_setup=True),
    "yade": Faults(rolling_by_rate=True),
}

STIFF = {**SPRING, "tangential_stiffness": 2e5}
RESTITUTION = {"damping": "coeff_restitution", "restitution": 0.6}
CLIPPED = {**RESTITUTION, "clipped": True}
FRICTION = {"friction": 0.3}
OF_MATERIAL = {"tangential_damping": np.sqrt(2.0 * 0.7 / 1.7).item(), **FRICTION}
LAWS = {
    "hooke": HOOKE,
    "velocity": HOOKE.replace(**DAMPED),
    "velocity, clipped": HOOKE.replace(**DAMPED, clipped=True),
    "mass_velocity": HOOKE.replace(**CLIPPED).replace(
        damping="mass_velocity", damping_coefficient=300.0
    ),
    "damping_ratio": Law.linear(1e5, 0.2, clipped=True),
    "coeff_restitution": HOOKE.replace(**CLIPPED),
    "linear_nohistory": HOOKE.replace(**DAMPED, tangential="linear_nohistory"),
    "linear_history": HOOKE.replace(**SPRING),
    "linear_history, stiff": HOOKE.replace(**STIFF),
    "linear_history, damped": LINEAR,
    "linear_history, damped, clipped": LINEAR.replace(clipped=True),
    "linear_history_classic": LINEAR.replace(tangential="linear_history_classic"),
    "rolling, tied": HOOKE.replace(**SPRING, **ROLLS, rolling_stiffness=3e4),
    "rolling, of Ai": LINEAR.replace(**{**ROLLS, "rolling_damping": 0.5}, rolling_stiffness=2250.0),
    "rolling, free": LINEAR.replace(**{**ROLLS, "rolling_damping": 0.5}, rolling_stiffness=9e4),
    "twisting, tied": HOOKE.replace(**SPRING, **TWISTS, twisting_stiffness=3.0),
    "twisting, free": LINEAR.replace(
        **{**TWISTS, "twisting_damping": 1e-4}, twisting_stiffness=1.0
    ),
    "rolling and twisting": HOOKE.replace(
        **SPRING, **ROLLS, **TWISTS, rolling_stiffness=3e4, twisting_stiffness=1.0
    ),
    # as Yade has it, small spheres are unstable from mu_r R* |F_n| h / I = 2 on
    "rolling, constant": LINEAR.replace(**{**TORQUE, "rolling_friction": 2e-3}, clipped=True),
    "rolling, constant, elastic": HOOKE.replace(**SPRING, **TORQUE),
    "restitution of each": HOOKE.replace(**CLIPPED, partner_restitution=0.9),
    "friction of each": HOOKE.replace(**SPRING, partner_friction=0.1),
    "friction of each, mindlin/force": HERTZ.replace(
        tangential="mindlin/force", **FRICTION, partner_friction=0.1
    ),
    "hertz": HERTZ,
    "hertz, modulus": Law(normal="hertz", normal_modulus=1e8),
    "viscoelastic": HERTZ.replace(**VISCOUS),
    "hertz, coeff_restitution": HERTZ.replace(**CLIPPED),
    "mindlin": HERTZ.replace(**VISCOUS, tangential="mindlin", tangential_damping=0.5, **FRICTION),
    "mindlin_classic": HERTZ.replace(tangential="mindlin_classic", **FRICTION),
    "mindlin, coeff_restitution": HERTZ.replace(**RESTITUTION, tangential="mindlin", **OF_MATERIAL),
    "mindlin/force": HERTZ.replace(tangential="mindlin/force", **FRICTION),
    "mindlin/force, coeff_restitution": HERTZ.replace(
        **CLIPPED, tangential="mindlin/force", tangential_damping=0.4, **FRICTION
    ),
    "mindlin/force, rolling": HERTZ.replace(
        tangential="mindlin/force", **FRICTION, **ROLLS, rolling_stiffness=3e4
    ),
    "mindlin_rescale/force": HERTZ.replace(tangential="mindlin_rescale/force", **FRICTION),
    "dmt": DMT,
}  # fmt: skip
STATED = {
    "liggghts": {
        *(name for name in LAWS if name not in ("dmt", "rolling and twisting")
          and "/force" not in name and "of each" not in name),
    },
    "yade": {
        "hooke", "velocity, clipped", "mass_velocity", "damping_ratio", "coeff_restitution",
        "linear_history", "linear_history, stiff", "linear_history, damped, clipped",
        "rolling, tied", "twisting, tied", "rolling and twisting", "hertz",
        "hertz, coeff_restitution", "mindlin/force", "mindlin/force, coeff_restitution",
        "mindlin/force, rolling", "dmt", "rolling, constant", "rolling, constant, elastic",
        "restitution of each", "friction of each", "friction of each, mindlin/force",
    },
    "kratos": {
        "hooke", "velocity, clipped", "mass_velocity", "damping_ratio", "coeff_restitution",
        "linear_history", "linear_history, stiff", "hertz", "hertz, coeff_restitution",
        "mindlin_rescale/force", "dmt", "rolling, constant, elastic",
    },
}  # fmt: skip


def stacked(law):
    """Return two spheres between plates, pressed a little, under their weight."""
    first = sphere(R, RHO, position=(0.0, 0.0, R - 1e-6))
    second = sphere(0.5 * R, RHO, position=(0.0, 0.0, 2.5 * R - 2e-6))
    walls = (*FLOOR, Wall(point=(0.0, 0.0, 3.0 * R - 3e-6), direction=(0.0, 0.0, -1.0)))
    return Scene(bodies=(first, second), walls=walls, law=law, gravity=(0.0, 0.0, -9.81),
                 step=5e-6, steps=200, every=10)  # fmt: skip


def cornered(law):
    """Return a sphere that runs into a corner: three walls at a time, across each axis."""
    first = sphere(R, RHO, position=(1.01 * R, 0.99 * R, 1.005 * R), velocity=(-0.31, 0.21, -0.26),
                   angular_velocity=(3.0, -2.0, 5.0))  # fmt: skip
    walls = (*FLOOR, Wall(direction=(1.0, 0.0, 0.0)),
             Wall(point=(0.0, 2.0 * R, 0.0), direction=(0.0, -1.0, 0.0)))  # fmt: skip
    return Scene(bodies=(first,), walls=walls, law=law, step=2e-6, steps=400, every=20)


def twisted(law, partner="wall"):
    """Return a sphere that spins about the vertical on a floor or a frozen sphere."""
    scene = resting(law, 2e-3, 200, spin=(0.0, 0.0, 5.0), every=10)
    held = sphere(0.5 * R, RHO, position=(0.0, 0.0, -0.5 * R), motion="frozen")
    return scene if partner == "wall" else scene.replace(bodies=(*scene.bodies, held), walls=())


ASIDE = {"velocity": (0.2, 0.1, 0.0), "spin": (3.0, -2.0, 5.0), "every": 10}
# It sticks: of a spring at Coulomb's limit rounding decides in a setup whether its dashpot acts.
STICKS = {"velocity": (5e-4, 2e-4, 0.0), "spin": (0.02, -0.01, 5.0), "every": 10}
SYSTEMS = {
    "floor": struck_floor,
    "two spheres": struck_pair,
    "unequal spheres": lambda law: struck_pair(law, 0.6),
    "size ratio 10": lambda law: struck_pair(law, 0.1),
    "frozen sphere": lambda law: struck_pair(law, 1.4, "frozen"),
    "stacked": stacked,
    "in a corner": cornered,
    "slides on a floor": lambda law: resting(law, 4e-3, 400, **ASIDE),
    "rolls down": lambda law: resting(law, 4e-3, 400, gravity=(2.0, 1.0, -9.0), every=10),
    "set up again": lambda law: resting(law, 4e-3, 400, setups=(100, 233), **STICKS),
    "spins on a floor": twisted,
    "spins on a frozen sphere": lambda law: twisted(law, "frozen"),
    "led over a floor": lambda law: guided(law, *LEADS, overlap=0.0, every=10),
    "led over a sphere": lambda law: guided(law, *LEADS, overlap=0.0, partner="sphere", every=10),
}


@pytest.fixture(scope="module")
def runs(code):
    """Return (law, system, scene, rules, motion) of all that a code states."""
    rows = []
    for law, system in ((law, system) for law in LAWS for system in SYSTEMS):
        try:
            scene = SYSTEMS[system](LAWS[law])
            rows.append((law, system, scene, code.rules(scene)))
        except (CombinationError, Unsupported):  # a step too large for the springs of a small one
            continue
    motions = code.motions([scene_job(row[2]) for row in rows])
    return [(*row, motion) for row, motion in zip(rows, motions, strict=True)]


@ALL
def test_every_law_at_equal_steps(code, runs):
    faults = FAULTS[code.name]
    errors = {row[:2]: error(*row[2:3], row[4], row[3], faults) for row in runs}
    assert {name: off for name, off in errors.items() if not off < TOLERANCE} == {}
    assert {law for law, _ in errors} == STATED[code.name]


@ALL
def test_every_convention_moves_a_result(code, runs):
    faults = FAULTS[code.name]
    # looks are those of scenes with stages: tests/engines/test_plane_scenes.py
    for name in set().union(*(row[3].changed for row in runs)) - {"looks_set_up"}:
        default = Rules.model_fields[name].default
        others = ((row, row[3].replace(**{name: default})) for row in runs if row[3].changed)
        assert any(error(row[2], row[4], other, faults) > TOLERANCE for row, other in others), name
    assert any(error(row[2], row[4], row[3], Faults()) > TOLERANCE for row in runs)


@ALL
@pytest.mark.parametrize("name", ["friction", "normal_stiffness", "tangential_stiffness"])
def test_a_coefficient_off_by_1e_6_is_seen(code, runs, name):
    faults = FAULTS[code.name]
    _, _, scene, rules, motion = next(row for row in runs if row[:2] == ("linear_history", "floor"))
    law = scene.law.replace(**{name: getattr(scene.law, name) * (1.0 + 1e-6)})
    assert error(scene.replace(law=law), motion, rules, faults) > 10.0 * TOLERANCE
