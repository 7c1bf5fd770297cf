"""Scenes of all laws and walls that LAMMPS has, for its tests at equal steps."""

import numpy as np

from harness.model.law import Law
from harness.model.scene import Scene, Wall, sphere
from tests.solvers.reference.scenes import (
    DMT,
    HERTZ,
    HOOKE,
    JKR,
    LEADS,
    LINEAR,
    MASS,
    MDR,
    MINDLIN,
    ROLLS,
    SLIDER,
    TWISTS,
    VISCOUS,
    YIELDS,
    G,
    R,
    guided,
    impact,
)

MASSIVE = {"damping": "mass_velocity", "damping_coefficient": 400.0}
OF_HALF = {"restitution": 0.5}
OLD = HOOKE.replace(**MASSIVE, **SLIDER, tangential="linear_nohistory", interface="old")
LAWS = {
    "hooke": HOOKE,
    "mass_velocity, clipped": HOOKE.replace(**MASSIVE, clipped=True),
    "viscoelastic of hooke": HOOKE.replace(**VISCOUS),
    "coeff_restitution of hooke": HOOKE.replace(damping="coeff_restitution", **OF_HALF),
    "linear_history of hertz": HERTZ.replace(
        tangential="linear_history", tangential_stiffness=3e4, friction=0.3),
    "coeff_restitution of hertz": HERTZ.replace(damping="coeff_restitution", **OF_HALF),
    "damping_ratio": Law.linear(1e5, 0.2, clipped=False),
    "tsuji": HERTZ.replace(damping="tsuji", **OF_HALF),
    "modulus": Law(normal="hertz", normal_modulus=8e7, tangential="mindlin",
                   tangential_modulus=6e7, friction=0.3),
    "dmt": DMT.replace(**VISCOUS, tangential="mindlin", **SLIDER),
    "jkr": JKR.replace(**VISCOUS, tangential="mindlin", **SLIDER),
    "linear_nohistory": LINEAR.replace(tangential="linear_nohistory"),
    "linear_history": LINEAR,
    "linear_history_classic": LINEAR.replace(tangential="linear_history_classic"),
    "mindlin": MINDLIN,
    "mindlin/force": MINDLIN.replace(tangential="mindlin/force"),
    "mindlin_rescale": MINDLIN.replace(tangential="mindlin_rescale"),
    "mindlin_rescale/force": MINDLIN.replace(tangential="mindlin_rescale/force"),
    "mindlin_classic": MINDLIN.replace(tangential="mindlin_classic"),
    "rolling": LINEAR.replace(**ROLLS),
    "twisting": MINDLIN.replace(**{**TWISTS, "twisting_friction": 1e-3}),
    "marshall": LINEAR.replace(twisting="marshall"),
    "marshall of mindlin": MINDLIN.replace(twisting="marshall"),
    "gran/hooke": OLD,
    "gran/hooke/history": OLD.replace(
        tangential="linear_history_classic", tangential_stiffness=2e5 / 7),
    "gran/hertz/history": MINDLIN.replace(tangential="mindlin_classic", interface="old"),
    "mdr": MDR.replace(damping="velocity", damping_coefficient=2.0, **SLIDER, tangential="mindlin"),
    "mdr, yield": YIELDS,
    "mdr, bulk": YIELDS.replace(bulk_share=0.999),
    "mdr, damping": YIELDS.replace(damping="mdr", damping_coefficient=0.1),
    "mdr, adhesion": MDR.replace(surface_energy=0.5),
}  # fmt: skip


def off_by(name, part, factor=1.0 - 1e-6):
    """Return a law of which one coefficient is off."""
    return LAWS[name].replace(**{part: getattr(LAWS[name], part) * factor})


MOVING = {"velocity": (0.1, 0.05, -0.3), "spin": (3.0, -5.0, 8.0), "steps": 50, "lasts": 1.2,
          "every": 1}  # fmt: skip
