"""Laws, spheres and scenes that the tests of the reference share."""

import math

import numpy as np

from harness.model.law import Law
from harness.model.scene import Body, Scene, Segment, Stage, Wall, sphere
from harness.solvers import reference

R, RHO, G = 0.01, 2500.0, 9.81
MASS = 4 / 3 * math.pi * R**3 * RHO
FLOOR = (Wall(),)
STILL = (0.0, 0.0, 0.0)

HOOKE = Law(normal_stiffness=1e5)
HERTZ = Law(normal="hertz", youngs_modulus=1e8, poisson_ratio=0.3)
DAMPED = {"damping": "velocity", "damping_coefficient": 2.0}
VISCOUS = {"damping": "viscoelastic", "damping_coefficient": 4e5}
SLIDER = {"friction": 0.3, "tangential_damping": 0.5}
LINEAR = HOOKE.replace(
    **DAMPED, tangential="linear_history", tangential_stiffness=2e5 / 7, **SLIDER
)
MINDLIN = HERTZ.replace(**VISCOUS, tangential="mindlin", **SLIDER)
ROLLS = {"rolling": "sds", "rolling_stiffness": 2e4, "rolling_damping": 0.5,
         "rolling_friction": 0.05}  # fmt: skip
TORQUE = {"rolling": "constant", "rolling_friction": 0.05}
TWISTS = {"twisting": "sds", "twisting_stiffness": 1.0, "twisting_damping": 1e-4,
          "twisting_friction": 1e-4}  # fmt: skip
JKR = HERTZ.replace(normal="jkr", surface_energy=0.5)
DMT = HERTZ.replace(normal="dmt", surface_energy=0.5)
MDR = HERTZ.replace(normal="mdr")
YIELDS = MDR.replace(yield_stress=1e6)


def contact_time(law, speed, mass=MASS, radius=R):
    """Return how long an undamped impact lasts [s], about."""
    if law.normal == "hooke":
        return math.pi * math.sqrt(mass / law.normal_stiffness)
    modulus = 0.5 * law.stiffness(1.0, 1.0)
    return 2.8683 * (mass**2 / (radius * modulus**2 * speed)) ** 0.2


def impact(law, velocity, steps=100, *, partner="wall", lasts=2.0, time=None, other=R, spin=STILL,
           **more):  # fmt: skip
    """Return a sphere that touches something at the origin half a step after the start.

    ``steps`` are those of a ``time`` [s], that of an undamped impact unless given.
    """
    step = (time or contact_time(law, -velocity[2])) / steps
    start = np.array([0.0, 0.0, R]) - 0.5 * step * np.array(velocity)
    first = sphere(R, RHO, position=tuple(start), velocity=velocity, angular_velocity=spin)
    bodies, walls = (first,), FLOOR
    if partner != "wall":
        motion = "frozen" if partner == "frozen" else "free"
        second = sphere(other, RHO, position=(0.0, 0.0, -other), motion=motion)
        bodies, walls = (first, second), ()
    count = round(lasts * steps)
    return Scene(bodies=bodies, walls=walls, law=law, step=step, steps=count,
                 **{"every": count, **more})  # fmt: skip


def resting(law, seconds, steps, *, velocity=STILL, spin=STILL, gravity=(0.0, 0.0, -G), **more):
    """Return a sphere that lies on the floor under its weight."""
    weight = MASS * -gravity[2]
    overlap = weight / law.stiffness(R, 1.0)
    if law.normal != "hooke":
        overlap = (1.5 * weight / law.stiffness(R, 1.0)) ** (2 / 3)
    body = sphere(R, RHO, position=(0.0, 0.0, R - overlap), velocity=velocity,
                  angular_velocity=spin)  # fmt: skip
    return Scene(bodies=(body,), walls=FLOOR, law=law, gravity=gravity, step=seconds / steps,
                 steps=steps, **{"every": steps, **more})  # fmt: skip


