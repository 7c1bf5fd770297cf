"""A grain above a fixed sphere of its size: parameters, script, scene, path and closed forms."""

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING, NamedTuple

from pydantic import Field, model_validator

from harness.cases.plane import COLUMNS, EqualSpheres, path_in
from harness.engines.base import Output, Template, Value
from harness.model.allowed import COUNT, Allowed, allowed_in
from harness.model.contact import SOURCE, Contact, NamedContact, contact_values
from harness.model.scene import Body, Scene
from harness.theory.contact import (
    duration_clipped,
    duration_unclipped,
    largest_overlap,
    restitution_clipped,
    restitution_unclipped,
)

if TYPE_CHECKING:
    from harness.model.motion import Floats

LEAST_OVERLAP = 1e6 * sys.float_info.epsilon  # [d] so that rounding is a millionth of it at most
MOST_DECADES = 290.0  # between 1 and a mass [kg], and that and a stiffness: floats have 308
RESTED = 1e-6  # part of its motion that a grain at rest keeps at most


class Drop(EqualSpheres):
    """One run of a grain above a fixed sphere of its size, in SI units.

    The sphere's centre is the origin, the grain starts at (0, diameter + gap) and moves down with
    ``speed`` and along x with ``sideways``; gravity points down.
    """

    # fmt: off
    contact: NamedContact = Field(SOURCE, description="[-] dissipation of the contact")
    steps_per_contact: float = Field(
        2000.0, gt=0.0, le=1e5, description="[-] steps per contact time pi sqrt(m/k)")
    gravity: float = Field(0.0, ge=0.0, description="[m/s2] acceleration of gravity, downward")
    gap: float = Field(0.0, gt=-0.25, le=10.0, description="[m] from the sphere; negative: pressed")
    speed: float = Field(0.0, description="[m/s] downward, at the start")
    sideways: float = Field(0.0, description="[m/s] along x, at the start")
    duration: float = Field(
        3.0, gt=0.0, le=1e4, description="[-] of the run, in contact times pi sqrt(m/k)")
    every: int = Field(1, ge=1, description="[-] steps between two samples of the path")
    # fmt: on

    @model_validator(mode="after")
    def _is_sound(self) -> Drop:
        mass = 3.0 * math.log10(self.diameter) + math.log10(self.density)
        if max(abs(mass), abs(mass - math.log10(self.stiffness))) > MOST_DECADES:
            raise ValueError(
                f"diameter = {self.diameter:g} m, density = {self.density:g} kg/m3, stiffness = "
                f"{self.stiffness:g} N/m: mass or contact time is beyond floating point"
            )
        if not self.gap > -0.25 * self.diameter:
            raise ValueError(
                f"gap = {self.gap!r} m: must be greater than {-0.25 * self.diameter:.4g} m, a "
                "quarter of the diameter"
            )
        overlap = self.largest_overlap
        if overlap and not LEAST_OVERLAP <= overlap / self.diameter <= 0.5:
            raise ValueError(
                f"the grain would press itself {overlap / self.diameter:.3g} diameters in at "
                f"stiffness = {self.stiffness:g} N/m, diameter = {self.diameter:g} m, speed = "
                f"{math.hypot(self.speed, self.sideways):g} m/s, gravity = {self.gravity:g} m/s2: "
                f"must be from {LEAST_OVERLAP:.2g} to 0.5"
            )
        return self

    @property
    def steps(self) -> int:
        """Return the number of steps, a multiple of ``every`` that covers the duration."""
        return self.every * math.ceil(self.duration * self.steps_per_contact / self.every - 1e-9)

    @property
    def seconds(self) -> float:
        """Return the time simulated [s]."""
        return self.steps * self.step

    @property
    def zeta(self) -> float:
        """Return the damping ratio of the grain on the fixed sphere."""
        return self.contact.zeta_against_full_mass

    @property
    def rest_overlap(self) -> float:
        """Return m g / k [m]."""
        return self.mass * self.gravity / self.stiffness

    @property
    def largest_overlap(self) -> float:
        """Return an upper bound of the overlap [m]: of a linear spring, undamped, head-on."""
        fall = math.sqrt(2.0 * self.gravity * max(self.gap, 0.0))
        speed = math.hypot(self.speed, self.sideways, fall)
        weight = self.rest_overlap
        return weight + math.hypot(weight, speed * math.sqrt(self.mass / self.stiffness))

    @property
    def largest_speed(self) -> float:
        """Return the size of speeds [m/s]: of the start, and of a fall to the end or the sphere."""
        falls = min(self.seconds, math.sqrt(2.0 * max(self.gap, 0.0) / (self.gravity or 1.0)))
        swings = 0.0 if self.gap > 0.0 else math.sqrt(self.mass / self.stiffness)
        return math.hypot(self.speed, self.sideways) + self.gravity * max(falls, swings)

    @property
    def fallen(self) -> float:
        """Return how far the grain falls in the run without contact [m]."""
        return self.speed * self.seconds + 0.5 * self.gravity * self.seconds**2


