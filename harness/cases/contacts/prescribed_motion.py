"""Forces and torques along a prescribed motion: the contact law alone, without an integrator.

Pressed, sheared, sheared back, lifted, rolled, twisted. Laws of rolling or twisting resistance are
also turned forth and back during the shear, rolling without slip, so that friction is not changed:
their springs and dashpots act there below their limits, slide, and come back. Two spheres that
stick are also turned as one body: the spring must turn with the contact.

A sphere that sticks is pulled off: the tension and overlap at parting.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from harness.cases.base import Quantity
from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.impact import overlap_and_rate
from harness.cases.contacts.parameters import ContactSystem, Speed
from harness.model.base import ZERO, Vector
from harness.model.scene import Body, Floats, Motion, Scene, Segment
from harness.theory import contact
from harness.theory.contact import limited_forces

CHORDS = 4  # pieces of the path about the second sphere: closer by their sagitta between
Rates = Sequence[tuple[tuple[Vector, ...], tuple[Vector, ...]]]  # of all bodies, in each piece


class Ratio(NamedTuple):
    """A component of the force, or of the torque over the radius, over the normal force.

    Of a torque ``parts`` are those that a law must have, and ``limits`` those of its size.
    """

    name: str
    meaning: str
    sample: int
    axis: int = 0
    parts: tuple[str, ...] = ()
    limits: str = ""

    def scale(self, p: PrescribedMotion) -> float:
        """Return the sum of the limits over radius and normal force [-], 1 at most.

        Of a force it is Coulomb's limit, or the ratio of a spring that sticks all the shear.
        """
        if not self.limits:
            stuck = p.tangential_slope(p.overlap) * p.shear
            return min(p.friction or 1.0, stuck / p.elastic_force(p.overlap) or 1.0, 1.0)
        torques = {
            "friction": p.friction or 0.0,
            "rolling": (p.rolling_friction or 0.0) * p.effective_radius / p.radius,
            "twisting": p.twisting_limit(p.overlap) / p.radius,
        }
        return min(sum(torques[name] for name in self.limits.split()), 1.0) or 1.0


ROLLING, TWISTING = ("rolling",), ("twisting",)
# fmt: off
RATIOS = (
    Ratio("half_shear_ratio", "tangential over normal force, halfway the shear", 3),
    Ratio("shear_ratio", "likewise, after the shear", 4),
    Ratio("reversed_ratio", "likewise, after the shear back", 6),
    Ratio("lifted_ratio", "likewise, after the lift", 8),
    Ratio("rolling_forth_ratio", "torque over radius and normal force, halfway",
          3, 0, ROLLING, "rolling"),
    Ratio("rolling_back_ratio", "likewise, halfway through the shear back",
          5, 0, ROLLING, "rolling"),
    Ratio("rolling_lifted_ratio", "likewise, after the lift", 8, 0, ROLLING, "rolling"),
    Ratio("rolling_ratio", "likewise, after rolling", 10, 0, ROLLING, "friction rolling"),
    Ratio("twisting_forth_ratio", "torque about the normal, halfway", 3, 2, TWISTING, "twisting"),
    Ratio("twisting_back_ratio", "likewise, halfway through the shear back",
          5, 2, TWISTING, "twisting"),
    Ratio("twisting_lifted_ratio", "likewise, after the lift", 8, 2, TWISTING, "twisting"),
    Ratio("twisting_ratio", "likewise, after twisting", 12, 2, TWISTING, "twisting"),
    Ratio("held_ratio", "torque of rolling, after twisting",
          12, 0, ROLLING + TWISTING, "friction rolling"),
    Ratio("turned_ratio", "tangential over normal force, both turned", 6),
)
TURNED = ("shear_ratio", "turned_ratio")  # of a pair that turns as one body
# fmt: on


class PrescribedMotion(ContactSystem):
    """Forces along a given motion: pressed, sheared to and fro, lifted, rolled, twisted.

    The law integrated along the same motion; at a wall the torques of rolling and twisting
    forth and back in closed form. A pair that turns as one body keeps its forces, which turn
    with it, where the lever of the slip reaches to the contact; the lever r strains the spring
    by the turn times the overlap.
    """

    quantities: ClassVar = tuple(Quantity(r.name, "1", r.meaning, r.scale) for r in RATIOS)

    # fmt: off
    overlap: float = Field(1e-4, gt=0.0, description="[m] to which the sphere is pressed in")
    shear: float = Field(2e-5, gt=0.0, description="[m] along the surface, and twice that back")
    lift: float = Field(0.3, ge=0.0, le=0.999, description="[-] of the overlap, after the shear")
    turn: float = Field(1e-3, ge=1e-9, le=1e3, description="[rad] of rolling and of twisting")
    forth: float = Field(
        1e-3, ge=1e-9, le=1.0, description="[rad] forth and back during the shear: rolling by 3 r "
        "/ R* of it, twisting by 1.5")
    duration: float = Field(1e-3, ge=1e-12, le=1e9, description="[s] of each of the six pieces")
    gap: float = Field(
        0.5, ge=0.0, le=1.0, description="[-] at the start, in steps of the press: at 0 the bodies "
        "just touch, and a code decides by its last digit whether they do")
    turned: float = Field(
        0.0, ge=0.0, le=0.2, description="[rad] by which two spheres that stick turn as one body, "
        "in place of all after the shear")
    # fmt: on

    @property
    def roll_forth(self) -> float:
        """Return the angle of rolling during the shear [rad]."""
        forth = 3.0 * self.forth * self.radius / self.effective_radius
        return forth if self.rolling != "none" else 0.0

    @property
    def twist_forth(self) -> float:
        """Return the angle of twisting during the shear [rad]."""
        return 1.5 * self.forth if self.twisting != "none" else 0.0

    def start_gap(self, steps: int) -> float:
        """Return the gap at the start [m] of a press of so many steps."""
        return self.gap * self.overlap / (steps - self.gap)

    def check(self) -> None:
        """Raise ValueError for a motion that leaves the contact, or in which it pulls."""
        if self.turned and self.partner != "sphere":
            raise self.invalid("turned", "needs two spheres (partner = sphere)")
        self.check_overlap("overlap", self.overlap)
        (least, most), remaining = self.overlap_range, (1.0 - self.lift) * self.overlap
        if self.partner == "sphere":
            distance = self.radius + self.second_radius
            most = math.sqrt(0.9 * remaining * (2.0 * distance - 1.1 * remaining))
        reason = "a tenth of the overlap must remain next to the top of a sphere"
        self.check_range("shear", least, most, reason)
        if self.roll_forth and self.partner == "sphere":
            sideways = math.sqrt(most * most - self.shear * self.shear)
            largest = self.forth * sideways / (self.roll_forth * self.radius)
            self.check_range("forth", 1e-9, largest, reason)
        pull = self.eta(self.overlap) * self.lift * self.overlap
        push = self.elastic_force(remaining) / (2.0 if self.normal == "hooke" else 2.5)
        reason = "the dashpot takes more than half of the force as the sphere is lifted"
        self.check_range("duration", pull / push, 1e9, reason)

    def scene(self) -> Scene:
        """Return the pieces of the motion, the sphere above its partner before."""
        if self.turned:
            return self._turned_pair()
        half = math.ceil(self.steps_per_contact / 2)  # samples in the middle of each piece, too
        roll, twist, d, s = self.roll_forth, self.twist_forth, self.overlap, self.shear
        sideways, gap = self.radius * roll, self.start_gap(2 * half)
        bodies = self.bodies(gap)
        pieces: tuple[tuple[Vector, Vector], ...] = (
            ((0.0, 0.0, -d - gap), ZERO),
            ((s, -sideways, 0.0), (roll, 0.0, twist)),
            ((-2.0 * s, sideways, 0.0), (-roll, 0.0, -twist)),
            ((0.0, 0.0, self.lift * d), ZERO),
            (ZERO, (self.turn, 0.0, 0.0)),
            (ZERO, (0.0, 0.0, self.turn)),
        )
        still = (ZERO,) * (len(bodies) - 1)
        rates = [[_rate(moved, self.duration) for moved in piece] for piece in pieces]
        return self._along(bodies, 2 * half, half, [((v, *still), (w, *still)) for v, w in rates])

    def _turned_pair(self) -> Scene:
        """Return the pair pressed, sheared, then turned about the second sphere.

        The second sphere spins all the time at the rate of the turn, as its spin cannot be changed;
        until the turn the first one spins the other way round, so that nothing slips.
        """
        n, time, angle = self.steps_per_contact, self.duration, self.turned / CHORDS
        rate = angle / time
        gap = self.start_gap(n)
        first, second = self.bodies(gap, other_spin=(0.0, rate, 0.0))
        places = [np.array(first.position)]
        places.append(places[-1] + (0.0, 0.0, -self.overlap - gap))
        places.append(places[-1] + (self.shear, 0.0, 0.0))
        centre = np.array(second.position)
        for _ in range(CHORDS):
            x, _, z = places[-1] - centre
            c, s = math.cos(angle), math.sin(angle)
            places.append(centre + np.array([c * x + s * z, 0.0, c * z - s * x]))
        velocities = (np.diff(places, axis=0) / time).tolist()
        spins = [-rate * second.radius / first.radius] * 2 + [rate] * CHORDS
        rates = [
            ((v, ZERO), ((0.0, spin, 0.0), second.angular_velocity))
            for v, spin in zip(velocities, spins, strict=True)
        ]
        return self._along((first, second), n, n, rates)

    def _along(self, bodies: tuple[Body, ...], steps: int, every: int, rates: Rates) -> Scene:
        """Return the scene of pieces of so many steps, at velocities and spins of all bodies."""
        segments = tuple(
            Segment(steps=steps, velocities=velocities, angular_velocities=spins)
            for velocities, spins in rates
        )
        return Scene(
            bodies=bodies,
            walls=self.walls,
            law=self.stated_law,
            step=self.duration / steps,
            steps=len(segments) * steps,
            every=every,
            segments=segments,
        )

    def absent(self) -> Collection[str]:
        """Return the quantities of the parts that the law lacks, and of another motion."""
        if self.turned:
            return {ratio.name for ratio in RATIOS} - {*TURNED}
        lacking = {part for part in ROLLING + TWISTING if getattr(self, part) == "none"}
        return {ratio.name for ratio in RATIOS if lacking & {*ratio.parts}} | {"turned_ratio"}

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return forces and torques at the ends of the pieces."""
        if self.turned:
            ratio = _tangential_ratio(motion)
            return dict(zip(TURNED, (float(ratio[2]), float(ratio[-1])), strict=True))
        force, torque, absent = motion.force[:, 0], motion.torque[:, 0], self.absent()
        load = self.radius * force[:, 2]
        return {
            name: float(torque[at, axis] / load[at] if parts else force[at, axis] / force[at, 2])
            for name, _, at, axis, parts, _ in RATIOS
            if name not in absent
        }

    def exact(self) -> Mapping[str, float]:
        """Return the torques of turning forth and back at a wall, where the load is constant."""
        if self.partner != "wall" or self.normal not in ("hooke", "hertz"):
            return {}
        exact: dict[str, float] = {}
        load, half = self.elastic_force(self.overlap), 0.5 * self.duration
        sliders = {}  # spring and dashpot, limit over the load, path, and lever of the torque
        if self.rolling == "sds":  # of r omega, and its torque of the force times r
            spring = self.rolling_stiffness or 0.0, self.rolling_damping or 0.0
            path = self.radius * self.roll_forth
            sliders["rolling"] = spring, self.rolling_friction or 0.0, path, 1.0
        if self.twisting != "none":
            spring, limit = self.twisting_spring(self.overlap), self.twisting_limit(self.overlap)
            sliders["twisting"] = spring, limit, self.twist_forth, self.radius
        for name, (spring, limit, forth, lever) in sliders.items():
            pieces = [(0.5 * forth, half), (0.5 * forth, half), (-0.5 * forth, half)]
            first, _, back = limited_forces(*spring, limit * load, pieces)
            exact[f"{name}_forth_ratio"] = first / load / lever
            exact[f"{name}_back_ratio"] = back / load / lever
        return exact


