"""A sphere in its surroundings: walls that move or are curved, a viscous fluid, heat of a contact.

A plane that runs at a constant speed (LAMMPS's shear) is, seen from it, one at rest under a sphere
that slides. Under one that oscillates (wiggle) a contact that neither slides nor parts is a driven
oscillator. Curved walls are LAMMPS's regions: in a bowl or a cylinder, on a hill, on the rim of an
open box. The sphere moves in a plane, in which a cylinder is a bowl; a rim is a cylinder without a
radius. The fluid is LAMMPS's fix viscous: a force -drag v on each free body.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.parameters import (
    ContactSystem,
    Duration,
    Gravity,
    Radius,
    Speed,
    quarters,
    ratios,
)
from harness.cases.contacts.resting import Resting
from harness.errors import EngineOutputError, RequestError
from harness.model.base import ZERO, Vector
from harness.model.scene import Floats, Motion, Scene, Segment, Wall
from harness.theory.contact import conductance, cooling_rate, dragged, driven

EDGE = 1e-30  # [m] radius of an edge: none
INSTANTS = 4000  # in half the time, at which forces are held against their limits
Temperature = Annotated[float, Field(ge=0.0, le=1e9)]


class MovingWall(Resting):
    """A plane that oscillates or runs off takes a sphere along: velocity and spin.

    Shear: as a sphere that slides on a plane at rest, u + 2/5 r omega = 0, at the end 2/7 of
    its speed. Oscillating with acceleration a cos(w t), y'' + 2 d y' + W^2 y = -a cos(w t) on
    the plane: across W^2 = k_n / m, 2 d = eta_n / m; along 7/2 of k_t and eta_t over m, and 2/7
    of the velocity there.
    """

    quantities: ClassVar = ratios(
        halfway_gained_velocity_ratio="velocity that the sphere gained, over the plane's largest, "
        "halfway",
        gained_velocity_ratio="likewise, at the end",
        gained_spin_ratio="radius times spin, likewise",
        surface_momentum_ratio="of u + 2/5 r omega, over the plane's largest velocity",
    )

    allowed: ClassVar = {
        **Resting.allowed, "normal": ("hooke", "hertz"), "rolling": ("none",),
        "twisting": ("none",),
    }  # fmt: skip

    # fmt: off
    moves: Literal["shear", "along", "across"] = Field(
        "shear", description="[-] at a constant speed; oscillating along or across the surface")
    speed: Speed = Field(0.1, description="[m/s] of a plane that shears")
    acceleration: float = Field(
        0.1, gt=0.0, le=1e6, description="[-] largest of an oscillating plane, over gravity")
    period: float = Field(
        7.0, ge=0.1, le=1e6, description="[-] of the oscillation, in half periods of the contact")
    duration: float = Field(20.0, ge=1e-3, le=1e9, description="[-] in half periods of the contact")
    # fmt: on

    def check(self) -> None:
        """Raise ValueError for a law that no driven oscillator has."""
        super().check()
        if self.moves == "across" and not self.is_linear:
            reason = "must be a linear spring with a constant dashpot where the plane moves across"
            raise self.invalid("normal", reason)
        if self.moves == "along" and not self.has_spring:
            raise self.invalid("tangential", "must have a spring where the plane moves along")

    @property
    def drive(self) -> float:
        """Return the frequency of the oscillation [rad/s]."""
        return 2.0 * math.pi / (self.period * self.half_period)

    @property
    def largest_speed(self) -> float:
        """Return the largest velocity of the plane [m/s]."""
        if self.moves == "shear":
            return self.speed
        return self.acceleration * self.gravity / self.drive

    def scene(self) -> Scene:
        """Return the sphere at rest and the plane that moves."""
        scene = super().scene()
        (wall,) = scene.walls
        if self.moves == "shear":
            return scene.replace(walls=(wall.replace(surface_velocity=(self.speed, 0.0, 0.0)),))
        length = self.largest_speed / self.drive
        amplitude = (length, 0.0, 0.0) if self.moves == "along" else (0.0, 0.0, length)
        return scene.replace(walls=(wall.replace(amplitude=amplitude, frequency=self.drive),))

    def absent(self) -> Collection[str]:
        """Return the quantities of the spin where the plane moves across."""
        return ("gained_spin_ratio", "surface_momentum_ratio") if self.moves == "across" else ()

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return the gains of the sphere, the same seen from a plane that shears."""
        u, rim = self.rolling_speeds(motion)
        if self.moves == "across":
            u = motion.velocity[:, 0, 2]
        gained = (u - u[0]) / self.largest_speed
        halfway, end = float(gained[len(u) // 2]), float(gained[-1])
        return self._gains(halfway, end, float(rim[-1]) / self.largest_speed)

    def exact(self) -> Mapping[str, float]:
        """Return the driven oscillation; of a plane that shears what no friction changes.

        Raise RequestError for one that shakes the sphere off, or on which it slides.
        """
        if self.moves == "shear":
            return {"surface_momentum_ratio": 0.0}
        times = np.linspace(0.0, self.scene().duration, 2 * INSTANTS + 1)
        speeds = self._driven_velocity(times) / self.largest_speed
        halfway, end = float(speeds[INSTANTS]), float(speeds[-1])
        return self._gains(halfway, end, -2.5 * end)

    def _gains(self, halfway: float, end: float, rim: float) -> dict[str, float]:
        quantities = {"halfway_gained_velocity_ratio": halfway, "gained_velocity_ratio": end}
        if self.moves == "across":
            return quantities
        return {**quantities, "gained_spin_ratio": rim, "surface_momentum_ratio": end + 0.4 * rim}

    def _driven_velocity(self, times: Floats) -> Floats:
        """Return the velocity of the sphere [m/s] on a plane that oscillates, (M,)."""
        across, overlap = self.moves == "across", self.overlap_at_rest
        factor, k, eta = 1.0, self.slope(overlap), self.eta(overlap)
        if not across:
            factor, k = 3.5, self.tangential_slope(overlap)
            eta *= self.tangential_damping or 0.0
        frequency, decay = math.sqrt(factor * k / self.mass), 0.5 * factor * eta / self.mass
        acceleration = self.acceleration * self.gravity
        y, rate = driven(times, frequency, decay, acceleration, self.drive)
        force, limit = k * y + eta * rate, self.load * (1.0 if across else self.friction or 0.0)
        most = float(force.max() if across else np.abs(force).max())
        if most >= limit:
            raise RequestError(
                f"acceleration = {self.acceleration!r}: must be below "
                f"{self.acceleration * limit / most:.4g} here: the sphere must neither slide nor "
                "leave the plane"
            )
        return (rate + self.largest_speed * np.sin(self.drive * times)) / factor


class CurvedWall(Resting):
    """A sphere let go on a curved wall swings, rolls or falls.

    Integrated, R* = r R / (R - r) in a bowl, r R / (R + r) on a hill, r on an edge, and in a
    cylinder that of the mean curvature, 2 r R / (2 R - r). Small and stiff it swings with
    omega^2 = g / (R - r), rolling with 5/7 of it.
    """

    quantities: ClassVar = ratios(
        angle_ratio="angle from the vertical over that of the start",
        halfway_angle_ratio="likewise, halfway",
        sideways_velocity_ratio="horizontal velocity over g sin(angle) t, downhill",
        sideways_spin_ratio="radius times spin over g sin(angle) t, as it rolls down",
        overlap_ratio="overlap at the end over that at the start",
    )

    allowed: ClassVar = {
        **Resting.allowed, "normal": ("hooke", "hertz"), "rolling": ("none",),
        "twisting": ("none",),
        "damping": ("none", "velocity", "mass_velocity", "coeff_restitution", "viscoelastic"),
    }  # fmt: skip

    # fmt: off
    wall: Literal["bowl", "cylinder", "upright", "hill", "rim"] = Field(
        "bowl", description="[-] a bowl, a lying cylinder around the sphere, one along z in which "
        "gravity acts along y, a hill, or an edge")
    wall_radius: Radius = Field(0.02, description="[m] of the wall; a rim has none")
    angle: float = Field(
        30.0, ge=1e-3, le=60.0, description="[deg] of the sphere, at the start, from the vertical")
    # fmt: on

    def check(self) -> None:
        """Raise ValueError for a wall that is not around the sphere, and a law that it has not."""
        if self.is_hollow:
            self.check_range("wall_radius", 1.1 * self.radius, 1e3, "to be around the sphere")
        if self.wall == "rim" and self.normal != "hooke":
            raise self.invalid("normal", "must be hooke on a rim")
        on_hertz = self.is_cylinder and self.normal == "hertz"
        if on_hertz and self.damping in ("coeff_restitution", "viscoelastic"):
            raise self.invalid("damping", "must be without the radius of the contact in a cylinder")
        super().check()

    @property
    def is_hollow(self) -> bool:
        """Return whether the sphere is within the wall."""
        return self.wall == "bowl" or self.is_cylinder

    @property
    def is_cylinder(self) -> bool:
        """Return whether the sphere is within a cylinder."""
        return self.wall in ("cylinder", "upright")

    @property
    def pull(self) -> Vector:
        """Return gravity along the wall and into it, at the start [m/s2]."""
        angle = math.radians(self.angle)
        return (self.gravity * math.sin(angle), 0.0, -self.gravity * math.cos(angle))

    @property
    def curvature_radius(self) -> float:
        """Return the radius of the wall [m], negative where hollow."""
        if self.wall == "rim":
            return EDGE
        return -self.wall_radius if self.is_hollow else self.wall_radius

    @property
    def effective_radius(self) -> float:
        """Return R* [m] of the mean curvature; on an edge that of the sphere, as at a plane."""
        if self.wall == "rim":
            return self.radius
        other = self.curvature_radius * (2.0 if self.is_cylinder else 1.0)
        return self.radius * other / (self.radius + other)

    def scene(self) -> Scene:
        """Return the sphere at rest along the normal, and the wall about the origin."""
        flat = super().scene()
        angle = math.radians(self.angle)
        distance = self.radius + self.curvature_radius - self.overlap_at_rest
        place = (abs(distance) * math.sin(angle), 0.0, distance * math.cos(angle))
        is_round = self.wall in ("bowl", "hill")
        wall = Wall(
            shape="sphere" if is_round else "cylinder",
            direction=self._placed((0.0, 0.0, 1.0) if is_round else (0.0, 1.0, 0.0)),
            radius=abs(self.curvature_radius),
            hollow=self.is_hollow,
        )
        body = flat.bodies[0].replace(position=self._placed(place))
        gravity = self._placed((0.0, 0.0, -self.gravity))
        return flat.replace(bodies=(body,), walls=(wall,), gravity=gravity)

    def _placed(self, vector: Vector) -> Vector:
        """Return a vector of a lying wall, turned about x where the cylinder is upright."""
        x, y, z = vector
        return (x, -z, y) if self.wall == "upright" else vector

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return angles, velocities over those of a plane as steep, and the overlap."""
        x, z, spin = motion.position[:, 0, 0], motion.position[:, 0, 2], 1
        if self.wall == "upright":
            z, spin = -motion.position[:, 0, 1], 2
        sign = -1.0 if self.is_hollow else 1.0
        angle = np.arctan2(x, sign * z) / math.radians(self.angle)
        gained = self.pull[0] * float(motion.time[-1])
        overlap = self.radius + self.curvature_radius - sign * np.hypot(x, z)
        rim = self.radius * float(motion.angular_velocity[-1, 0, spin])
        return {
            "angle_ratio": float(angle[-1]),
            "halfway_angle_ratio": float(angle[len(angle) // 2]),
            "sideways_velocity_ratio": sign * float(motion.velocity[-1, 0, 0]) / gained,
            "sideways_spin_ratio": sign * rim / gained,
            "overlap_ratio": float(overlap[-1] / overlap[0]),
        }


class Drag(ContactSystem):
    """A falling sphere reaches its terminal velocity in a viscous fluid.

    m u' = m g - gamma u: u = v (1 - exp(-gamma t / m)), v = m g / gamma. The time in which steps
    are counted is m / gamma.
    """

    quantities: ClassVar = ratios(
        halfway_speed_over_terminal="speed of the fall over m g / gamma, halfway",
        speed_over_terminal="speed of the fall over m g / gamma, at the end",
        fall_ratio="height of the fall over m g / gamma times the time",
    )

    allowed: ClassVar = {**ContactSystem.allowed, "partner": ("wall",)}

    drag: float = Field(0.1, ge=1e-12, le=1e12, description="[kg/s] force over velocity")
    gravity: Gravity = Field(9.81, description="[m/s2] downward")
    duration: Duration = Field(2.0, description="[-] in times m / drag")

    def scene(self) -> Scene:
        """Return the sphere alone."""
        seconds = self.duration * self.mass / self.drag
        return Scene(
            bodies=self.bodies(0.0)[:1],
            law=self.stated_law,
            gravity=(0.0, 0.0, -self.gravity),
            drag=self.drag,
            **quarters(self.duration, self.duration * self.steps_per_contact, seconds),
        )

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return the speed halfway, at the end and on average, over the terminal speed m g / c."""
        terminal_speed = self.gravity * self.mass / self.drag
        fall = -motion.velocity[:, 0, 2] / terminal_speed
        distance = float(motion.position[0, 0, 2] - motion.position[-1, 0, 2])
        return {
            "halfway_speed_over_terminal": float(fall[len(fall) // 2]),
            "speed_over_terminal": float(fall[-1]),
            "fall_ratio": distance / terminal_speed / float(motion.time[-1]),
        }

    def exact(self) -> Mapping[str, float]:
        """Return the exponential approach."""
        (halfway, _), (speed, fallen) = (dragged(t * self.duration) for t in (0.5, 1.0))
        return {
            "halfway_speed_over_terminal": halfway,
            "speed_over_terminal": speed,
            "fall_ratio": fallen / self.duration,
        }


class Heat(ContactSystem):
    """Heat flows through a contact: two temperatures approach, or that of a wall.

    C_i T_i' = -+ G (T_1 - T_2), G = 2 k a or h pi a^2, a^2 = R* overlap: the difference decays
    as exp(-G (1/C_1 + 1/C_2) t), at a wall with 1/C_2 = 0; the heat of both stays.
    """

    quantities: ClassVar = ratios(
        halfway_excess_ratio="temperature of the first above that of the other at the start, over "
        "the difference then, halfway",
        excess_ratio="likewise, at the end",
        partner_excess_ratio="that of the second, likewise",
        heat_change_ratio="heat of both after less before, over that of the first above the other",
    )

    # a contact of other normal forces has another radius, or grows
    allowed: ClassVar = {
        "partner": ("wall", "sphere"), "normal": ("hooke", "hertz"), "interface": ("current",),
    }  # fmt: skip

    # fmt: off
    overlap: float = Field(1e-5, gt=0.0, description="[m] to which the sphere is pressed in")
    heat: Literal["radius", "area"] = Field(
        "radius", description="[-] conductance: that of a circle, 2 k a, or h pi a^2")
    conductance: float = Field(
        50.0, gt=0.0, le=1e15, description="[W/m/K] k of radius, [W/m2/K] h of area")
    heat_capacity: float = Field(500.0, ge=1e-9, le=1e9, description="[J/kg/K] of the spheres")
    temperature: Temperature = Field(400.0, description="[K] of the sphere, at the start")
    partner_temperature: Temperature = Field(
        300.0, description="[K] of the other sphere; a wall keeps it")
    duration: Duration = Field(2.0, description="[-] in times of the decay")
    # fmt: on

    def check(self) -> None:
        """Raise ValueError for an overlap out of range, and equal temperatures."""
        self.check_overlap("overlap", self.overlap)
        if math.isclose(self.temperature, self.partner_temperature, rel_tol=1e-6):
            raise self.invalid("partner_temperature", "must not be that of the sphere: no heat")

    @property
    def capacities(self) -> tuple[float, ...]:
        """Return the heat capacity of each body [J/K]; a wall has none."""
        masses = (self.mass,) if self.partner == "wall" else (self.mass, self.second_mass)
        return tuple(self.heat_capacity * mass for mass in masses)

    def scene(self) -> Scene:
        """Return the bodies, fixed at rest for the times of the decay of their difference."""
        flow = conductance(self.heat, self.conductance, self.contact_radius(self.overlap))
        seconds = self.duration / cooling_rate(flow, self.capacities)
        grid = quarters(self.duration, self.duration * self.steps_per_contact, seconds)
        temperatures = (self.temperature, self.partner_temperature)
        bodies = tuple(
            body.replace(temperature=temperature, heat_capacity=self.heat_capacity)
            for body, temperature in zip(self.bodies(-self.overlap), temperatures, strict=False)
        )
        still = (ZERO,) * len(bodies)
        return Scene(
            bodies=bodies,
            walls=tuple(wall.replace(temperature=self.partner_temperature) for wall in self.walls),
            law=self.stated_law,
            segments=(Segment(steps=grid["steps"], velocities=still, angular_velocities=still),),
            **grid,
        )

    def absent(self) -> Collection[str]:
        """Return the quantities of the second sphere at a wall."""
        return ("partner_excess_ratio", "heat_change_ratio") if self.partner == "wall" else ()

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return temperatures above that of the other at the start, and the heat of both."""
        if motion.temperature is None:
            raise EngineOutputError("the output has no temperatures")
        difference = self.temperature - self.partner_temperature
        above = (motion.temperature - self.partner_temperature) / difference
        quantities = {
            "halfway_excess_ratio": float(above[len(above) // 2, 0]),
            "excess_ratio": float(above[-1, 0]),
        }
        if self.partner == "sphere":
            first, second = self.capacities
            heat = above[:, 0] + above[:, 1] * second / first
            quantities["partner_excess_ratio"] = float(above[-1, 1])
            quantities["heat_change_ratio"] = float(heat[-1] - heat[0])
        return quantities

    def exact(self) -> Mapping[str, float]:
        """Return the exponential approach to the temperature of both, or of the wall."""
        decay = [math.exp(-part * self.duration) for part in (0.5, 1.0)]
        if self.partner == "wall":
            return {"halfway_excess_ratio": decay[0], "excess_ratio": decay[1]}
        first, second = self.capacities
        mean = first / (first + second)
        halfway, end = (mean + (1.0 - mean) * part for part in decay)
        return {
            "halfway_excess_ratio": halfway,
            "excess_ratio": end,
            "partner_excess_ratio": mean * (1.0 - decay[1]),
            "heat_change_ratio": 0.0,
        }


MOVING_WALL = ContactCase("moving-wall", MovingWall)
CURVED_WALL = ContactCase("curved-wall", CurvedWall)
DRAG = ContactCase("drag", Drag)
HEAT = ContactCase("heat", Heat)
