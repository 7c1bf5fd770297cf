"""Motions along the normal: impacts, a bounce, and two spheres stacked between plates.

In an impact the first sphere flies at its partner, touches it, and leaves.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from harness.cases.base import Quantity
from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.parameters import (
    ContactSystem,
    Density,
    Duration,
    Gravity,
    Speed,
    ratios,
)
from harness.model.base import ZERO, Vector
from harness.model.scene import Floats, Motion, Scene, Wall, sphere
from harness.solvers.contact_time import before, contact_time, yield_time
from harness.theory import contact

SAMPLES = 100  # of a contact, about
DURATION = 1.1  # contact times simulated: a contact that a coarse step draws out must be over
FINER = 16  # times as many steps for a law whose state is brought on step by step
PARTS = 50  # steps of a contact, all levels being multiples, for the phase of the onset of yield
ROUND_OFF = 1e-9  # of the roots of a polynomial
Offset = Annotated[float, Field(ge=-0.1, le=0.1)]  # as far as the squeeze may go


@lru_cache(maxsize=4096)
def impact_scene(
    p: ContactSystem,
    velocity: Vector,
    spin: Vector = ZERO,
    other_spin: Vector = ZERO,
    *,
    sampled: bool,
    gravity: Vector = ZERO,
) -> Scene:
    """Return the impact of the first sphere, which touches half a step after the start.

    The second is at rest, but that it may spin. ``sampled`` over the contact, else at both ends.
    Raise RequestError for a contact that does not end, and for steps that are not stable.
    """
    n = p.steps_per_contact * (FINER if p.lags else 1)
    guess = 0.25 * p.elastic_overlap(-velocity[2]) / -velocity[2] / p.steps_per_contact
    touching = Scene(
        bodies=p.bodies(0.0, velocity, spin, other_spin),
        walls=p.walls,
        law=p.stated_law,
        gravity=gravity,
        step=1e-6 * guess,
        steps=1,
    )
    lasts = contact_time(touching)
    step = _step_in_phase(lasts / n, yield_time(touching), n)
    every = max(1, n // SAMPLES) if sampled else 1
    steps = every * math.ceil(DURATION * (float(n) if step == lasts / n else lasts / step) / every)
    scene = touching.replace(step=step, steps=steps, every=every if sampled else steps)
    return before(scene, 0.5 * step)


def _step_in_phase(step: float, until: float, n: int) -> float:
    """Return a step [s] as long or shorter, of which there is a whole number ``until`` [s].

    So yield, which is noticed at the end of a step, is so at one phase for all numbers of steps.
    """
    parts = FINER * PARTS
    if math.isinf(until):
        return step
    return until * parts / (math.ceil(until * parts / (n * step)) * n)


def relative_velocity(motion: Motion) -> Floats:
    """Return the velocity of the first sphere against its partner [m/s], (M, 3)."""
    v = motion.velocity
    return v[:, 0] - v[:, 1] if v.shape[1] > 1 else v[:, 0]


def overlap_and_rate(p: ContactSystem, motion: Motion) -> tuple[Floats, Floats]:
    """Return the overlap [m] and its rate [m/s], each (M,)."""
    x, v = motion.position, motion.velocity
    if p.partner == "wall":
        return p.radius - x[:, 0, 2], -v[:, 0, 2]
    separation = x[:, 0] - x[:, 1]
    distance = np.linalg.norm(separation, axis=1)
    rate = np.einsum("ij,ij->i", separation, relative_velocity(motion)) / distance
    return p.radius + p.second_radius - distance, -rate


def value_at_turn(time: Floats, value: Floats, rate: Floats) -> float:
    """Return a sampled value (M,) where its rate first crosses zero, NaN if it does not.

    Both cubic between the two samples about it, by Hermite's formula.
    """
    changes = np.flatnonzero(np.sign(rate[:-1]) * np.sign(rate[1:]) < 0.0)
    if not changes.size:
        return math.nan
    i = int(changes[0])
    h = float(time[i + 1] - time[i])
    slope = np.gradient(rate, time)
    inside = [
        root.real
        for root in np.roots(_cubic(rate[i : i + 2], h * slope[i : i + 2]))
        if abs(root.imag) < ROUND_OFF and -ROUND_OFF <= root.real <= 1.0 + ROUND_OFF
    ]
    if not inside:
        return math.nan
    return float(np.polyval(_cubic(value[i : i + 2], h * rate[i : i + 2]), inside[0]))


def _cubic(values: Floats, rates: Floats) -> Floats:
    """Return the coefficients, highest power first, of Hermite's cubic on 0 to 1."""
    (a, b), (u, v) = values, rates
    return np.array([2.0 * a - 2.0 * b + u + v, -3.0 * a + 3.0 * b - 2.0 * u - v, u, a])