def _rate(moved: Vector, time: float) -> Vector:
    return (moved[0] / time, moved[1] / time, moved[2] / time)


def _tangential_ratio(motion: Motion) -> Floats:
    """Return tangential over normal force, (M,), both along directions that turn with the pair."""
    separation = motion.position[:, 0] - motion.position[:, 1]
    normal = separation / np.linalg.norm(separation, axis=1)[:, None]
    along = np.stack([normal[:, 2], np.zeros(len(normal)), -normal[:, 0]], axis=1)
    force = motion.force[:, 0]
    load = np.einsum("ij,ij->i", force, normal)
    load = np.where(load > 0.0, load, np.nan)
    return np.asarray(np.einsum("ij,ij->i", force, along) / load)


PRESCRIBED_MOTION = ContactCase("prescribed-motion", PrescribedMotion)


class PullOff(ContactSystem):
    """A sphere that sticks is pulled off: largest tension, and overlap where it parts.

    DMT: 4 pi gamma R*, at touch. JKR: 3 pi gamma R*, at -a^2 / (3 R*) with a^3 = 9 pi gamma
    R*^2 / (4 E*); gamma is the energy of each surface. mdr, on each side of a flat with which a
    sphere has the energy gamma: 3/2 pi gamma R for small a / R, down to a vanishing area.
    """

    quantities: ClassVar = (
        Quantity("pull_off_force_N", "N", "largest tension", lambda p: p.force_scale),
        Quantity(
            "parting_ratio", "1", "overlap at the last force over that of the start",
            lambda p: p.neck_ratio,
        ),
    )  # fmt: skip

    allowed: ClassVar = {
        **ContactSystem.allowed, "normal": ("dmt", "jkr", "mdr"), "damping": ("none",),
    }  # fmt: skip

    overlap: float = Field(1e-5, gt=0.0, description="[m] at the start")
    speed: Speed = Field(1e-3, description="[m/s] of the pull")

    def check(self) -> None:
        """Raise ValueError without attraction, and for an overlap that a step does not resolve."""
        if self.normal == "mdr" and not self.surface_energy:
            raise self.invalid("surface_energy", "normal = mdr needs one, above 0")
        self.check_overlap("overlap", self.overlap)
        # the force at the last step before it parts is that of half a step of overlap there
        tension = contact.jkr_pull_off(self.surface_energy or 0.0, self.effective_radius)
        step = (0.1 * tension / self.hertz_coefficient) ** (2.0 / 3.0)
        reason = (
            "with these steps_per_contact the elastic force of a step is a tenth of the tension"
        )
        self.check_range("overlap", 0.0, self.steps_per_contact * step, reason)

    @property
    def tension_and_overlap(self) -> tuple[float, float]:
        """Return the largest tension [N], and the overlap where the sphere parts [m]."""
        gamma, radius = self.surface_energy or 0.0, self.effective_radius
        modulus = self.moduli[0] if self.moduli else 0.0
        if self.normal == "mdr":
            flats = 1.0 if self.partner == "wall" else 2.0
            tension, last = contact.mdr_pull_off(gamma, 2.0 * modulus, self.radius)
            return tension, flats * last
        if self.normal == "dmt":
            return contact.dmt_pull_off(gamma, radius), 0.0
        last = contact.jkr_overlap("largest tension", gamma, modulus, radius)
        return contact.jkr_pull_off(gamma, radius), last

    @property
    def force_scale(self) -> float:
        """Return the size of the tension [N]; of mdr the elastic force at the start.

        mdr's ellipse has t - sin(t) of an angle t = 0.03 from its cosine: a rounding of 2e-16 / t
        in t is 3e-10 of t^3 / 6. So many digits of the elastic force remain where the forces
        nearly balance.
        """
        if self.normal == "mdr":
            return self.elastic_force(self.overlap)
        return self.tension_and_overlap[0]

    @property
    def neck_ratio(self) -> float:
        """Return the neck of JKR at its largest tension over the overlap of the start."""
        modulus, gamma = self.moduli[0] if self.moduli else 0.0, self.surface_energy or 0.0
        neck = contact.jkr_overlap("largest tension", gamma, modulus, self.effective_radius)
        return -neck / self.overlap or 1.0

    def scene(self) -> Scene:
        """Return the pull, which parts half a step before the end."""
        steps, bodies = self.steps_per_contact, self.bodies(-self.overlap)
        distance = self.overlap - self.tension_and_overlap[1]
        still = (ZERO,) * len(bodies)
        pull = Segment(
            steps=steps, velocities=((0.0, 0.0, self.speed), *still[1:]), angular_velocities=still
        )
        return Scene(
            bodies=bodies,
            walls=self.walls,
            law=self.stated_law,
            step=distance / self.speed / (steps - 0.5),
            steps=steps,
            segments=(pull,),
        )

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return the largest tension and the last overlap with a force."""
        force = motion.force[:, 0, 2]
        overlap, _ = overlap_and_rate(self, motion)
        last = int(np.flatnonzero(force)[-1])
        parted = last < len(force) - 1
        return {
            "pull_off_force_N": -float(force.min()),
            "parting_ratio": float(overlap[last]) / self.overlap if parted else math.nan,
        }

    def exact(self) -> Mapping[str, float]:
        """Return tension and overlap where the sphere parts."""
        tension, last = self.tension_and_overlap
        return {"pull_off_force_N": tension, "parting_ratio": last / self.overlap}


PULL_OFF = ContactCase("pull-off", PullOff)
