"""Eight spheres of several sizes in a box: many contacts at a time, one after another, all ways.

A contact of its own tests a law. Here each sphere has several at once, with neighbours and walls in
all directions, and meets them again: a code must keep the history of each contact apart, and forget
it when the contact ends.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import product
from typing import ClassVar

import numpy as np
from pydantic import Field

from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.parameters import ContactSystem, Duration, Speed, ratios
from harness.model.base import Vector
from harness.model.scene import Motion, Scene, Wall, sphere

CORNERS = tuple(product((0, 1), repeat=3))
GOLDEN = math.pi * (3.0 - math.sqrt(5.0))  # angle between directions that fill a sphere evenly
FIRST_TURN = 1.0  # [rad] of velocities: none lies in a plane of symmetry
FIRST_SPIN = 2.0


class Box(ContactSystem):
    """Eight spheres in a box, with velocities and spins in all directions: what energy is left.

    Integrated under the code's conventions. Without dissipation the energy stays, but for the
    springs of contacts that last at the end.
    """

    quantities: ClassVar = ratios(
        energy_ratio="kinetic energy at the end over that at the start, of all spheres",
        spin_energy_ratio="that of the spins alone, likewise",
    )

    allowed: ClassVar = {
        **ContactSystem.allowed, "partner": ("sphere",), "materials_as": ("stated",),
    }  # fmt: skip

    # fmt: off
    speed: Speed = Field(1.0, description="[m/s] of each sphere, and of its rim")
    gap: float = Field(
        0.02, ge=1e-6, le=1.0, description="[-] between the largest spheres, in their diameters")
    duration: Duration = Field(12.0, description="[-] in contact times, without a dashpot")
    # fmt: on

    def check(self) -> None:
        """Raise ValueError for impacts that are too deep or too shallow."""
        if self.partner_density is not None:
            raise self.invalid("partner_density", "must not be given: all are of one material")
        self.check_impact("speed", 2.0 * self.speed)

    def scene(self) -> Scene:
        """Return the spheres, the first and largest to the last and smallest, in the corners."""
        last = len(CORNERS) - 1
        cell = 2.0 * max(self.radius, self.second_radius) * (1.0 + self.gap)
        bodies = []
        for i, corner in enumerate(CORNERS):
            radius = self.radius + (self.second_radius - self.radius) * i / last
            spin = (component / radius for component in self._direction(i, FIRST_SPIN))
            bodies.append(
                sphere(
                    radius,
                    self.density,
                    position=tuple((place + 0.5) * cell for place in corner),
                    velocity=self._direction(i, FIRST_TURN),
                    angular_velocity=tuple(spin),
                )
            )
        return Scene(
            bodies=tuple(bodies),
            walls=tuple(_walls(2.0 * cell)),
            law=self.stated_law,
            step=math.pi * self.elastic_overlap(self.speed) / self.speed / self.steps_per_contact,
            steps=math.ceil(self.duration * self.steps_per_contact),
            every=math.ceil(self.duration * self.steps_per_contact),
        )

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return the kinetic energies at the end over those at the start."""
        bodies = self.scene().bodies
        mass = np.array([body.mass for body in bodies])
        inertia = np.array([body.moment_of_inertia for body in bodies])
        moving = (motion.velocity**2).sum(axis=2) @ mass
        turning = (motion.angular_velocity**2).sum(axis=2) @ inertia
        energy = moving + turning
        return {
            "energy_ratio": float(energy[-1] / energy[0]),
            "spin_energy_ratio": float(turning[-1] / turning[0]),
        }

    def _direction(self, index: int, turn: float) -> Vector:
        """Return the speed in one of eight directions, spread evenly (Fibonacci's lattice)."""
        z = (2.0 * index + 1.0) / len(CORNERS) - 1.0
        across = math.sqrt(1.0 - z * z)
        angle = turn + GOLDEN * index
        x, y = across * math.cos(angle), across * math.sin(angle)
        return (self.speed * x, self.speed * y, self.speed * z)


def _walls(side: float) -> list[Wall]:
    """Return the faces of a cube [m], a corner of which is the origin."""
    faces = []
    for axis in range(3):
        normal = [0.0, 0.0, 0.0]
        normal[axis] = 1.0
        far = tuple(side * component for component in normal)
        faces += [
            Wall(direction=tuple(normal)),
            Wall(point=far, direction=tuple(-component for component in normal)),
        ]
    return faces


BOX = ContactCase("box", Box)
