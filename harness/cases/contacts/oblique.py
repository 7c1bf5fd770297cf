"""Impacts with friction: at an angle, in other units, of two moving spheres, and with spin.

Two moving spheres are judged by what is relative, which must be the same whatever moves. Codes that
add the slip of half a step to a spring in the plane of a whole one were seen to trap small spheres
among large ones (Vyas et al., Comput. Phys. Commun. 310, 109524 (2025)).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from pydantic import Field

from harness.cases.base import Quantity
from harness.cases.contacts.contact_case import ContactCase, ratios
from harness.cases.contacts.impact import impact_scene, relative_velocity
from harness.cases.contacts.parameters import AngularSpeed, ContactSystem, Speed
from harness.cases.contacts.partial_slip import PartialSlipCase
from harness.model.base import Vector
from harness.model.motion import Motion
from harness.model.scene import Scene

LEAST_ANGLE = 1e-6  # [deg]: ratios of velocities have an error of 1e-16 over its sine, 1e-8
# [m], [kg], [s]: units in which radius, mass and duration of a contact are about 1; powers of two,
# so that no bit of a ratio may differ from that in SI units
LENGTH, MASS, TIME = 2.0**-6, 2.0**-7, 2.0**-9
SPEED = LENGTH / TIME


class Oblique(ContactSystem):
    """An impact at an angle to the normal, in SI units and degrees."""

    speed: Speed = Field(1.0, description="[m/s] of the approach")
    angle: float = Field(45.0, ge=0.0, lt=90.0, description="[deg] to the normal")

    def check(self) -> None:
        """Raise ValueError for an impact that is too deep or too shallow, or an angle that is."""
        along, _, down = self.velocity
        self.check_impact("speed", -down)
        if along:
            reason = "0, or more than the rounding of the velocity along the surface"
            self.check_range("angle", LEAST_ANGLE, 90.0, reason)

    @property
    def velocity(self) -> Vector:
        """Return the velocity of the sphere [m/s]: along x and down."""
        angle = math.radians(self.angle)
        return (self.speed * math.sin(angle), 0.0, -self.speed * math.cos(angle))

    def scene(self) -> Scene:
        """Return the impact; samples before and after it."""
        return impact_scene(self, self.velocity, sampled=False)

    def absent(self) -> Collection[str]:
        """Return the quantities over a tangential velocity where there is none."""
        return () if self.velocity[0] > 0.0 else [each.name for each in VELOCITY_RATIOS[1:]]

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return ratios of the velocities after to those before; tangential ones at an angle."""
        along, _, down = self.velocity
        before, after = relative_velocity(motion)[[0, -1]]
        quantities = {"normal_restitution": float(after[2]) / -down}
        if along > 0.0:
            spin = float(motion.angular_velocity[-1, 0, 1])
            impulses = before[0] - after[0], after[2] - before[2]
            quantities["tangential_ratio"] = float(after[0]) / along
            quantities["rim_speed_ratio"] = self.radius * spin / along
            quantities["tangential_impulse_ratio"] = float(impulses[0] / impulses[1])
        return quantities


class LjUnits(Oblique):
    """An impact at an angle to the normal, in SI units and degrees; the script has other units."""

    allowed: ClassVar = {
        **Oblique.allowed, "normal": ("hooke", "hertz", "dmt", "jkr"), "materials_as": ("stated",),
    }  # fmt: skip

    def scene(self) -> Scene:
        """Return the impact in other units."""
        scene = super().scene()

        def in_units(vector: Vector, unit: float) -> Vector:
            x, y, z = vector
            return (x / unit, y / unit, z / unit)

        bodies = (
            body.replace(
                radius=body.radius / LENGTH,
                mass=body.mass / MASS,
                position=in_units(body.position, LENGTH),
                velocity=in_units(body.velocity, SPEED),
                angular_velocity=in_units(body.angular_velocity, 1.0 / TIME),
            )
            for body in scene.bodies
        )
        law = scene.law.in_units(LENGTH, MASS, TIME)
        return scene.replace(bodies=tuple(bodies), law=law, step=scene.step / TIME)

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return the ratios of an oblique impact."""
        velocity, spin = motion.velocity * SPEED, motion.angular_velocity / TIME
        return super().observe(replace(motion, velocity=velocity, angular_velocity=spin))


class Collision(Oblique):
    """An impact of two free spheres at an angle, each with a part of the velocity; SI units."""

    allowed: ClassVar = {**Oblique.allowed, "partner": ("sphere",)}

    partner_share: float = Field(
        0.5, ge=-10.0, le=10.0, description="[-] of the speed that the second sphere has"
    )

    def scene(self) -> Scene:
        """Return the impact seen where the second sphere moves towards the first."""
        x, _, z = (-self.partner_share * v for v in self.velocity)
        scene = super().scene()
        bodies = [
            body.replace(velocity=(body.velocity[0] + x, body.velocity[1], body.velocity[2] + z))
            for body in scene.bodies
        ]
        return scene.replace(bodies=tuple(bodies))

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return ratios of relative velocities, and the change of the momentum of both."""
        momentum = np.array([self.mass, self.second_mass]) @ motion.velocity[:, :, 2].T
        change = float(momentum[-1] - momentum[0]) / (self.effective_mass * self.speed)
        return {**super().observe(motion), "momentum_change_ratio": change}

    def exact(self) -> Mapping[str, float]:
        """Return that no momentum is lost."""
        return {"momentum_change_ratio": 0.0}


