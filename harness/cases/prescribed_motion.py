"""Forces and torques along a prescribed motion: the contact law alone, without an integrator.

Pressed, sheared, sheared back, lifted, rolled, twisted. Laws of rolling or twisting resistance are
also turned forth and back during the shear, rolling without slip, so that friction is not changed:
their springs and dashpots act there below their limits, slide, and come back. Two spheres that
stick are also turned as one body: the spring must turn with the contact.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import ClassVar

import numpy as np
from pydantic import Field

from harness.cases.contact.contact_case import ContactCase
from harness.cases.contact.motion import Array, Motion, reference_motion
from harness.cases.contact.parameters import (
    ContactSystem,
    between,
    dashpots,
    elastic_force,
    energy,
    overlaps,
    pressed,
    twisting_limit,
    twisting_spring,
)
from harness.cases.contact.submodels import (
    COHESIVE_FRICTION,
    OLD_TANGENTIAL,
    ROLLING,
    ROLLING_BESIDE,
    ROLLING_UNDAMPED,
    SLIDING,
    SYSTEMS,
    TANGENTIAL,
    TANGENTIAL_BESIDE,
    TURNING,
    TURNING_UNDAMPED,
    TWISTING,
    TWISTING_BESIDE,
    TWISTING_UNDAMPED,
    TWO_MATERIALS,
    Told,
)
from harness.cases.contact.verification import ContactVerification, TrialRun
from harness.cases.verification import Study
from harness.comparison.verdicts import Check, finding
from harness.comparison.verification import Findings
from harness.engines.contract import Engine
from harness.parameters.scene import ZERO, ContactScene, Segment, Vector
from harness.theory.contact import limited_forces

SHOWN = "linear_history"
"""The submodel whose strain is told."""

CHORDS = 4
"""Pieces of the path about the second sphere: the spheres come closer by their sagitta between."""


def turned_pair(parameters: PrescribedMotion) -> ContactScene:
    """Return the pair pressed, sheared, then turned about the second sphere.

    The second sphere spins all the time at the rate of the turn, as its spin cannot be changed;
    until the turn the first one spins the other way round, so that nothing slips.
    """
    n, time = parameters.steps_per_contact, parameters.duration
    angle = parameters.turned / CHORDS
    rate = angle / time
    first, second = parameters.bodies(0.0, ZERO)
    ratio = second.radius / first.radius
    second = replace(second, omega=(0.0, rate, 0.0))
    places = [np.array(first.position)]
    places.append(places[-1] + (0.0, 0.0, -parameters.overlap))
    places.append(places[-1] + (parameters.shear, 0.0, 0.0))
    centre = np.array(second.position)
    for _ in range(CHORDS):
        x, _, z = places[-1] - centre
        c, s = math.cos(angle), math.sin(angle)
        places.append(centre + np.array([c * x + s * z, 0.0, c * z - s * x]))
    spins = [-rate * ratio] * 2 + [rate] * CHORDS
    segments = tuple(
        Segment(n, (_velocity(start, end, time), ZERO), ((0.0, spin, 0.0), second.omega))
        for start, end, spin in zip(places, places[1:], spins, strict=False)
    )
    return ContactScene(
        (first, second),
        (),
        parameters.law,
        step=time / n,
        steps=len(segments) * n,
        every=n,
        segments=segments,
    )


def _velocity(start: Array, end: Array, time: float) -> Vector:
    x, y, z = (end - start) / time
    return float(x), float(y), float(z)


def tangential_ratio(motion: Motion) -> Array:
    """Return tangential over normal force, (M,), both along directions that turn with the pair."""
    apart = motion.position[:, 0] - motion.position[:, 1]
    normal = apart / np.linalg.norm(apart, axis=1)[:, None]
    along = np.stack([normal[:, 2], np.zeros(len(normal)), -normal[:, 0]], axis=1)
    force = motion.force[:, 0]
    pressed = np.einsum("ij,ij->i", force, normal)
    pressed = np.where(pressed > 0.0, pressed, np.nan)
    return np.asarray(np.einsum("ij,ij->i", force, along) / pressed)


def levers(case: ContactCase[PrescribedMotion], tried: Sequence[TrialRun]) -> Iterator[Check]:
    """Yield the rows of a pair turned as one body, by the lever of an engine's slip velocity."""
    for run in tried:
        parameters = run.trial.parameters
        shown = parameters.turned and run.trial.submodel == SHOWN and run.values
        if not shown or run.rules.velocity_lever == "contact_point":
            continue
        rules = run.rules.replace(velocity_lever="contact_point")
        objective = case.observed(parameters, reference_motion(run.scene, rules))
        yield finding(
            f"{case.name}, {run.trial.system}: {SHOWN}, {run.engine}: what turning strains",
            run.values["turned_ratio"],
            objective["turned_ratio"],
            "",
            "expected with levers that reach to the contact: the forces turn with the pair; with "
            f"the lever {run.rules.velocity_lever} a turn by {parameters.turned:g} rad "
            f"strains the spring by that times the overlap of {1e6 * parameters.overlap:g} µm",
        )


