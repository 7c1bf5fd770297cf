"""Forces and torques along a prescribed motion: the contact law alone, without an integrator.

Pressed, sheared, sheared back, lifted, rolled, twisted. Laws of rolling or twisting resistance are
also turned forth and back during the shear, rolling without slip, so that friction is not changed:
their springs and dashpots act there below their limits, slide, and come back. Two spheres that
stick are also turned as one body: the spring must turn with the contact.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import ClassVar

import numpy as np
from pydantic import Field

from harness.cases.base import Quantity
from harness.cases.contacts import bounds, tables
from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.parameters import ContactSystem
from harness.model.base import ZERO, Vector
from harness.model.motion import Floats, Motion
from harness.model.scene import Scene, Segment
from harness.theory.contact import limited_forces

CHORDS = 4  # pieces of the path about the second sphere: closer by their sagitta between
PIECES = 6
SHEARS = {"half_shear_ratio": 3, "shear_ratio": 4, "reversed_ratio": 6, "lifted_ratio": 8}
TURNINGS = {"rolling": 10, "twisting": 12}  # the sample after each
SAMPLES = {"forth": 3, "back": 5, "lifted": 8}


class PrescribedMotion(ContactSystem):
    """A sphere that is pressed, sheared, sheared back, lifted a little, rolled, twisted; SI."""

    # fmt: off
    overlap: float = Field(1e-4, gt=0.0, description="[m] to which the sphere is pressed in")
    shear: float = Field(2e-5, gt=0.0, description="[m] along the surface, and twice that back")
    lift: float = Field(0.3, ge=0.0, le=0.999, description="[-] of the overlap, after the shear")
    turn: float = Field(1e-3, ge=1e-9, le=1e3, description="[rad] of rolling and of twisting")
    forth: float = Field(
        1e-3, ge=1e-9, le=1.0, description="[rad] forth and back during the shear: rolling by 3 r "
        "/ R* of it, twisting by 1.5")
    duration: float = Field(1e-3, ge=1e-12, le=1e9, description="[s] of each of the six pieces")
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

    def check(self) -> None:
        """Raise ValueError for a motion that leaves the contact, or in which it pulls."""
        if self.turned and self.partner != "sphere":
            raise ValueError(
                f"turned = {self.turned!r}: needs two spheres (partner = sphere), "
                f"got partner = {self.partner!r}"
            )
        bounds.check_overlap(self, "overlap", "m", self.overlap)
        (least, most), remaining = bounds.overlap_range(self), (1.0 - self.lift) * self.overlap
        if self.partner == "sphere":
            reach = self.radius + self.second_radius
            most = math.sqrt(0.9 * remaining * (2.0 * reach - 1.1 * remaining))
        why = "resolved, and a tenth of the overlap must be left next to the top of a sphere"
        bounds.check_range("shear", self.shear, "m", (least, most), why)
        if self.roll_forth and self.partner == "sphere":
            sideways = math.sqrt(most * most - self.shear * self.shear)
            largest = self.forth * sideways / (self.roll_forth * self.radius)
            bounds.check_range("forth", self.forth, "rad", (1e-9, largest), why)
        pull = self.eta(self.overlap) * self.lift * self.overlap
        push = self.elastic_energy(remaining) / remaining
        why = "the dashpot takes more than half of the force as the sphere is lifted"
        bounds.check_range("duration", self.duration, "s", (pull / push, 1e9), why)


def friction_scale(p: PrescribedMotion) -> float:
    """Return Coulomb's limit, 1 at most, or the ratio of a spring that sticks all the shear."""
    stuck = p.tangential_slope(p.overlap) * p.shear / p.elastic_force(p.overlap)
    return min(p.friction or 1.0, stuck or 1.0, 1.0)


def torque_scale(p: PrescribedMotion, *parts: str) -> float:
    """Return the limits of torques over radius and normal force in all, 1 at most."""
    limits = {
        "friction": p.friction or 0.0,
        "rolling": (p.rolling_friction or 0.0) * p.effective_radius / p.radius,
        "twisting": p.twisting_limit(p.overlap) / p.radius,
    }
    return min(sum(limits[part] for part in parts), 1.0) or 1.0


def _torque(name: str, meaning: str, *parts: str) -> Quantity[PrescribedMotion]:
    return Quantity(name, "1", meaning, lambda p: torque_scale(p, *parts))


def _ratio(name: str, meaning: str) -> Quantity[PrescribedMotion]:
    return Quantity(name, "1", meaning, friction_scale)


