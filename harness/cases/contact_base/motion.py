"""The motion of the bodies of a contact scene, whoever computed it, and what is read off it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.engines.output import SERIES, Output
from harness.errors import EngineOutputError
from harness.parameters.contact_scene import ContactScene

Array = NDArray[np.float64]

SLACK = 1e-9
"""Round-off of the roots of a polynomial."""

COLUMNS = {
    "position": ("x_m", "y_m", "z_m"),
    "velocity": ("vx_m_per_s", "vy_m_per_s", "vz_m_per_s"),
    "omega": ("wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s"),
    "force": ("fx_N", "fy_N", "fz_N"),
    "torque": ("tx_N_m", "ty_N_m", "tz_N_m"),
}
"""Columns of an engine's samples, each (M, N)."""


FORCES = ("force", "torque")
"""Which a code may not tell: NaN."""


@dataclass(frozen=True)
class Motion:
    """Samples: ``time`` [s] (M,), the rest (M, N, 3) in SI units, N bodies in order."""

    time: Array
    position: Array
    velocity: Array
    omega: Array
    force: Array
    torque: Array

    @property
    def tells_forces(self) -> bool:
        """Return whether the code left forces."""
        return not bool(np.isnan(self.force).all())


def motion_of(output: Output, scene: ContactScene) -> Motion:
    """Return the samples of a run; raise EngineOutputError where some are missing or not finite."""
    left = output.tables.get(SERIES, {})
    told = {p: n for p, n in COLUMNS.items() if p not in FORCES or any(c in left for c in n)}
    table = output.table(["step", *(n for names in told.values() for n in names)])
    shapes = {n: table[n].shape[1:] for names in told.values() for n in names}
    for name, shape in shapes.items():
        if shape != (len(scene.bodies),):
            columns = shape[0] if shape else "no"
            raise EngineOutputError(
                f"{output.who} left {columns} columns of {name} of {len(scene.bodies)} bodies"
            )
    if table["step"][-1] != scene.steps // scene.every * scene.every:
        raise EngineOutputError(f"{output.who} left samples of {table['step'][-1]:g} steps alone")
    parts = {part: np.stack([table[n] for n in names], axis=2) for part, names in told.items()}
    for part in set(FORCES) - set(told):
        parts[part] = np.full_like(parts["position"], np.nan)
    return Motion(time=table["step"] * scene.step, **parts)


def crossing(time: Array, value: Array, rate: Array, number: int = 0) -> float:
    """Return when a sampled value crosses zero for the ``number``-th time, NaN if it does not.

    Cubic between the two samples about it, from values and rates, each (M,).
    """
    found = np.flatnonzero(np.sign(value[:-1]) * np.sign(value[1:]) < 0.0)
    if found.size <= number:
        return float("nan")
    i = int(found[number])
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
    """Return the real ones of roots."""
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