class PrescribedMotion(ContactSystem):
    """A sphere that is pressed, sheared, sheared back, lifted a little, rolled, twisted; SI."""

    overlap: float = Field(1e-4, gt=0.0, description="[m] to which the sphere is pressed in")
    shear: float = Field(2e-5, gt=0.0, description="[m] along the surface, and twice that back")
    lift: float = Field(0.3, ge=0.0, le=0.999, description="[-] of the overlap, after the shear")
    turn: float = Field(1e-3, ge=1e-9, le=1e3, description="[rad] of rolling and of twisting")
    forth: float = Field(
        1e-3,
        ge=1e-9,
        le=1.0,
        description="[rad] forth and back beside the shear: rolling by 3 r / R* of it, twisting by "
        "1.5",
    )
    duration: float = Field(1e-3, ge=1e-12, le=1e9, description="[s] of each of the six pieces")
    turned: float = Field(
        0.0,
        ge=0.0,
        le=0.2,
        description="[rad] by which two spheres that stick turn as one body, instead of what "
        "follows the shear",
    )

    @property
    def roll_forth(self) -> float:
        """Return the angle of rolling during the shear [rad]."""
        forth = 3.0 * self.forth * self.radius / self.reduced_radius
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
        pressed(self, "overlap", "m", self.overlap)
        (least, most), remaining = overlaps(self), (1.0 - self.lift) * self.overlap
        if self.partner == "sphere":
            reach = self.radius + self.second_radius
            most = math.sqrt(0.9 * remaining * (2.0 * reach - 1.1 * remaining))
        why = "resolved, and a tenth of the overlap must be left beside the top of a sphere"
        between("shear", self.shear, "m", (least, most), why)
        if self.roll_forth and self.partner == "sphere":
            along = self.roll_forth * self.radius
            aside = math.sqrt(most * most - self.shear * self.shear)
            between("forth", self.forth, "rad", (1e-9, self.forth * aside / along), why)
        pull = dashpots(self, self.overlap) * self.lift * self.overlap
        push = energy(self, remaining) / remaining
        why = "the dashpot takes more than half of the force as the sphere is lifted"
        between("duration", self.duration, "s", (pull / push, 1e9), why)


PIECES = 6

TURNED = "two spheres, turned"

SLACK = 1e-9
"""[mrad] of round-off."""