def peak(value: Floats) -> float:
    """Return the largest of sampled values (M,), by the quartic through the five about it."""
    if np.isnan(value).any():
        return math.nan
    i = int(np.clip(np.argmax(value), 2, max(2, len(value) - 3)))
    near = value[i - 2 : i + 3]
    if len(near) < 5:
        return float(value.max())
    quartic = np.polyfit(np.arange(-2.0, 3.0), near, 4)
    roots = np.roots(np.polyder(quartic))
    places = [x.real for x in roots if abs(x.imag) < ROUND_OFF and abs(x.real) <= 2.0]
    return max([float(value.max()), *(float(np.polyval(quartic, x)) for x in places)])


class HeadOn(ContactSystem):
    """A sphere hits a wall or a sphere head-on: restitution, contact time, peaks.

    Linear spring: e = exp(-pi zeta / sqrt(1 - zeta^2)), contact time pi / (omega sqrt(1 -
    zeta^2)); Hertz: largest overlap (15 m* v^2 / (16 E* sqrt(R*)))^(2/5); constant restitution
    at every speed; the rest is integrated.
    """

    quantities: ClassVar = (
        Quantity("restitution", "1", "speed of departure over that of approach"),
        Quantity(
            "contact_time_s", "s", "of the first contact, while the surfaces overlap",
            lambda p: 2.0 * p.depth / p.speed,
        ),
        Quantity(
            "largest_overlap_m", "m", "overlap at the turning point, between the samples",
            lambda p: 0.5 * p.depth,
        ),
        Quantity(
            "largest_force_N", "N", "on the sphere, the dashpot's part included",
            lambda p: p.elastic_force(p.depth),
        ),
    )  # fmt: skip

    speed: Speed = Field(1.0, description="[m/s] of the approach")

    def check(self) -> None:
        """Raise ValueError for an impact that is too deep or too shallow."""
        self.check_impact("speed", self.speed)

    @property
    def depth(self) -> float:
        """Return the largest overlap without damping [m]."""
        return self.elastic_overlap(self.speed)

    def scene(self) -> Scene:
        """Return the impact, sampled over the contact."""
        return impact_scene(self, (0.0, 0.0, -self.speed), sampled=True)

    def absent(self) -> Sequence[str]:
        """Return contact time and overlap where a surface energy makes the bodies stick."""
        sticks = self.surface_energy is not None
        return ("contact_time_s", "largest_overlap_m") if sticks else ()

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return restitution and peaks; contact time and overlap where nothing sticks."""
        overlap, rate = overlap_and_rate(self, motion)
        quantities = {
            "restitution": float(relative_velocity(motion)[-1, 2]) / self.speed,
            "largest_force_N": peak(motion.force[:, 0, 2]),
        }
        if self.surface_energy is None:
            # at both ends of the run it flies freely, with a gap
            begin, end = (motion.time[i] - overlap[i] / rate[i] for i in (0, -1))
            quantities["contact_time_s"] = float(end - begin)
            quantities["largest_overlap_m"] = value_at_turn(motion.time, overlap, rate)
        return quantities

    def exact(self) -> Mapping[str, float]:
        """Return the quantities of linear springs, Hertz's, and constant restitution."""
        if self.is_linear:
            return self._exact_linear()
        if self.normal != "hertz" or self.clipped:
            return {}
        if self.damping == "none":
            impact = self.effective_mass, self.hertz_coefficient, self.speed
            return {
                "restitution": 1.0,
                "contact_time_s": contact.contact_time(*impact),
                "largest_overlap_m": contact.largest_hertz_overlap(*impact),
                "largest_force_N": contact.largest_force(*impact),
            }
        returned = self.damping == "coeff_restitution"
        return {"restitution": self.restitution or 0.0} if returned else {}

    def _exact_linear(self) -> dict[str, float]:
        zeta, omega = self.oscillator
        overlap = self.speed / omega * contact.largest_overlap(zeta)
        if self.clipped:
            restitution = contact.restitution_clipped(zeta)
            return {"restitution": restitution, "largest_overlap_m": overlap}
        if zeta >= 1.0:
            return {}
        return {
            "restitution": contact.restitution_unclipped(zeta),
            "contact_time_s": contact.duration_unclipped(zeta) / omega,
            "largest_overlap_m": overlap,
        }