SYSTEMS = {
    "wall": lambda law: impact(law, **MOVING),
    "spheres": lambda law: impact(law, **MOVING, partner="sphere", other=0.02),
    "frozen": lambda law: impact(law, **MOVING, partner="frozen"),
    "prescribed": lambda law: guided(law, *LEADS, partner="sphere", every=3),
}

W = 0.05
UP, DOWN, ALONG = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0)
HEATED = {"heat": "radius", "conductance": 5e3}
BOWL = Wall(shape="sphere", radius=W, hollow=True)
PIPE = Wall(shape="cylinder", radius=W, hollow=True)
TILTED = (0.6, 0.0, 0.8)
MIXED = {"partner_youngs_modulus": 4e8, "partner_poisson_ratio": 0.1}


def on_wall(wall, place, law=LINEAR, *, axes=(True,) * 3, **more):
    """Return a sphere that slides on a wall, and moves into it, as its weight does."""
    down = -np.array(wall.direction if wall.shape == "plane" else place)
    down /= np.linalg.norm(down) * (-1.0 if wall.hollow else 1.0)
    velocity = np.array([0.1, 0.2, 0.05])
    velocity += (0.05 - velocity @ down) * down
    body = sphere(R, 2500.0, position=place, velocity=tuple(velocity), temperature=400.0,
                  angular_velocity=(2.0, 0.0, 1.0), axes=axes, heat_capacity=5.0)  # fmt: skip
    return Scene(bodies=(body,), walls=(wall,), law=law, gravity=tuple(G * down), step=1e-5,
                 steps=200, every=10, **more)  # fmt: skip


def two_types():
    """Return a sphere that falls on another type, both with laws of their own at a wall."""
    scene = impact(MINDLIN, **MOVING, partner="sphere")
    first, second = scene.bodies
    laws = {(1, 2): MINDLIN, (1, 3): LINEAR, (2, 3): HERTZ, (2, 2): JKR}
    return scene.replace(bodies=(first, second.replace(type=2)), laws=laws,
                         walls=(Wall(point=(0.0, 0.0, -2.0 * R + 1e-6), type=3),))  # fmt: skip


def discs():
    """Return two discs of which one hits the other and a wall, in a plane."""
    bodies = [sphere(R, 2500.0, position=(0.0, R - 1e-6, 0.0), velocity=(0.1, -0.3, 0.0),
                     angular_velocity=(0.0, 0.0, 5.0)),
              sphere(R, 2500.0, position=(2.0 * R - 1e-6, R, 0.0))]  # fmt: skip
    bodies = [body.replace(inertia=0.5 * body.mass * R**2) for body in bodies]
    return Scene(bodies=tuple(bodies), walls=(Wall(direction=(0.0, 1.0, 0.0)),), law=LINEAR,
                 gravity=(0.0, -G, 0.0), step=2e-5, steps=80)  # fmt: skip


def warm_spheres():
    """Return two spheres in contact, of other temperatures and heat capacities."""
    scene = SYSTEMS["prescribed"](MINDLIN.replace(heat="area", conductance=5e8))
    first, second = scene.bodies
    return scene.replace(bodies=(first.replace(temperature=400.0, heat_capacity=5.0), second))


def row_of_four():
    """Return a sphere on a frozen and a held one that overlap, and one that it never meets."""
    places = {
        "free": (0.0, 0.0, R - 1e-6),
        "frozen": (R, 0.0, -0.7 * R),
        "held": (-R, 0.0, -0.7 * R),
    }
    bodies = [sphere(R, 2500.0, position=place, motion=motion) for motion, place in places.items()]
    bodies.append(bodies[0].replace(position=(0.0, 0.5 * R, R)))
    return Scene(bodies=tuple(bodies), law=LINEAR, gravity=(0.0, 0.0, -G), step=1e-5, steps=100,
                 pairs=((0, 1), (2, 0), (3, 1), (1, 2)))  # fmt: skip