class PrescribedMotionCase(ContactCase[PrescribedMotion]):
    """Forces along a given motion: pressed, sheared to and fro, lifted, rolled, twisted."""

    name = "prescribed-motion"
    verified_by = "harness.cases.prescribed_motion:PrescribedMotionVerification"
    submodels = (
        *(*TANGENTIAL, *OLD_TANGENTIAL, *ROLLING, *TWISTING),
        *(*COHESIVE_FRICTION, *TURNING),
    )
    other_submodels = (
        *(*TANGENTIAL_BESIDE, *ROLLING_BESIDE),
        *(*ROLLING_UNDAMPED, *TWISTING_UNDAMPED, *TURNING_UNDAMPED, *TWISTING_BESIDE),
    )
    invariant = (*ROLLING, *TWISTING)
    over_ranks = ("rolling sds, mindlin", "twisting sds, mindlin")
    by_defaults = (
        "mindlin",
        "rolling sds, mindlin",
    )
    sets: ClassVar[Told] = {"usual": SLIDING}
    systems: ClassVar[Told] = {
        **{name: changes for name, changes in SYSTEMS.items() if name != "frozen sphere"},
        # a quarter of the shear, so that it sticks
        TURNED: {"partner": "sphere", "turned": 0.08, "shear": 5e-6},
        **TWO_MATERIALS,
    }

    def scene(self, parameters: PrescribedMotion) -> ContactScene:
        """Return the pieces of the motion, the sphere at touch before."""
        if parameters.turned:
            return turned_pair(parameters)
        bodies = tuple(parameters.bodies(0.0, ZERO))
        # samples are taken in the middle of each piece, too
        half, time = math.ceil(parameters.steps_per_contact / 2), parameters.duration
        n = 2 * half
        still = (ZERO,) * len(bodies)

        def piece(v: Vector = ZERO, w: Vector = ZERO) -> Segment:
            moved = (v[0] / time, v[1] / time, v[2] / time)
            turned = (w[0] / time, w[1] / time, w[2] / time)
            return Segment(n, (moved, *still[1:]), (turned, *still[1:]))

        d, s, turn = parameters.overlap, parameters.shear, parameters.turn
        roll, twist = parameters.roll_forth, parameters.twist_forth
        aside = parameters.radius * roll
        pieces = (
            piece((0.0, 0.0, -d)),
            piece((s, -aside, 0.0), (roll, 0.0, twist)),
            piece((-2.0 * s, aside, 0.0), (-roll, 0.0, -twist)),
            piece((0.0, 0.0, parameters.lift * d)),
            piece(w=(turn, 0.0, 0.0)),
            piece(w=(0.0, 0.0, turn)),
        )
        return ContactScene(
            bodies,
            parameters.planes,
            parameters.law,
            step=time / n,
            steps=PIECES * n,
            every=half,
            segments=pieces,
        )

    def observed(self, parameters: PrescribedMotion, motion: Motion) -> Mapping[str, float]:
        """Return forces and torques at the ends of the pieces."""
        force, torque = motion.force[:, 0], motion.torque[:, 0]
        if parameters.turned:
            ratio = tangential_ratio(motion)
            return {"shear_ratio": float(ratio[2]), "turned_ratio": float(ratio[-1])}
        halfway, shear, halfway_back, back, lifted, rolled, twisted = 3, 4, 5, 6, 8, 10, 12
        pressed = parameters.radius * force[:, 2]
        quantities = {
            name: float(force[at, 0] / force[at, 2])
            for name, at in (
                ("half_shear_ratio", halfway),
                ("shear_ratio", shear),
                ("reversed_ratio", back),
                ("lifted_ratio", lifted),
            )
        }
        turnings = (("rolling", 0, rolled), ("twisting", 2, twisted))
        for part, axis, last in turnings:
            if getattr(parameters, part) != "none":
                samples = {"forth": halfway, "back": halfway_back, "lifted": lifted, "": last}
                for name, at in samples.items():
                    quantity = "_".join(filter(None, (part, name, "ratio")))
                    quantities[quantity] = float(torque[at, axis] / pressed[at])
        if parameters.rolling != "none" and parameters.twisting != "none":
            quantities["held_ratio"] = float(torque[twisted, 0] / pressed[twisted])
        return quantities

    def sizes(self, parameters: PrescribedMotion) -> Mapping[str, float]:
        """Return Coulomb's limits of the ratios, 1 at most: larger ones are not reached.

        Of torques of two sliders about one axis their sum.
        """
        friction, r = parameters.friction or 0.0, parameters.radius
        rolling = (parameters.rolling_friction or 0.0) * parameters.reduced_radius / r
        twisting = twisting_limit(parameters, parameters.overlap) / r
        turned = ("forth", "back", "lifted")
        shears = ("half_shear_ratio", "shear_ratio", "reversed_ratio", "lifted_ratio")
        limits = {
            **dict.fromkeys((*shears, "turned_ratio"), friction),
            **{f"rolling_{name}_ratio": rolling for name in turned},
            **dict.fromkeys(("rolling_ratio", "held_ratio"), friction + rolling),
            **{f"twisting_{name}_ratio": twisting for name in turned},
            "twisting_ratio": twisting,
        }
        return {name: min(limit, 1.0) or 1.0 for name, limit in limits.items()}

    def closed_forms(self, parameters: PrescribedMotion) -> Mapping[str, float]:
        """Return the torques of turning forth and back at a wall, where the load is constant."""
        return dict(_turning(parameters)) if parameters.partner == "wall" else {}


def _turning(parameters: PrescribedMotion) -> Iterator[tuple[str, float]]:
    """Yield torques over radius and normal force; of hooke and hertz, whose force is known."""
    load = elastic_force(parameters, parameters.overlap)
    if parameters.normal not in ("hooke", "hertz"):
        return
    time, r = parameters.duration, parameters.radius
    sliders = {}
    if parameters.rolling == "sds":
        # of r omega, and its torque of the force times r
        law = parameters.rolling_stiffness or 0.0, parameters.rolling_damping or 0.0
        limit = parameters.rolling_friction or 0.0
        sliders["rolling"] = law, limit, r * parameters.roll_forth, 1.0
    if parameters.twisting != "none":
        law = twisting_spring(parameters, parameters.overlap)
        limit = twisting_limit(parameters, parameters.overlap)
        sliders["twisting"] = law, limit, parameters.twist_forth, r
    for name, ((k, eta), limit, forth, lever) in sliders.items():
        pieces = [(half, 0.5 * time) for half in (0.5 * forth, 0.5 * forth, -0.5 * forth)]
        first, _, back = limited_forces(k, eta, limit * load, pieces)
        yield f"{name}_forth_ratio", first / load / lever
        yield f"{name}_back_ratio", back / load / lever


class PrescribedMotionVerification(ContactVerification):
    """Adds a finding on the lever of torques."""

    def run(self, engine: Engine, study: Study) -> Findings:
        """Add what the lever of the engine makes of a pair that turns as one body."""
        findings = super().run(engine, study)
        rows = levers(self.case, findings.evidence.tried)
        return replace(findings, checks=[*findings.checks, *rows])


CASE = PrescribedMotionCase()