class Bounce(ContactSystem):
    """A sphere falls on a floor or a sphere and bounces under gravity.

    m x'' = m g - F during the contact, free flight after it: height u^2 / 2 g. Piece by piece
    on a linear spring; without dissipation the height of the fall; else integrated.
    """

    quantities: ClassVar = (
        Quantity("rebound_ratio", "1", "height of the rebound over that of the fall"),
        Quantity(
            "contact_time_s", "s", "of the first contact, while the surfaces overlap",
            lambda p: 2.0 * p.elastic_overlap(p.speed) / p.speed,
        ),
    )  # fmt: skip

    # off a sphere it would fall, but round-off sideways has no time to grow within a contact
    allowed: ClassVar = {**ContactSystem.allowed, "partner": ("wall", "frozen")}

    height: float = Field(0.05, ge=1e-18, le=1e9, description="[m] of the fall")
    gravity: Gravity = Field(9.81, description="[m/s2] downward")

    @property
    def speed(self) -> float:
        """Return the speed at touch [m/s]."""
        return math.sqrt(2.0 * self.gravity * self.height)

    def check(self) -> None:
        """Raise ValueError for a fall that presses in too far, or less than the weight."""
        load = self.mass * self.gravity
        least = 0.5 * load / self.slope(self.rest_overlap(load))
        self.check_range("height", least, 1e9, "the weight presses in further than the fall")
        self.check_impact("height", self.speed, power=0.5)

    def scene(self) -> Scene:
        """Return the contact with gravity, from half a step before it on."""
        gravity = (0.0, 0.0, -self.gravity)
        return impact_scene(self, (0.0, 0.0, -self.speed), sampled=True, gravity=gravity)

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return the height that the sphere will reach, and the time of the contact."""
        g, z, v = self.gravity, motion.position[:, 0, 2], motion.velocity[:, 0, 2]
        # heights above touch, of fall and rebound, by the energy of free flight
        fall, rise = (float(z[i] - self.radius + 0.5 * v[i] ** 2 / g) for i in (0, -1))
        begin = float(motion.time[0]) + (math.sqrt(2.0 * g * fall) + float(v[0])) / g
        end = float(motion.time[-1]) - (math.sqrt(2.0 * g * rise) - float(v[-1])) / g
        return {"rebound_ratio": rise / self.height, "contact_time_s": end - begin}

    def exact(self) -> Mapping[str, float]:
        """Return height and time of the bounce on a linear spring, the height of an elastic one."""
        elastic = {"rebound_ratio": 1.0} if self.damping == "none" else {}
        if not self.is_linear or self.clipped:
            return elastic
        zeta, omega = self.oscillator
        after = contact.rebound(omega, zeta, self.gravity, self.speed) if zeta < 1.0 else None
        if after is None:
            return elastic
        ratio = after.speed**2 / (2.0 * self.gravity * self.height)
        return {"rebound_ratio": ratio, "contact_time_s": after.duration, **elastic}


class Stacked(ContactSystem):
    """Two stacked spheres oscillate between plates: three contacts at a time.

    m1 x1'' = F(floor) - F(between) - m1 g, m2 x2'' = F(between) - F(ceiling) - m2 g,
    integrated; with linear springs a linear system of two oscillators.
    """

    quantities: ClassVar = ratios(
        lambda p: p.scale,
        lower_height_ratio="rise of the lower sphere over the squeeze",
        upper_height_ratio="rise of the upper sphere over the squeeze",
        lower_speed_ratio="velocity over omega times the squeeze",
        upper_speed_ratio="likewise, of the upper sphere",
    )

    allowed: ClassVar = {**ContactSystem.allowed, "partner": ("sphere",)}

    # fmt: off
    squeeze: float = Field(0.005, gt=0.0, le=0.1, description="[-] of the height of both spheres")
    offset: Offset = Field(0.002, description="[-] of the lower sphere's radius, up, at the start")
    upper_offset: Offset = Field(0.0, description="[-] likewise, of the upper sphere")
    upper_density: Density | None = Field(
        None, description="[kg/m3] of the upper sphere; that of the lower unless given")
    gravity: float = Field(9.81, ge=0.0, le=1e9, description="[m/s2] downward")
    duration: Duration = Field(6.0, description="[-] in half periods pi sqrt(m / k)")
    # fmt: on

    @property
    def squeezed(self) -> float:
        """Return the height of the spheres less that of the room [m]."""
        return 2.0 * self.squeeze * (self.radius + self.second_radius)

    @property
    def weight(self) -> float:
        """Return the weight of both spheres [N]."""
        upper = sphere(self.second_radius, self.upper_density or self.density)
        return (self.mass + upper.mass) * self.gravity

    @property
    def omega(self) -> float:
        """Return sqrt(k / m) [1/s] with the stiffness at a third of the squeeze."""
        k = self.normal_stiffness
        if k is None:
            k = (self.youngs_modulus or 0.0) * self.contact_radius(self.squeezed / 3.0)
        return math.sqrt(k / self.mass)

    def check(self) -> None:
        """Raise ValueError for another material, and contacts that are too deep or too shallow."""
        for name in type(self).model_fields:
            of_partner = name.startswith("partner_") and name != "partner_radius"
            if of_partner and getattr(self, name) is not None:
                raise self.invalid(name, "must not be given: upper_density is that of this case")
        third, most = self.squeezed / 3.0, 0.5 * self.overlap_range[1]
        self.check_overlap("squeeze", third)
        upper = abs(self.upper_offset) * self.second_radius
        free = (most - third - upper) / self.radius
        reason = "no contact may begin with more than half the smaller radius: a swing doubles it"
        self.check_range("offset", -free, free, reason)
        if self.weight:
            most_gravity = self.gravity * most / self.rest_overlap(self.weight)
            self.check_range("gravity", 0.0, most_gravity, reason)

    @property
    def scale(self) -> float:
        """Return how far offsets and weight move the spheres, as a part of the squeeze."""
        offsets = abs(self.offset) * self.radius + abs(self.upper_offset) * self.second_radius
        return min(1.0, (offsets + self.rest_overlap(self.weight)) / self.squeezed) or 1.0

    def scene(self) -> Scene:
        """Return the spheres with the squeeze shared by the contacts, the lower one off."""
        r, upper = self.radius, self.second_radius
        top = 2.0 * (r + upper) - self.squeezed
        low = r - self.squeezed / 3.0 + self.offset * r
        high = top - upper + self.squeezed / 3.0 + self.upper_offset * upper
        steps = math.ceil(self.duration * self.steps_per_contact)
        bodies = (
            sphere(r, self.density, position=(0.0, 0.0, low)),
            sphere(upper, self.upper_density or self.density, position=(0.0, 0.0, high)),
        )
        return Scene(
            bodies=bodies,
            walls=(Wall(), Wall(point=(0.0, 0.0, top), direction=(0.0, 0.0, -1.0))),
            law=self.stated_law,
            gravity=(0.0, 0.0, -self.gravity),
            step=math.pi / self.omega / self.steps_per_contact,
            steps=steps,
            every=steps,
        )

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return the rise of each sphere, and its velocity, at the end."""
        rise = (motion.position[-1, :, 2] - motion.position[0, :, 2]) / self.squeezed
        speed = motion.velocity[-1, :, 2] / self.squeezed / self.omega
        return {
            "lower_height_ratio": float(rise[0]),
            "upper_height_ratio": float(rise[1]),
            "lower_speed_ratio": float(speed[0]),
            "upper_speed_ratio": float(speed[1]),
        }


HEAD_ON = ContactCase("head-on", HeadOn)
BOUNCE = ContactCase("bounce", Bounce)
STACKED = ContactCase("stacked", Stacked)
