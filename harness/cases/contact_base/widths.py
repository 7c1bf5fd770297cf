"""What differences of two runs of a contact are measured in, and how large rounding makes them."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from harness.cases.contact_base.impact import overlap_of
from harness.cases.contact_base.reference import followed, rules_of
from harness.cases.contact_base.scales import rest_overlap
from harness.cases.contact_base.ways import PLAIN, ROUNDINGS, STEPPED, Way, Ways
from harness.engines.traits import Traits


def sizes_of(one: Ways, traits: Traits) -> dict[str, float]:
    """Return what differences are measured in: overlap, speed of the contact, largest force.

    The overlap is that of the largest force at rest, the speed at least what moves by it in
    the time of a contact; both with the radius as the lever. A force that a code does not tell is
    that of the law.
    """
    motion, law, plain = one.motion(PLAIN), one.trial.parameters, one.ways[PLAIN]
    assert motion is not None
    scene, r, pulled = plain.scene, law.radius, motion.force[:, 0]
    if not motion.tells_forces:
        pulled = followed(scene, rules_of(plain.job, traits)).motion.force[:, 0]
    weight = scene.bodies[0].mass * np.array(scene.gravity)
    force = float(np.linalg.norm(pulled - weight, axis=1).max())
    overlap = rest_overlap(law, force)
    speed = max(
        float(np.linalg.norm(motion.velocity, axis=2).max()),
        r * float(np.linalg.norm(motion.omega, axis=2).max()),
        overlap / (law.steps_per_contact * scene.step),
    )
    return {
        "position": overlap,
        "velocity": speed,
        "omega": speed / r,
        "force": force,
        "torque": force * r,
    }


def of_digits(one: Ways, sizes: Mapping[str, float], traits: Traits, width: float) -> float:
    """Return what the round-off of mdr's force may leave of the sizes, beside that of a way."""
    stepped, plain = one.motion(STEPPED), one.ways[PLAIN]
    if one.trial.parameters.normal != "mdr":
        return 0.0
    if stepped is None:
        return math.inf
    from harness.cases.contact_base.pushes import of_force

    overlaps, _ = overlap_of(one.trial.parameters, stepped)
    rules, slack = rules_of(plain.job, traits), width * sizes["position"]
    return of_force(plain.scene, rules, overlaps, sizes, slack)


def of_way(way: Way, one: Ways, sizes: Mapping[str, float], *, single: bool) -> float:
    """Return the part of the sizes that round-off may change, ``single`` where it is written."""
    motion, scene = one.motion(PLAIN), one.ways[PLAIN].scene
    assert motion is not None
    far = float(np.abs(motion.position).max()) + way.drift * scene.duration + way.reach
    fast = float(np.abs(motion.velocity).max()) + way.drift
    rounded = far / sizes["position"] + fast / sizes["velocity"]
    width = ROUNDINGS * way.scene.steps * float(np.finfo(float).eps) * rounded
    if single:
        room = float(one.ways[PLAIN].job.values["room"])
        shown = room / sizes["position"] + fast / sizes["velocity"]
        width += ROUNDINGS * float(np.finfo(np.float32).eps) * shown
    return width
