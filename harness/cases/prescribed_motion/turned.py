"""Two spheres that stick are turned as one body: the spring must turn with the contact."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from harness.cases.contact_base.motion import Array, Motion
from harness.comparison.findings import Findings
from harness.comparison.verdicts import Check, finding
from harness.parameters.contact_scene import ZERO, ContactScene, Segment, Vector

if TYPE_CHECKING:
    from harness.cases.contact_base.contact_case import ContactCase
    from harness.cases.prescribed_motion.case import PrescribedMotion

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


def levers(case: ContactCase[PrescribedMotion], found: Findings) -> Iterator[Check]:
    """Yield what a pair that turns as one body does by the lever of an engine's slip."""
    for one in found.evidence.climbed if found.evidence else ():
        shown = one.finest.turned and one.trial.submodel == SHOWN
        if not shown or one.rules.velocity_lever == "contact_point":
            continue
        rules = one.rules.replace(velocity_lever="contact_point")
        objective = case.expected(one.finest, rules)["turned_ratio"].value
        reached = one.limits["turned_ratio"]
        yield finding(
            f"{case.name}, {one.trial.system}: {SHOWN}, {found.engine}: what turning strains",
            reached.value,
            objective,
            "",
            "expected with levers that reach to the contact: the forces turn with the pair; with "
            f"the lever {one.rules.velocity_lever} a turn by {one.finest.turned:g} rad strains the "
            f"spring by that times the overlap of {1e6 * one.finest.overlap:g} µm",
            reached.uncertainty,
        )
