"""Quantities of a sampled motion, and the scene of the contact law that reference and codes run."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.model.conventions import Faults, Rules
from harness.model.law import Law
from harness.model.motion import Motion
from harness.model.scene import Body, Scene, Segment, Wall
from harness.parameters.law import ContactLaw
from harness.parameters.scene import ContactScene
from harness.solvers import reference

Array = NDArray[np.float64]
__all__ = ["Motion"]

SLACK = 1e-9
"""Round-off of the roots of a polynomial."""


@lru_cache(maxsize=4096)
def reference_motion(
    scene: Scene, rules: Rules | None = None, faults: Faults | None = None
) -> Motion:
    """Return the motion at equal steps, by conventions and known defects of a code."""
    return reference.run(scene, rules, faults)


def scene_of(scene: ContactScene, parameters: Any) -> Scene:
    """Return a scene of the model, with the law that ``parameters`` of a case state."""
    return Scene(
        bodies=tuple(
            Body(
                radius=body.radius,
                mass=body.mass,
                position=body.position,
                velocity=body.velocity,
                angular_velocity=body.omega,
                motion="frozen" if body.frozen else "free",
            )
            for body in scene.bodies
        ),
        walls=tuple(
            Wall(point=plane.point, direction=plane.direction, velocity=plane.velocity)
            for plane in scene.planes
        ),
        law=law_of(scene.law, parameters.interface, parameters.materials_as),
        gravity=scene.gravity,
        step=scene.step,
        steps=scene.steps,
        every=scene.every,
        segments=tuple(
            Segment(steps=piece.steps, velocities=piece.velocities, angular_velocities=piece.omegas)
            for piece in scene.segments
        ),
    )


def law_of(law: ContactLaw, interface: str = "current", materials: str = "stated") -> Law:
    """Return a law of the model; two ``materials`` that are stated become the one of both."""
    values = {name: getattr(law, name) for name in ContactLaw.model_fields}
    if values.pop("bulk_response"):
        values["bulk_share"] = 1.0
    given = {name: value for name, value in values.items() if value is not None}
    found = Law(**given, interface=interface)
    return found.one_material if found.two_materials and materials == "stated" else found


def crossing(time: Array, value: Array, rate: Array, number: int = 0) -> float:
    """Return when a sampled value crosses zero for the ``number``-th time, NaN if it does not.

    Cubic between the two samples about it, from values and rates, each (M,).
    """
    changes = np.flatnonzero(np.sign(value[:-1]) * np.sign(value[1:]) < 0.0)
    if changes.size <= number:
        return float("nan")
    i = int(changes[number])
    h = float(time[i + 1] - time[i])
    c = _cubic(value[i], value[i + 1], h * rate[i], h * rate[i + 1])
    inside = [r for r in _real(np.roots(c)) if -SLACK <= r <= 1.0 + SLACK]
    return float(time[i]) + h * inside[0] if inside else float("nan")


def value_at(moment: float, time: Array, value: Array, rate: Array) -> float:
    """Return a sampled value [M] at a moment, cubic between the samples about it."""
    i = int(np.clip(np.searchsorted(time, moment) - 1, 0, len(time) - 2))
    h = float(time[i + 1] - time[i])
    c = _cubic(value[i], value[i + 1], h * rate[i], h * rate[i + 1])
    return float(np.polyval(c, (moment - time[i]) / h))


def peak(value: Array) -> float:
    """Return the largest of sampled values (M,), by the quartic through the five about it.

    NaN where a value is.
    """
    if np.isnan(value).any():
        return float("nan")
    i = int(np.clip(np.argmax(value), 2, max(2, len(value) - 3)))
    near = value[i - 2 : i + 3]
    if len(near) < 5:
        return float(value.max())
    quartic = np.polyfit(np.arange(-2.0, 3.0), near, 4)
    places = [r for r in _real(np.roots(np.polyder(quartic))) if abs(r) <= 2.0]
    return max([float(value.max()), *(float(np.polyval(quartic, x)) for x in places)])


def _real(roots: NDArray[Any]) -> list[float]:
    return [float(root.real) for root in roots if abs(root.imag) < SLACK]


def _cubic(start: float, end: float, rate: float, end_rate: float) -> Array:
    """Return the coefficients, highest power first, of Hermite's cubic on 0 to 1."""
    return np.array(
        [
            2.0 * start - 2.0 * end + rate + end_rate,
            -3.0 * start + 3.0 * end - 2.0 * rate - end_rate,
            rate,
            start,
        ]
    )