# ---- scripts and scenes

SAME = (
    "stiffness", "steps_per_contact", "gravity", "diameter", "density", "gap", "speed", "sideways",
)  # fmt: skip
HEAD_ON = Contact(name="head-on", restitution=0.5)


def values_of(case: Drop) -> dict[str, Value]:
    """Return a script's values for a drop."""
    values: dict[str, Value] = {name: getattr(case, name) for name in SAME}
    values |= {"steps": case.steps, "series_every": case.every}
    return {**values, **contact_values(case.contact)}


def scene_of(case: Drop) -> Scene:
    """Return the grain, body 0, and the fixed sphere."""
    size = {"radius": 0.5 * case.diameter, "mass": case.mass}
    place, velocity = (0.0, case.diameter + case.gap, 0.0), (case.sideways, -case.speed, 0.0)
    fixed = "frozen" if case.contact.effective_mass == "full" else "held"
    return Scene(
        bodies=(Body(**size, position=place, velocity=velocity), Body(**size, motion=fixed)),
        law=case.contact.law(case.stiffness), gravity=(0.0, -case.gravity, 0.0),
        step=case.step, steps=case.steps, every=case.every,
    )  # fmt: skip


TEMPLATE = Template(
    name="drop",
    variants={"": values_of(Drop(contact=HEAD_ON, gap=1e-3, speed=1.0))},
    allowed={
        **allowed_in(Drop),
        "damping": Allowed(words=("restitution", "ratio")),
        **allowed_in(Contact),
        "steps": COUNT,
        "series_every": COUNT,
    },
)


class Path(NamedTuple):
    """The grain's path, (M,) each: time [s], place [m] and velocity [m/s]."""

    time: Floats
    x: Floats
    y: Floats
    vx: Floats
    vy: Floats


def read_path(case: Drop, output: Output) -> Path:
    """Return every sample of the grain; raise EngineOutputError for what is missing or cut."""
    output.check_numbers({"step_s": case.step, "steps": case.steps})
    table = path_in(output, case.steps // case.every + 1)
    return Path(*(table[name] for name in COLUMNS))


# ---- closed forms


def restitution(case: Drop) -> float:
    """Return the restitution of a head-on collision with the linear spring [-]."""
    law = restitution_clipped if case.contact.clipped else restitution_unclipped
    return law(case.zeta)


def impact_duration(case: Drop) -> float:
    """Return how long the force of an impact lasts, over sqrt(m/k); from critical on for ever."""
    if case.contact.clipped:
        return duration_clipped(case.zeta)
    return duration_unclipped(case.zeta) if case.zeta < 1.0 else math.inf


def closed_forms(case: Drop) -> dict[str, float]:
    """Return the quantities of a drop with a closed form, none where nothing is known."""
    if case.sideways != 0.0:
        return {"angular_momentum_ratio": 1.0} if case.gravity == 0.0 else {}
    if case.gravity > 0.0 and case.gap > 0.0:
        end = {"end_overlap_m": case.fallen - case.gap,
               "end_speed_m_per_s": case.speed + case.gravity * case.seconds}  # fmt: skip
        return end if case.fallen < case.gap else {}
    if case.gravity > 0.0:
        slowest = case.zeta - math.sqrt(max(case.zeta**2 - 1.0, 0.0))
        left = math.exp(-slowest * math.sqrt(case.stiffness / case.mass) * case.seconds)
        return {"end_overlap_m": case.rest_overlap} if left <= RESTED else {}
    return _impact(case) if case.speed > 0.0 else {}


def _impact(case: Drop) -> dict[str, float]:
    """Return largest overlap and end of a collision that is over within the run.

    The motion turns at half the time at which the clipped force vanishes.
    """
    unit, found = math.sqrt(case.mass / case.stiffness), {}
    remaining = (case.seconds - max(case.gap, 0.0) / case.speed) / unit
    if remaining >= 0.5 * duration_clipped(case.zeta):
        found["largest_sampled_overlap_m"] = case.speed * largest_overlap(case.zeta) * unit
    if remaining >= impact_duration(case):
        found["restitution"] = restitution(case)
        found["end_speed_m_per_s"] = restitution(case) * case.speed
    return found
