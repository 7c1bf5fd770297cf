"""Columns at rest under a load, and the grain on them: where all start, and the crest's energy.

The grain presses a top with N along the contact's normal, which stands at an angle beta to the
column; the column bears L = N cos(beta) besides its own weight. Its contacts are the grain's
(0) and those below its particles 1 ... n - 1; compressions c_0 = N/k, c_i = (L + i w)/k with the
weight w = m g cos(theta) of a particle along the column. Overlaps are c (overlap law) or
T c (deformable law, T = tridiag(1/2, 1, 1/2)). All of it is linear in the loads: above the
columns' rest without a grain, the energy is (N delta_0 + L s) / 2, with the overlap and the way
of the top that the load adds (the weights' work and the overlaps they make cancel).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.cases.columns.parameters import Columns
from harness.cases.incline.routes import BEHIND_CREST, STEADY_SPEED, Start


class Loaded(NamedTuple):
    """A grain's contact and the column below: overlap [m], sinking of the top [m], energy [J]."""

    overlap: float
    sunk: float
    energy: float


def weight_along(case: Columns) -> float:
    """Return the weight of a particle along its column [N]."""
    return case.mass * case.gravity * math.cos(math.radians(case.angle))


def loaded(case: Columns, force: float, beta: float) -> Loaded:
    """Return the contact and the column under a ``force`` [N] at ``beta`` [rad] to the column."""
    load, k = force * math.cos(beta), case.stiffness
    added, half = force / k, 0.5 if case.deformable else 0.0
    added += half * load / k
    top = _ways(case) * load / k + half * force / k
    return Loaded(added + half * weight_along(case) / k, top, 0.5 * (force * added + load * top))


def sinking(case: Columns, force: float = 0.0, beta: float = 0.0) -> NDArray[np.float64]:
    """Return how deep the particles of a column at rest lie below touching [m], shape (n,).

    From the top down; under the columns' own weight, and a force on the top.
    """
    load, below = force * math.cos(beta), np.arange(1, case.n)
    press = np.concatenate([[force], load + below * weight_along(case)]) / case.stiffness
    overlap = press.copy()
    if case.deformable:
        overlap[1:] += 0.5 * press[:-1]
        overlap[:-1] += 0.5 * press[1:]
    return np.concatenate([np.cumsum(overlap[:0:-1])[::-1], [0.0]])


def crest_radius(case: Columns) -> float:
    """Return the distance [m] of a grain that rests on a crest from the top below it."""
    return case.diameter - _on_crest(case).overlap


def crest_energy(case: Columns) -> float:
    """Return the energy [J] of a grain at rest on the first crest: its height, no springs."""
    top = float(sinking(case)[0]) + _on_crest(case).sunk
    height = crest_radius(case) - top * math.cos(math.radians(case.angle))
    return case.mass * case.gravity * height


def allowed(case: Columns) -> float:
    """Return the margin [J] up to which a grain that moves back is trapped.

    Its own energy, without what the column holds, is not highest at the crest: the column's way
    s changes there as the load turns, by (ways m g / k) sin(theta) per radian, which makes
    m g (s' cos(theta))^2 / 2 d. Four times this is allowed.
    """
    weight, tilt = case.mass * case.gravity, math.radians(case.angle)
    turn = _ways(case) * weight / case.stiffness * math.sin(tilt) * math.cos(tilt)
    return 2.0 * weight / case.diameter * turn**2


def _ways(case: Columns) -> int:
    """Return the way of a top under a load on it, in load / k."""
    return 2 * case.n - 3 if case.deformable else case.n - 1


def _on_crest(case: Columns) -> Loaded:
    return loaded(case, case.mass * case.gravity, math.radians(case.angle))


def start_of(case: Columns, route: str) -> Start:
    """Return the start of a route, ``passage`` or ``steady``, as that of the incline."""
    if route == "passage":
        return start_behind_crest(case)
    speed = STEADY_SPEED * math.sqrt(case.gravity * case.diameter)
    return Start(
        0.5 * case.diameter,
        math.sqrt(0.75) * case.diameter - float(sinking(case)[0]),
        speed * math.sqrt(0.75),
        0.5 * speed,
    )


def start_load(case: Columns) -> tuple[float, float]:
    """Return the force [N] of the grain on the first top where a passage starts, and its beta."""
    phi = _start_angle(case)
    return (case.mass * case.gravity * (3.0 * math.cos(phi) - 2.0), phi - math.radians(case.angle))


def _start_angle(case: Columns) -> float:
    rate = math.sqrt(2.0 * case.gravity * (1.0 - math.cos(BEHIND_CREST)) / case.diameter)
    return BEHIND_CREST + case.phase * rate * case.step


def start_behind_crest(case: Columns) -> Start:
    """Return the start of a passage: the energy of the crest, contact and column in balance.

    As :func:`harness.cases.incline.routes.start_behind_crest`, the springs' energy being that of
    the contact and the column; the column starts at rest (its speed is of order 1/k).
    """
    weight, tilt, d = case.mass * case.gravity, math.radians(case.angle), case.diameter
    phi, (force, beta) = _start_angle(case), start_load(case)
    here, crest = loaded(case, force, beta), _on_crest(case)
    change = -3.0 * weight * math.sin(phi)  # of the force, with phi
    half = 0.5 if case.deformable else 0.0
    load_change = change * math.cos(beta) - force * math.sin(beta)
    slope = -(change + half * load_change) / case.stiffness
    r = d - here.overlap
    kinetic = weight * (d - crest.overlap - r * math.cos(phi))
    kinetic += weight * (here.sunk - crest.sunk) * math.cos(tilt) + crest.energy - here.energy
    omega = math.sqrt(2.0 * kinetic / case.mass / (r * r + slope * slope))
    return Start(
        r * math.sin(beta),
        r * math.cos(beta) - float(sinking(case)[0]) - here.sunk,
        omega * (r * math.cos(beta) + slope * math.sin(beta)),
        omega * (slope * math.cos(beta) - r * math.sin(beta)),
    )
