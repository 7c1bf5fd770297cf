"""A sphere that its weight presses into a floor slides, rolls, or spins about the normal.

A spin about the normal that the spring stops before the torque reaches its limit swings from the
start: a damped oscillation of frequency sqrt(k / I), I = 2/5 m r^2. A faster one slips first, at a
constant rate.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from pydantic import Field

from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.parameters import (
    AngularSpeed,
    ContactSystem,
    Duration,
    Gravity,
    Speed,
    quarters,
    ratios,
)
from harness.model.base import ZERO, Vector
from harness.model.scene import Floats, Motion, Scene
from harness.theory.contact import (
    against_constant_torque,
    down_an_incline,
    on_an_incline,
    twisting_deceleration,
    twisting_spin,
)

LEAST_FRICTION = 1e-6  # with less, slipping lasts a day and longer


class Resting(ContactSystem):
    """A sphere pressed into its partner by its weight; in SI units."""

    allowed: ClassVar = {**ContactSystem.allowed, "partner": ("wall",)}

    gravity: Gravity = Field(9.81, description="[m/s2] downward")
    duration: Duration = Field(20.0, description="[-] in half periods of the contact")

    def check(self) -> None:
        """Raise ValueError for a weight that presses in too far, or too little."""
        power = 1.0 if self.normal == "hooke" else 2.0 / 3.0
        self.check_overlap("gravity", self.overlap_at_rest, power)

    @property
    def pull(self) -> Vector:
        """Return the acceleration of gravity [m/s2]."""
        return (0.0, 0.0, -self.gravity)

    @property
    def start(self) -> tuple[Vector, Vector]:
        """Return velocity [m/s] and angular velocity [rad/s] at the start."""
        return ZERO, ZERO

    @property
    def load(self) -> float:
        """Return the normal force at rest [N]."""
        return self.mass * -self.pull[2]

    @property
    def overlap_at_rest(self) -> float:
        """Return the overlap [m]; attraction is not taken into account."""
        return self.rest_overlap(self.load)

    @property
    def half_period(self) -> float:
        """Return pi sqrt(m / k) of small oscillations about rest [s]."""
        return math.pi * math.sqrt(self.mass / self.slope(self.overlap_at_rest))

    @property
    def seconds(self) -> float:
        """Return the duration [s]."""
        return self.duration * self.half_period

    def scene(self) -> Scene:
        """Return the sphere at rest along z under gravity; the steps fill the duration.

        There is a sample after each quarter. Raise RequestError for too many steps.
        """
        step = self.half_period / self.steps_per_contact
        return Scene(
            bodies=self.bodies(-self.overlap_at_rest, *self.start),
            walls=self.walls,
            law=self.stated_law,
            gravity=self.pull,
            **quarters(self.duration, self.seconds / step, self.seconds),
        )

    def rolling_speeds(self, motion: Motion) -> tuple[Floats, Floats]:
        """Return the speed along x, and radius times the spin about y, each (M,) [m/s]."""
        return motion.velocity[:, 0, 0], self.radius * motion.angular_velocity[:, 0, 1]


class SlipToRoll(Resting):
    """A sphere slides on a floor until it rolls, at 5/7 of its speed.

    u + 2/5 r omega stays u0, whatever the friction. It rolls from t = 2 u0 / (7 mu g) on, about
    5/7 u0, with what the tangential spring makes of it: integrated.
    """

    quantities: ClassVar = ratios(
        sliding_speed_ratio="speed over that of the start, while it slides",
        speed_ratio="speed over that of the start, at the end",
        rim_speed_ratio="radius times spin at the end over the speed at the start",
        momentum_ratio="u + 2/5 r omega at the end over the speed at the start",
    )

    speed: Speed = Field(0.1, description="[m/s] along the floor, at the start")
    duration: Duration = Field(1.5, description="[-] in times 2 u / (7 mu g) until it rolls")

    def check(self) -> None:
        """Raise ValueError without friction, and for a weight that presses in too far."""
        super().check()
        if (self.friction or 0.0) < LEAST_FRICTION:
            raise self.invalid("friction", f"must be at least {LEAST_FRICTION:g} to roll")

    @property
    def start(self) -> tuple[Vector, Vector]:
        """Return sliding without spin."""
        return (self.speed, 0.0, 0.0), ZERO

    @property
    def seconds(self) -> float:
        """Return the duration [s]."""
        return self.duration * (2.0 * self.speed / 7.0 / (self.friction or 1.0) / self.gravity)

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return speeds after the second quarter and at the end, spin at the end."""
        u, rim = self.rolling_speeds(motion)
        return {
            "sliding_speed_ratio": float(u[len(u) // 2]) / self.speed,
            "speed_ratio": float(u[-1]) / self.speed,
            "rim_speed_ratio": float(rim[-1]) / self.speed,
            "momentum_ratio": float(u[-1] + 0.4 * rim[-1]) / self.speed,
        }

    def exact(self) -> Mapping[str, float]:
        """Return the momentum about the floor, which no force there changes, but a torque does."""
        return {"momentum_ratio": 1.0} if self.rolling == "none" else {}


class RollingResistance(Resting):
    """A rolling sphere is slowed down by rolling resistance until it rests.

    The torque is at most mu_r R* F_n, R* = r on a floor: rolling slows down by 5/7 mu_r g, with
    the effect of the springs at the begin and at rest: integrated. A constant torque
    (model A of Ai and others, 2011) acts at any rate; at rest its sign changes from step to
    step.
    """

    quantities: ClassVar = ratios(
        halfway_speed_ratio="speed over that of the start, halfway",
        speed_ratio="speed over that of the start, at the end",
        rim_speed_ratio="radius times spin at the end over the speed at the start",
    )

    speed: Speed = Field(0.02, description="[m/s] of rolling, at the start")

    @property
    def start(self) -> tuple[Vector, Vector]:
        """Return rolling without slip."""
        return (self.speed, 0.0, 0.0), (0.0, self.speed / self.radius, 0.0)

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return the speed halfway, speed and rim speed at the end."""
        u, rim = self.rolling_speeds(motion)
        return {
            "halfway_speed_ratio": float(u[len(u) // 2]) / self.speed,
            "speed_ratio": float(u[-1]) / self.speed,
            "rim_speed_ratio": float(rim[-1]) / self.speed,
        }

    def exact(self) -> Mapping[str, float]:
        """Return the speeds under a constant torque and a spring, while it rolls."""
        spring, duration = self.tangential_slope(self.overlap_at_rest), self.scene().duration
        if self.rolling != "constant" or self.tangential_damping or not spring:
            return {}
        limits = (self.friction or 0.0) * self.load, (self.rolling_friction or 0.0) * self.load
        half, end = (
            against_constant_torque(time, self.speed, 0.0, self.mass, spring, limits)
            for time in (0.5 * duration, duration)
        )
        if half is None or end is None:
            return {}
        speeds = {"halfway_speed_ratio": half[0], "speed_ratio": end[0], "rim_speed_ratio": end[1]}
        return {name: value / self.speed for name, value in speeds.items()}


class InclineRoll(Resting):
    """A sphere let go on an incline rolls, or slides where the friction does not suffice.

    u + 2/5 r omega = g sin(angle) t. Sliding, from tan(angle) = 7/2 mu on: acceleration g (sin
    - mu cos), r times the angular one 5/2 mu g cos. Rolling: 5/7 g sin(angle), with what the
    tangential spring makes of it: integrated.
    """

    quantities: ClassVar = ratios(
        acceleration_ratio="mean over the second half, over g sin(angle)",
        rim_acceleration_ratio="radius times angular acceleration, likewise",
        momentum_ratio="u + 2/5 r omega over g sin(angle) t",
    )

    angle: float = Field(20.0, ge=1e-6, lt=90.0, description="[deg] tilt of the floor")
    gravity: Gravity = Field(9.81, description="[m/s2]")

    @property
    def pull(self) -> Vector:
        """Return gravity along the tilted floor and into it [m/s2]."""
        angle = math.radians(self.angle)
        return (self.gravity * math.sin(angle), 0.0, -self.gravity * math.cos(angle))

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return accelerations over the second half, and the momentum at the end."""
        u, rim = self.rolling_speeds(motion)
        half, pull = len(u) // 2, self.pull[0]
        gained = pull * float(motion.time[-1] - motion.time[half])
        return {
            "acceleration_ratio": float(u[-1] - u[half]) / gained,
            "rim_acceleration_ratio": float(rim[-1] - rim[half]) / gained,
            "momentum_ratio": float(u[-1] + 0.4 * rim[-1]) / (pull * float(motion.time[-1])),
        }

    def exact(self) -> Mapping[str, float]:
        """Return the momentum, and for a sphere that slides all the time both accelerations.

        Rolling resistance changes momentum and spin; a sphere that slides slides all the more.
        """
        exact = {"momentum_ratio": 1.0}
        expected = down_an_incline(math.radians(self.angle), self.friction or 0.0, self.gravity)
        if not expected.rolls and self.tangential != "linear_nohistory":
            exact["acceleration_ratio"] = expected.acceleration / self.pull[0]
            exact["rim_acceleration_ratio"] = expected.turning / self.pull[0]
        if self.rolling != "none":
            return {name: value for name, value in exact.items() if name == "acceleration_ratio"}
        return exact


class InclineRest(InclineRoll):
    """A sphere released on an incline rests by rolling resistance, or rolls against it.

    tan(angle) < mu_r: the springs hold it, at x = m g sin(angle) (1/k_t + 1/k_r) for a small
    overlap, about which it swings. Beyond: 5/7 g (sin(angle) - mu_r cos(angle)). Both exactly
    by linear springs in turn: a torque that the spring gives, and one of mu_r R* F_n.
    """

    quantities: ClassVar = (
        *ratios(
            lambda p: p.displacement_scale(1.0),
            displacement_ratio="of the centre along the incline, over g sin(angle) t^2 / 2",
        ),
        *ratios(
            lambda p: p.displacement_scale(0.5), halfway_displacement_ratio="likewise, halfway"
        ),
        *ratios(
            acceleration_ratio="mean over the second half, over g sin(angle)",
            rim_acceleration_ratio="radius times angular acceleration, likewise",
        ),
    )  # fmt: skip

    allowed: ClassVar = {**Resting.allowed, "rolling": ("sds",)}  # to hold a sphere

    def check(self) -> None:
        """Raise ValueError for a coefficient without which the sphere rolls away."""
        super().check()
        for name in ("rolling_friction", "rolling_stiffness", "friction"):
            if not getattr(self, name):
                raise self.invalid(name, "must be greater than 0 here")

    def displacement_scale(self, share: float) -> float:
        """Return the size of a displacement ratio: of a sphere that springs hold m p / k_r."""
        if math.tan(math.radians(self.angle)) >= (self.rolling_friction or 0.0):
            return 1.0
        k, time = self.rolling_stiffness or 1.0, share * self.seconds
        return min(1.0, 2.0 * self.mass / k / time**2)

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return the displacement, in all and over the first half, and the mean acceleration."""
        u, rim = self.rolling_speeds(motion)
        displacement = motion.position[:, 0, 0] - motion.position[0, 0, 0]
        at = [len(u) // 2, -1]
        return self._ratios(motion.time[at], displacement[at], u[at], rim[at])

    def exact(self) -> Mapping[str, float]:
        """Return the motion under springs and a constant torque, where nothing slides."""
        along = self.tangential_slope(self.overlap_at_rest)
        if self.normal not in ("hooke", "hertz") or not along:
            return {}
        times = self.scene().duration * np.array([0.5, 1.0])
        eta = (self.tangential_damping or 0.0) * self.eta(self.overlap_at_rest)
        spring = self.rolling_stiffness or 0.0, self.rolling_damping or 0.0
        limits = (self.friction or 0.0) * self.load, (self.rolling_friction or 0.0) * self.load
        states = on_an_incline(times, self.pull[0], self.mass, (along, eta), spring, limits)
        if states is None:
            return {}
        displacement, u, _, rim = np.array(states).T
        return self._ratios(times, displacement, u, rim)

    def _ratios(
        self, times: Floats, displacement: Floats, u: Floats, rim: Floats
    ) -> dict[str, float]:
        """Return the quantities from values halfway and at the end, each (2,)."""
        pull = self.pull[0]
        fallen, gained = 0.5 * pull * times**2, pull * (times[1] - times[0])
        return {
            "displacement_ratio": float(displacement[1] / fallen[1]),
            "halfway_displacement_ratio": float(displacement[0] / fallen[0]),
            "acceleration_ratio": float((u[1] - u[0]) / gained),
            "rim_acceleration_ratio": float((rim[1] - rim[0]) / gained),
        }


class Twist(Resting):
    """A sphere that spins about the line of contact is slowed down by a constant torque.

    The torque is at most mu_t F_n, for Marshall's submodel with mu_t = 2/3 a mu: while it slips
    the spin falls by 5/2 mu_t g / r^2. Below that limit it swings, a damped oscillation of
    frequency sqrt(k / I), I = 2/5 m r^2; it sticks again at the spin c mu_t m g / (I k).
    """

    quantities: ClassVar = ratios(
        halfway_spin_ratio="spin over that of the start, halfway",
        spin_ratio="spin at the end over that at the start",
        deceleration_ratio="mean of the second half, over 5/2 mu_t g / r^2",
    )

    allowed: ClassVar = {
        **Resting.allowed, "partner": ("wall", "frozen"), "twisting": ("sds", "marshall"),
    }  # fmt: skip

    spin: AngularSpeed = Field(20.0, description="[rad/s] at the start")

    def check(self) -> None:
        """Raise ValueError for a coefficient without which nothing slows the sphere down."""
        super().check()
        name = "friction" if self.twisting_friction is None else "twisting_friction"
        if not getattr(self, name):
            raise self.invalid(name, "must be greater than 0 to slow down")

    @property
    def start(self) -> tuple[Vector, Vector]:
        """Return the spin about the line of contact."""
        return ZERO, (0.0, 0.0, self.spin)

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return the spin halfway and at the end, and its loss in between."""
        spin = motion.angular_velocity[:, 0, 2]
        half = len(spin) // 2
        seconds = float(motion.time[-1] - motion.time[half])
        return self._ratios(float(spin[half]), float(spin[-1]), seconds)

    def exact(self) -> Mapping[str, float]:
        """Return the spin that the contact leaves, and its loss.

        Of springs with a load and an overlap in closed form, below critical damping.
        """
        inertia, overlap = 0.4 * self.mass * self.radius**2, self.overlap_at_rest
        spring = k, c = self.twisting_spring(overlap)
        if self.normal not in ("hooke", "hertz") or c * c >= 4.0 * k * inertia:
            return {}
        end, limit = self.scene().duration, self.twisting_limit(overlap) * self.load
        halfway, last = (
            twisting_spin(time, self.spin, inertia, spring, limit) for time in (0.5 * end, end)
        )
        return self._ratios(halfway, last, 0.5 * end)

    def _ratios(self, halfway: float, last: float, seconds: float) -> dict[str, float]:
        length = self.twisting_limit(self.overlap_at_rest)
        slipping = twisting_deceleration(length, self.radius, self.gravity)
        return {
            "halfway_spin_ratio": halfway / self.spin,
            "spin_ratio": last / self.spin,
            "deceleration_ratio": (halfway - last) / seconds / slipping,
        }


SLIP_TO_ROLL = ContactCase("slip-to-roll", SlipToRoll)
ROLLING_RESISTANCE = ContactCase("rolling-resistance", RollingResistance)
INCLINE_ROLL = ContactCase("incline-roll", InclineRoll)
INCLINE_REST = ContactCase("incline-rest", InclineRest)
TWIST = ContactCase("twist", Twist)