class PrescribedMotionCase(ContactCase[PrescribedMotion]):
    """Forces and torques along a given motion."""

    name = "prescribed-motion"
    summary = "Forces along a given motion: pressed, sheared to and fro, lifted, rolled, twisted."
    formula = (
        "The law integrated along the same motion; at a wall the torques of rolling and twisting "
        "forth and back in closed form. A pair that turns as one body keeps its forces, which turn "
        "with it, where the lever of the slip reaches to the contact; the lever r strains the "
        "spring by the turn times the overlap."
    )
    parameters = PrescribedMotion
    quantities = (
        _ratio("half_shear_ratio", "tangential over normal force, halfway the shear"),
        _ratio("shear_ratio", "likewise, after the shear"),
        _ratio("reversed_ratio", "likewise, after the shear back"),
        _ratio("lifted_ratio", "likewise, after the lift"),
        _torque("rolling_forth_ratio", "torque over radius and normal force, halfway", "rolling"),
        _torque("rolling_back_ratio", "likewise, halfway through the shear back", "rolling"),
        _torque("rolling_lifted_ratio", "likewise, after the lift", "rolling"),
        _torque("rolling_ratio", "likewise, after rolling", "friction", "rolling"),
        _torque("twisting_forth_ratio", "torque about the normal, halfway", "twisting"),
        _torque("twisting_back_ratio", "likewise, halfway through the shear back", "twisting"),
        _torque("twisting_lifted_ratio", "likewise, after the lift", "twisting"),
        _torque("twisting_ratio", "likewise, after twisting", "twisting"),
        _torque("held_ratio", "torque of rolling, after twisting", "friction", "rolling"),
        _ratio("turned_ratio", "tangential over normal force, both turned"),
    )
    laws: ClassVar = tables.laws(
        "tangential", "old_tangential", "rolling", "twisting", "cohesive_friction", "turning",
        "further_tangential", "further_rolling", "undamped_rolling", "undamped_twisting",
        "undamped_turning", "further_twisting",
    )  # fmt: skip
    systems: ClassVar = {
        **tables.systems("wall", "two spheres", "unequal spheres"),
        # a quarter of the shear, so that it sticks
        "two spheres, turned": {"partner": "sphere", "turned": 0.08, "shear": 5e-6},
        **tables.TWO_MATERIALS,
    }
    varied = tuple(tables.laws("rolling", "twisting"))
    varied_by_default = ("twisting sds, mindlin",)
    varied_in_quick = ("mindlin", "rolling sds, mindlin")

    def build(self, p: PrescribedMotion) -> Scene:
        """Return the pieces of the motion, the sphere at touch before."""
        if p.turned:
            return _turned_pair(p)
        half = math.ceil(p.steps_per_contact / 2)  # samples in the middle of each piece, too
        roll, twist, d, s = p.roll_forth, p.twist_forth, p.overlap, p.shear
        sideways = p.radius * roll
        bodies = p.bodies(0.0)
        rows: tuple[tuple[Vector, Vector], ...] = (
            ((0.0, 0.0, -d), ZERO),
            ((s, -sideways, 0.0), (roll, 0.0, twist)),
            ((-2.0 * s, sideways, 0.0), (-roll, 0.0, -twist)),
            ((0.0, 0.0, p.lift * d), ZERO),
            (ZERO, (p.turn, 0.0, 0.0)),
            (ZERO, (0.0, 0.0, p.turn)),
        )
        still = (ZERO,) * (len(bodies) - 1)
        rates = [[_over(each, p.duration) for each in row] for row in rows]
        segments = tuple(
            Segment(steps=2 * half, velocities=(v, *still), angular_velocities=(w, *still))
            for v, w in rates
        )
        return Scene(
            bodies=bodies,
            walls=p.walls,
            law=p.stated_law,
            step=p.duration / (2 * half),
            steps=PIECES * 2 * half,
            every=half,
            segments=segments,
        )

    def names(self, p: PrescribedMotion) -> Iterable[str]:
        """Return the quantities of the parts of the law, or of a pair that turns."""
        if p.turned:
            return ["shear_ratio", "turned_ratio"]
        both = p.rolling != "none" and p.twisting != "none"
        parts = [part for part in TURNINGS if getattr(p, part) != "none"]
        turnings = [f"{part}_{name}_ratio" for part in parts for name in SAMPLES]
        turnings += [f"{part}_ratio" for part in parts]
        return [*SHEARS, *turnings, *(["held_ratio"] if both else [])]

    def observe(self, p: PrescribedMotion, motion: Motion) -> Mapping[str, float]:
        """Return forces and torques at the ends of the pieces."""
        force, torque = motion.force[:, 0], motion.torque[:, 0]
        if p.turned:
            ratio = _tangential_ratio(motion)
            return {"shear_ratio": float(ratio[2]), "turned_ratio": float(ratio[-1])}
        load = p.radius * force[:, 2]
        quantities = {name: float(force[at, 0] / force[at, 2]) for name, at in SHEARS.items()}
        for part, last in TURNINGS.items():
            axis = 0 if part == "rolling" else 2
            for name, at in SAMPLES.items():
                quantities[f"{part}_{name}_ratio"] = float(torque[at, axis] / load[at])
            quantities[f"{part}_ratio"] = float(torque[last, axis] / load[last])
        quantities["held_ratio"] = float(torque[12, 0] / load[12])
        return {name: quantities[name] for name in self.names(p)}

    def exact(self, p: PrescribedMotion) -> Mapping[str, float]:
        """Return the torques of turning forth and back at a wall, where the load is constant."""
        if p.partner != "wall" or p.normal not in ("hooke", "hertz"):
            return {}
        exact, load, half = dict[str, float](), p.elastic_force(p.overlap), 0.5 * p.duration
        sliders = {}  # spring and dashpot, limit over the load, path, and lever of the torque
        if p.rolling == "sds":  # of r omega, and its torque of the force times r
            spring = p.rolling_stiffness or 0.0, p.rolling_damping or 0.0
            sliders["rolling"] = spring, p.rolling_friction or 0.0, p.radius * p.roll_forth, 1.0
        if p.twisting != "none":
            spring, limit = p.twisting_spring(p.overlap), p.twisting_limit(p.overlap)
            sliders["twisting"] = spring, limit, p.twist_forth, p.radius
        for name, (spring, limit, forth, lever) in sliders.items():
            pieces = [(0.5 * forth, half), (0.5 * forth, half), (-0.5 * forth, half)]
            first, _, back = limited_forces(*spring, limit * load, pieces)
            exact[f"{name}_forth_ratio"] = first / load / lever
            exact[f"{name}_back_ratio"] = back / load / lever
        return exact


