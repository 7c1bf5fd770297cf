"""Planted faults of a scene: each returns a function from a scene to one that is wrong."""

import math


def changed(thing, name, factor):
    """Return a thing with a number or a vector off by a factor; unchanged without one."""
    value = getattr(thing, name)
    if value is None:
        return thing
    off = tuple(factor * x for x in value) if isinstance(value, tuple) else factor * value
    return thing.replace(**{name: off})


def scaled(name, factor=1.0 + 1e-7):
    """Return a fault of a number or a vector of the scene."""
    return lambda scene: changed(scene, name, factor)


def coefficient(name, factor=1.0 + 1e-7):
    """Return a fault of a coefficient of the law."""
    return lambda scene: scene.replace(law=changed(scene.law, name, factor))


def grain(name, factor=1.0 + 1e-7):
    """Return a fault of a number of the first body, whose inertia stays unless it is named."""

    def change(scene):
        first, *row = scene.bodies
        stated = first.replace(inertia=first.moment_of_inertia)
        return scene.replace(bodies=(changed(stated, name, factor), *row))

    return change


def diameters(factor=1.0 + 1e-7):
    """Return a fault of all radii."""
    return lambda scene: scene.replace(
        bodies=tuple(changed(body, "radius", factor) for body in scene.bodies)
    )


def turned(by=1e-7):
    """Return a fault of the tilt, by a relative error."""

    def change(scene):
        along, down, _ = scene.gravity
        g, tilt = math.hypot(along, down), math.atan2(along, -down) * (1.0 + by)
        return scene.replace(gravity=(g * math.sin(tilt), -g * math.cos(tilt), 0.0))

    return change
