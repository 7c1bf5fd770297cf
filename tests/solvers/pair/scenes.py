"""Small scenes that the tests of the reference integration share."""

import math

import numpy as np

from harness.parameters.law import ContactLaw
from harness.parameters.scene import Body, ContactScene, Plane, Segment, sphere_mass

FLOOR = Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
RADIUS, DENSITY = 0.01, 2500.0
MASS = sphere_mass(RADIUS, DENSITY)
STILL = (0.0, 0.0, 0.0)

LINEAR = ContactLaw(
    normal_stiffness=1e6,
    damping="coeff_restitution",
    restitution=0.5,
    tangential="linear_history",
    friction=0.5,
    tangential_damping=1.0,
)
HERTZ = ContactLaw(
    normal="hertz",
    youngs_modulus=7e9,
    damping="coeff_restitution",
    restitution=0.5,
    tangential="mindlin",
    friction=0.3,
    tangential_damping=1.0,
)
ELASTIC = ContactLaw(normal_stiffness=1e6, tangential="linear_history", friction=100.0)


def impact(law, velocity=(0.0, 0.0, -1.0), omega=STILL, time=1e-3, samples=1):
    """Return a sphere that touches the floor and moves with a velocity."""
    ball = Body(RADIUS, MASS, (0.0, 0.0, RADIUS), velocity, omega)
    steps = 100 * samples
    return ContactScene((ball,), (FLOOR,), law, step=time / steps, steps=steps, every=100)


def collision(law, time=1e-3, samples=1):
    """Return two unequal spheres that touch obliquely, both spinning."""
    apart = 3.0 * RADIUS
    place = (0.0, 0.1 * apart, apart * math.sqrt(0.99))
    bodies = (
        Body(RADIUS, MASS, STILL, (1.0, 0.5, 0.0), (30.0, 100.0, 200.0)),
        Body(2.0 * RADIUS, 8.0 * MASS, place, (0.0, 0.0, -2.0), (0.0, 50.0, 0.0)),
    )
    steps = 100 * samples
    return ContactScene(bodies, (), law, step=time / steps, steps=steps, every=100)


def guided(law, *pieces, overlap=1e-5, every=1):
    """Return a sphere on the floor, pressed in, moved by pieces (steps, velocity, omega)."""
    ball = Body(RADIUS, MASS, (0.0, 0.0, RADIUS - overlap))
    segments = tuple(Segment(steps, (velocity,), (omega,)) for steps, velocity, omega in pieces)
    steps = sum(segment.steps for segment in segments)
    return ContactScene(
        (ball,), (FLOOR,), law, step=1e-6, steps=steps, every=every, segments=segments
    )


def kinetic_energy(scene, path):
    """Return the kinetic energy of every sample [J]."""
    mass = np.array([body.mass for body in scene.bodies])
    inertia = np.array([body.inertia for body in scene.bodies])
    moving = (path.velocities**2).sum(axis=2) @ mass
    return 0.5 * (moving + (path.omegas**2).sum(axis=2) @ inertia)


def momentum(scene, path):
    """Return linear and angular momentum about the origin of every sample, (samples, 2, 3)."""
    mass = np.array([body.mass for body in scene.bodies])[None, :, None]
    inertia = np.array([body.inertia for body in scene.bodies])[None, :, None]
    linear = mass * path.velocities
    angular = np.cross(path.positions, linear) + inertia * path.omegas
    return np.stack([linear.sum(axis=1), angular.sum(axis=1)], axis=1)
