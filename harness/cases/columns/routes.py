"""How a grain over columns is judged: by its own energy, motion and height, at the crest ahead.

What the columns hold is not counted: at rest on a crest they hold the same each time, so that the
energy left over it has its root where the grain just comes to rest there, whatever they give back
on the way. That is why a passage goes on to the crest itself.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from harness.cases.columns.parameters import Columns
from harness.cases.columns.rest import allowed, crest_energy, crest_radius
from harness.cases.incline.judge import Judgement, Looks, judge_by
from harness.cases.incline.routes import Number, margin_offset
from harness.observables.trajectory import Trajectory


def crest_place(case: Columns, well: int) -> float:
    """Return the x [m] of the crest after ``well`` wells."""
    tilt = math.radians(case.angle)
    return well * case.diameter - crest_radius(case) * math.sin(tilt)


def margin(case: Columns, well: int, x: Number, y: Number, vx: Number, vy: Number) -> Number:
    """Return the energy [J] above that of a grain at rest on the crest after ``well`` wells."""
    tilt = math.radians(case.angle)
    height = y * math.cos(tilt) - x * math.sin(tilt)
    own = 0.5 * case.mass * (vx * vx + vy * vy) + case.mass * case.gravity * height
    above: Number = own - crest_energy(case) + margin_offset(case, well)
    return above


def judge(case: Columns, route: str, path: Trajectory, touching: ArrayLike) -> Judgement:
    """Return the outcome of a path, judged at its samples as LAMMPS's script judges.

    ``touching`` (rows,) is 1 where the grain is in contact.
    """
    state = (path.x_m, path.y_m, path.vx_m_per_s, path.vy_m_per_s)
    touches = np.asarray(touching)
    looks = Looks(
        lambda well: margin(case, well, *state),
        lambda well: crest_place(case, well),
        lambda row: bool(touches[row]),
        allowed(case),
    )
    return judge_by(looks, case, route, path)