class Spin(ContactSystem):
    """A normal impact with spin about an axis along the surface, in SI units."""

    # fmt: off
    speed: Speed = Field(1.0, description="[m/s] of the approach")
    spin: AngularSpeed = Field(100.0, description="[rad/s] of the sphere, about y")
    partner_spin: float = Field(
        0.0, ge=-1e9, le=1e9, description="[rad/s] of the other sphere, about y")
    # fmt: on

    def check(self) -> None:
        """Raise ValueError for a spin without a sphere, and an impact too deep or too shallow."""
        if self.partner_spin and self.partner != "sphere":
            raise self.invalid("partner_spin", f"partner = {self.partner!r} has none (sphere does)")
        self.check_impact("speed", self.speed)

    def scene(self) -> Scene:
        """Return the impact; samples before and after it."""
        spins = (0.0, self.spin, 0.0), (0.0, self.partner_spin, 0.0)
        return impact_scene(self, (0.0, 0.0, -self.speed), *spins, sampled=False)

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return ratios of velocities and spin after the impact to those before."""
        after = relative_velocity(motion)[-1]
        return {
            "normal_restitution": float(after[2]) / self.speed,
            "spin_ratio": float(motion.angular_velocity[-1, 0, 1]) / self.spin,
            "gained_speed_ratio": float(after[0]) / self.radius / self.spin,
        }


VELOCITY_RATIOS: Sequence[Quantity[Any]] = (
    *ratios(
        normal_restitution="normal speed after over that before",
        tangential_ratio="tangential velocity of the centre, likewise",
        rim_speed_ratio="radius times spin at the end over the tangential velocity at the start",
    ),
    Quantity(
        "tangential_impulse_ratio", "1", "tangential over normal impulse: at most mu where the "
        "normal force never pulls, else mu times the integral of |F_n| over that of F_n",
        lambda p: min(p.friction or 1.0, 1.0),  # Coulomb's limit: a larger one is not reached
    ),
)  # fmt: skip
OBLIQUE = PartialSlipCase(
    name="oblique",
    summary="A sphere hits a wall or a sphere at an angle: velocity ratios and spin.",
    formula="Integrated under the code's conventions. Where it slides throughout and the normal "
    "force never pulls, vx'/vx = 1 - mu (1 + e) vn/vx, r omega' = 5/2 mu (1 + e) vn on a wall.",
    parameters=Oblique,
    quantities=VELOCITY_RATIOS,
)  # fmt: skip
LJ_UNITS = ContactCase(
    name="lj-units",
    summary="An oblique impact in units lj: velocity ratios and spin are those in SI units.",
    formula="As an oblique impact, all numbers times powers of the units.",
    parameters=LjUnits,
    quantities=VELOCITY_RATIOS,
    units="lj",
)  # fmt: skip
COLLISION = ContactCase(
    name="collision",
    summary="Two moving spheres collide at an angle, of other densities and sizes.",
    formula="As an oblique impact, whatever moves, with m* and R* of both spheres. Where it slides "
    "throughout, vx'/vx = 1 - mu (1 + e) vn/vx of the relative velocity. The momentum of both "
    "stays.",
    parameters=Collision,
    quantities=(
        *VELOCITY_RATIOS,
        *ratios(
            momentum_change_ratio="along the normal, of both, after less before, over m* times the "
            "speed",
        ),
    ),
)  # fmt: skip
SPIN = ContactCase(
    name="spin",
    summary="A spinning sphere hits a wall or a sphere: spin left, velocity gained.",
    formula="Integrated under the code's conventions. Where it slides throughout and the normal "
    "force never pulls, vx' = -mu (1 + e) vn against the surface's motion, omega' = omega - 5/2 mu "
    "(1 + e) vn / r on a wall.",
    parameters=Spin,
    quantities=ratios(
        normal_restitution="normal speed after over that before",
        spin_ratio="spin at the end over that at the start",
        gained_speed_ratio="tangential velocity gained over radius times spin at the start",
    ),
)  # fmt: skip
