"""The difference of two motions of a contact, over the sizes that they have."""

from __future__ import annotations

import math

import numpy as np

from harness.model.motion import Motion
from harness.model.scene import Scene

STEPS = 50  # of a contact, in checks


def motion_difference(scene: Scene, one: Motion, other: Motion) -> float:
    """Return the largest difference of two motions of a scene [-], over all samples.

    Positions are over the longest way or the overlap at rest, velocities and r times angular
    velocities over the largest of both or the gain of gravity in a contact time, forces over the
    largest force, and torques over r times that, r the smallest radius. Forces on bodies that are
    not free may be unknown.
    """
    r = min(body.radius for body in scene.bodies)
    known = [bool(scene.segments) or body.motion == "free" for body in scene.bodies]
    gravity, time = math.hypot(*scene.gravity), scene.step * STEPS
    way = np.abs(other.position - other.position[0]).max()
    length = max(way, gravity * (time / math.pi) ** 2) or r
    rim = r * np.abs(other.angular_velocity).max()
    speed = max(np.abs(other.velocity).max(), rim, gravity * time) or 1.0
    force = np.abs(other.force[:, known]).max() or 1.0
    differences = [
        np.abs(one.position - other.position).max() / length,
        np.abs(one.velocity - other.velocity).max() / speed,
        np.abs(one.angular_velocity - other.angular_velocity).max() * r / speed,
        np.abs(one.force - other.force)[:, known].max() / force,
        np.abs(one.torque - other.torque)[:, known].max() / force / r,
    ]
    if one.temperature is not None and other.temperature is not None:
        warmed = np.ptp(other.temperature) or 1.0
        differences.append(np.abs(one.temperature - other.temperature).max() / warmed)
    return float(max(differences))