def in_other_units(length=0.01, mass=MASS, time=1e-4):
    """Return an impact with its numbers in units of choice."""
    scene, speed = SYSTEMS["spheres"](MINDLIN), time / length
    bodies = [
        b.replace(radius=b.radius / length, mass=b.mass / mass,
                  position=tuple(x / length for x in b.position),
                  velocity=tuple(v * speed for v in b.velocity),
                  angular_velocity=tuple(w * time for w in b.angular_velocity))
        for b in scene.bodies
    ]  # fmt: skip
    return scene.replace(bodies=tuple(bodies), law=scene.law.in_units(length, mass, time),
                         step=scene.step / time)  # fmt: skip


LOW, SIDE = (0.0, 0.0, R - 5e-6), (W - R + 3e-6, 0.0, 0.0)
GROUND, TOP = (0.0, 0.0, 3e-6 - W + R), (0.0, 0.0, W + R - 3e-6)
PLACES = {
    "wiggles across": on_wall(Wall(amplitude=(0.0, 0.0, 2e-5), frequency=600.0), LOW, MINDLIN),
    "wiggles along": on_wall(Wall(amplitude=(2e-5, 0.0, 0.0), frequency=600.0), LOW),
    "shears": on_wall(Wall(surface_velocity=(0.0, 0.3, 0.0)), LOW, MINDLIN),
    "slides": on_wall(Wall(velocity=(0.3, 0.0, 0.0)), LOW),
    "rises": on_wall(Wall(velocity=(0.05, 0.0, 0.02)), (0.0, 0.0, R + 1e-7)),
    "x": on_wall(Wall(direction=(1.0, 0.0, 0.0)), (R - 1e-6, 0.0, 0.0)),
    "ceiling": on_wall(Wall(point=(0.0, 0.0, 0.1), direction=DOWN), (0.0, 0.0, 0.1 - R + 1e-6)),
    "tilted": on_wall(Wall(direction=TILTED), tuple((R - 5e-6) * x for x in TILTED)),
    "bowl": on_wall(BOWL, GROUND, MINDLIN),
    "bowl, jkr": on_wall(BOWL, GROUND, LAWS["jkr"]),
    "bowl that turns": on_wall(BOWL.replace(spin=(1.0, 2.0, 3.0)), GROUND),
    "hill": on_wall(BOWL.replace(hollow=False), TOP),
    "cylinder": on_wall(PIPE.replace(direction=ALONG), SIDE),
    "bar": on_wall(PIPE.replace(direction=ALONG, hollow=False), TOP),
    "drum": on_wall(PIPE.replace(spin=(0.0, 0.0, 3.0)), SIDE),
    "pipe along": on_wall(PIPE.replace(velocity=(0.0, 0.0, 0.1)), SIDE),
    "drag": on_wall(Wall(), LOW, MINDLIN, drag=0.05),
    "guided": on_wall(Wall(), LOW, axes=(True, False, True)),
    "warm wall": on_wall(Wall(temperature=300.0), LOW, LINEAR.replace(**HEATED)),
    "warm spheres": warm_spheres(),
    "row of four": row_of_four(),
    "two types": two_types(),
    "two materials": two_types().replace(laws={(1, 2): MINDLIN.replace(**MIXED)}, walls=()),
    "restitution of each": impact(
        LAWS["coeff_restitution of hooke"].replace(partner_restitution=0.8), **MOVING,
        partner="sphere"),
    "two materials, elastic": impact(HERTZ.replace(**MIXED), **MOVING, partner="sphere"),
    "discs": discs(),
    "through a boundary": SYSTEMS["spheres"](LINEAR).replace(period=(0.1, 0.2, None)),
    "set up again": SYSTEMS["wall"](LINEAR).replace(setups=(20, 33)),
    "pairs": SYSTEMS["spheres"](LINEAR).replace(pairs=((0, 1),)),
    "no pairs": SYSTEMS["spheres"](LINEAR).replace(pairs=(), gravity=(0.0, 0.0, -G)),
}  # fmt: skip
SCENES = {
    **{f"{law}, {system}": make(LAWS[law]) for law in LAWS for system, make in SYSTEMS.items()},
    **PLACES,
}