def guided(law, *pieces, overlap=1e-5, partner="wall", step=1e-6, **more):
    """Return a sphere pressed in and led by pieces of (steps, velocity, spin)."""
    first = sphere(R, RHO, position=(0.0, 0.0, R - overlap))
    bodies, walls = (first,), FLOOR
    if partner == "sphere":
        bodies, walls = (first, sphere(R, RHO, position=(0.0, 0.0, -R))), ()
    rest = (STILL,) * (len(bodies) - 1)
    segments = tuple(
        Segment(steps=n, velocities=(v, *rest), angular_velocities=(w, *rest)) for n, v, w in pieces
    )
    return Scene(bodies=bodies, walls=walls, law=law, step=step, segments=segments,
                 steps=sum(n for n, _, _ in pieces), **more)  # fmt: skip


LEADS = ((50, (0.0, 0.0, -0.1), STILL), (50, (0.02, -0.06, 0.0), (6.0, 0.0, 1.5)),
         (50, (-0.04, 0.06, 0.0), (-6.0, 0.0, -3.0)), (50, (0.0, 0.0, 0.03), STILL))  # fmt: skip


def difference(motion, other):
    """Return the largest difference of two motions, over the sizes that quantities have."""
    off = np.abs(motion.position - other.position).max() / R
    for first, second, lever in (("velocity", "angular_velocity", R), ("force", "torque", 1 / R)):
        size = max(
            np.abs(getattr(motion, first)).max(), lever * np.abs(getattr(motion, second)).max()
        )
        for name, factor in ((first, 1.0), (second, lever)):
            gap = factor * np.abs(getattr(motion, name) - getattr(other, name)).max()
            off = max(off, gap / (size or 1.0))
    if motion.temperature is not None:
        off = max(off, np.abs(motion.temperature - other.temperature).max() / 100.0)
    return float(off)


def final(scene, *conventions):
    """Return velocity and r times angular velocity of the first body at the end [m/s]."""
    motion = reference.run(scene, *conventions)
    return motion.velocity[-1, 0], R * motion.angular_velocity[-1, 0]


SEATED = math.sqrt(0.75)  # [d] of a grain that touches two spheres of a row, above it


def on_row(stiffness=1e6, *, angle=10.2, ratio=5.0, clipped=True, per_contact=50.0, speed=1.5,
           wells=0, motion="frozen", step=None, **more):  # fmt: skip
    """Return a grain (1 m, 1 kg) in a well of an endless row of ten, along the sphere ahead.

    With ``wells`` there is a stage for each, up to above the centre of the sphere ahead.
    """
    law, tilt = Law.linear(stiffness, ratio, clipped), math.radians(angle)
    grain = Body(radius=0.5, mass=1.0, position=(0.5, SEATED, 0.0),
                 velocity=(speed * SEATED, 0.5 * speed, 0.0))  # fmt: skip
    row = [Body(radius=0.5, mass=1.0, position=(float(k), 0.0, 0.0), motion=motion)
           for k in range(10)]  # fmt: skip
    stages = tuple(Stage(place=k + 1.0, floor=-1e9) for k in range(wells))
    step = step or math.pi / math.sqrt(stiffness) / per_contact
    return Scene(bodies=(grain, *row), law=law, stages=stages, period=(10.0, None, None), step=step,
                 gravity=(G * math.sin(tilt), -G * math.cos(tilt), 0.0),
                 **{"steps": 1000, "every": more.get("steps", 1000), **more})  # fmt: skip


def climbing(*stages, steps=1000, **more):
    """Return a body thrown up along x at 1 m/s; it turns back at 0.476 s, step 476."""
    body = Body(radius=0.01, mass=2.0, velocity=(1.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, 3.0))
    return Scene(bodies=(body,), step=1e-3, steps=steps, gravity=(-2.1, 0.0, 0.0), every=10,
                 stages=tuple(Stage(place=x, floor=e) for x, e in stages), **more)  # fmt: skip
