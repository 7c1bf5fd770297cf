"""Curves of a cell's page: what the law asks for as a line, what an engine gave as points."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.contact_base.motion import Array, Motion
from harness.cases.contact_base.reference import followed
from harness.parameters.contact_scene import ContactScene, Vector
from harness.report.sections import Line, Plot
from harness.shown import in_words

if TYPE_CHECKING:
    from harness.cases.contact_base.contact_case import ContactCase
    from harness.cases.contact_base.study import Climbed

POINTS = 60
"""Of a curve, at least."""

DRAWN = 1e-10
"""[overlap, speed of the contact] local error of a step, for a line on a page."""

MOST_SAMPLES = 60
"""Of an engine, that are drawn."""


def errors_plot(case: ContactCase[Any], cell: Sequence[Climbed]) -> Plot:
    """Return the error of each quantity over the steps of a contact, in the first system."""
    one = cell[0]
    units = {quantity.name: quantity.unit for quantity in case.quantities}
    lines = []
    for name, reached in one.limits.items():
        expected = one.references.get(name)
        if expected is not None:
            scale = 1.0 if units[name] == "1" else abs(expected.value) or 1.0
            error = np.abs(reached.y - expected.value) / scale
            lines.append(Line(in_words(name, units[name]), 1.0 / reached.h, error))
    return Plot(
        "Error over the step",
        f"{one.trial.system}: distance from what the law asks for, relative for what has a unit.",
        "steps of a contact",
        "error",
        tuple(lines),
        logarithmic=True,
    )


def motion_plot(case: ContactCase[Any], cell: Sequence[Climbed], who: str) -> Plot:
    """Return the motion in the first system: the law integrated, and an engine's samples."""
    one = cell[0]
    parameters, scene = one.finest, case.scene(one.finest)
    law = followed(replace(scene, every=_finer(scene)), one.rules, DRAWN).motion
    x_name, y_name = case.axes(parameters)
    lines = [
        Line(f"{name}, {told}" if name else told, x[::every], y[::every], marked=told == who)
        for told, motion, every in (("the law", law, 1), (who, one.motion, _thinned(one.motion)))
        for name, (x, y) in case.curves(parameters, motion).items()
    ]
    title = f"{y_name.partition(' (')[0]} over {x_name.partition(' (')[0]}"
    return Plot(
        title[:1].upper() + title[1:],
        f"{one.trial.system}: the law integrated, and samples of the run with the finest step.",
        x_name,
        y_name,
        tuple(lines),
    )


def _thinned(motion: Motion) -> int:
    """Return how many samples of a motion stand for one that is drawn."""
    return max(1, len(motion.time) // MOST_SAMPLES)


def _finer(scene: ContactScene) -> int:
    """Return a sampling that divides the one of a scene and leaves enough points."""
    wanted = max(1, scene.steps // POINTS)
    return next(n for n in range(min(wanted, scene.every), 0, -1) if scene.every % n == 0)


def scanned(
    case: ContactCase[Any],
    one: Climbed,
    name: str,
    values: Sequence[float],
    sent: Callable[[Any], tuple[Vector, Vector]],
) -> Mapping[str, Array]:
    """Return the quantities of an impact that the law asks for, over values of a parameter.

    ``sent`` tells velocity [m/s] and angular velocity [rad/s] of the sphere from the parameters.
    A run lasts twice as long as that of the trial: a slower impact is over by then.
    """
    base = case.scene(one.finest)
    rows = []
    for value in values:
        changed = one.finest.replace(**{name: float(value)})
        velocity, omega = sent(changed)
        first = replace(base.bodies[0], velocity=velocity, omega=omega)
        steps = 2 * base.steps
        scene = replace(base, bodies=(first, *base.bodies[1:]), steps=steps, every=steps)
        rows.append(case.observed(changed, followed(scene, one.rules, DRAWN).motion))
    return {quantity: np.array([row[quantity] for row in rows]) for quantity in rows[0]}
