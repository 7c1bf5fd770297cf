"""Curves of a cell's page: what the law asks for as a line, what an engine gave as points."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.contact_base.evidence import Climbed, Tried
from harness.cases.contact_base.impact import relative_velocity
from harness.cases.contact_base.motion import Array, Motion
from harness.cases.contact_base.published import published
from harness.cases.contact_base.reference import followed
from harness.parameters.contact_scene import ZERO, ContactScene, Vector
from harness.report.sections import Line, Plot
from harness.shown import in_words

if TYPE_CHECKING:
    from harness.cases.contact_base.contact_case import ContactCase

POINTS = 60
"""Of a curve, at least."""

DRAWN = 1e-10
"""[overlap, speed of the contact] local error of a step, for a line on a page."""

MOST_SAMPLES = 60
"""Of an engine, that are drawn."""

ANGLES = np.array([*range(5, 61, 5), 70.0, 80.0, 85.0])
"""[deg] of the velocity at the contact to the normal. Closer where a law takes turns between
sticking and sliding."""


def errors_plot(case: ContactCase[Any], one: Climbed) -> Plot:
    """Return the error of each quantity over the steps of a contact."""
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
        "Distance from what the law asks for, relative for what has a unit.",
        "steps of a contact",
        "error",
        tuple(lines),
        logarithmic=True,
        group=one.trial.system,
    )


def motion_plot(case: ContactCase[Any], one: Tried, who: str) -> Plot:
    """Return the motion of a trial: the law integrated, and an engine's samples if it left some."""
    parameters, scene = one.finest, case.scene(one.finest)
    every = _finer(scene)
    if every == scene.every:  # as it was integrated when it was judged
        law = followed(scene, one.rules).motion
    else:
        law = followed(replace(scene, every=every), one.rules, DRAWN).motion
    x_name, y_name = case.axes(parameters)
    drawn = [("the law", law, 1)]
    if isinstance(one, Climbed):
        drawn.append((who, one.motion, _thinned(one.motion)))
    lines = [
        Line(f"{name}, {by}" if name else by, x[::every], y[::every], marked=by == who)
        for by, motion, every in drawn
        for name, (x, y) in case.curves(parameters, motion).items()
    ]
    # a code that tells no forces has no points in a figure of forces
    sampled = any(line.marked and np.isfinite(line.y).any() for line in lines)
    samples = "; samples of the run with the finest step" if sampled else f"; no points of {who}"
    title = f"{y_name.partition(' (')[0]} over {x_name.partition(' (')[0]}"
    return Plot(
        title[:1].upper() + title[1:],
        f"The law integrated{samples}.",
        x_name,
        y_name,
        tuple(lines),
        group=one.trial.system,
    )


def _thinned(motion: Motion) -> int:
    """Return how many samples of a motion stand for one that is drawn."""
    return max(1, len(motion.time) // MOST_SAMPLES)


def _finer(scene: ContactScene) -> int:
    """Return a sampling that leaves enough points, if it can be one that divides the scene's."""
    wanted = max(1, scene.steps // POINTS)
    if scene.every <= wanted:
        return scene.every
    divides = next(n for n in range(wanted, 0, -1) if scene.every % n == 0)
    return divides if 4 * divides >= wanted else wanted


@dataclass(frozen=True)
class OverAngle:
    """A ratio over the angle of the velocity at the contact to the normal.

    ``quantity`` is that ratio and ``parameter`` what sets the angle; ``value`` gives the parameter
    of an angle [deg], ``angle`` the angle of a run, ``sent`` velocity [m/s] and angular velocity
    [rad/s] of the sphere, and ``ratio`` the quantity for what is left of the velocity at the
    contact: the literature's curve.
    """

    quantity: str
    parameter: str
    title: str
    y: str
    value: Callable[[Any, float], float]
    angle: Callable[[Any], float]
    sent: Callable[[Any], tuple[Vector, Vector]]
    ratio: Callable[[Any, Array], Array]


def ratio_plot(case: ContactCase[Any], one: Tried, who: str, over: OverAngle) -> Plot:
    """Return a ratio over the angle: the law, the literature's curve, and an engine's limit."""
    parameters = one.finest
    values = [over.value(parameters, float(angle)) for angle in ANGLES]
    found = scanned(case, one, over.parameter, values, over.sent)
    lines, told = [Line("the law", ANGLES, found[over.quantity])], "The law integrated"
    known = published(parameters, _restitution(case, one))
    if known is not None:
        lines.append(Line(known.name, known.angles, over.ratio(parameters, known.left)))
        told += f"; {known.told}"
    if isinstance(one, Climbed):
        reached = one.limits[over.quantity].value
        lines.append(Line(who, [over.angle(parameters)], [reached], marked=True))
        told += f"; {who} in the limit of a small step"
    else:
        told += f"; {who} has no point here"
    return Plot(
        over.title,
        f"{told}.",
        "angle to the normal (deg)",
        over.y,
        tuple(lines),
        group=one.trial.system,
    )


def _restitution(case: ContactCase[Any], one: Tried) -> float:
    """Return the restitution at the normal velocity of a trial, without friction to act.

    Of an oblique impact the normal turns, and what comes back along the first is not all of it.
    """
    base = case.scene(one.finest)
    before = base.bodies[0].velocity[2]
    bodies = tuple(replace(body, omega=ZERO) for body in base.bodies)
    bodies = (replace(bodies[0], velocity=(0.0, 0.0, before)), *bodies[1:])
    motion = followed(replace(base, bodies=bodies, every=base.steps), one.rules, DRAWN).motion
    return float(relative_velocity(motion)[-1, 2]) / -before


def scanned(
    case: ContactCase[Any],
    one: Tried,
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