def _over(moved: Vector, time: float) -> Vector:
    return (moved[0] / time, moved[1] / time, moved[2] / time)


def _turned_pair(p: PrescribedMotion) -> Scene:
    """Return the pair pressed, sheared, then turned about the second sphere.

    The second sphere spins all the time at the rate of the turn, as its spin cannot be changed;
    until the turn the first one spins the other way round, so that nothing slips.
    """
    n, time, angle = p.steps_per_contact, p.duration, p.turned / CHORDS
    rate = angle / time
    first, second = p.bodies(0.0, other_spin=(0.0, rate, 0.0))
    places = [np.array(first.position)]
    places.append(places[-1] + (0.0, 0.0, -p.overlap))
    places.append(places[-1] + (p.shear, 0.0, 0.0))
    centre = np.array(second.position)
    for _ in range(CHORDS):
        x, _, z = places[-1] - centre
        c, s = math.cos(angle), math.sin(angle)
        places.append(centre + np.array([c * x + s * z, 0.0, c * z - s * x]))
    spins = [-rate * second.radius / first.radius] * 2 + [rate] * CHORDS
    segments = tuple(
        Segment(
            steps=n,
            velocities=(tuple(((end - start) / time).tolist()), ZERO),
            angular_velocities=((0.0, spin, 0.0), second.angular_velocity),
        )
        for start, end, spin in zip(places, places[1:], spins, strict=False)
    )
    return Scene(
        bodies=(first, second),
        law=p.stated_law,
        step=time / n,
        steps=len(segments) * n,
        every=n,
        segments=segments,
    )


def _tangential_ratio(motion: Motion) -> Floats:
    """Return tangential over normal force, (M,), both along directions that turn with the pair."""
    between = motion.position[:, 0] - motion.position[:, 1]
    normal = between / np.linalg.norm(between, axis=1)[:, None]
    along = np.stack([normal[:, 2], np.zeros(len(normal)), -normal[:, 0]], axis=1)
    force = motion.force[:, 0]
    load = np.einsum("ij,ij->i", force, normal)
    load = np.where(load > 0.0, load, np.nan)
    return np.asarray(np.einsum("ij,ij->i", force, along) / load)


CASE = PrescribedMotionCase()
