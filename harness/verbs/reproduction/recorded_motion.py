"""The recorded MFiX-DEM runs of the incline, as the source checked its own angle."""

from __future__ import annotations

import re
from collections.abc import Mapping
from importlib import resources

import numpy as np

from harness.comparison.exhibits import VelocitySeries
from harness.observables.incline import Trajectory

_NAME = re.compile(r"quartier_k1e6_euler_f(\d+)_th([\d.]+)\.csv")
_LEFT_SPHERE = 0.5
"""[d] The first fixed sphere from the left edge, from which MFiX counts x; d is 1 m."""


def recorded_motions() -> dict[tuple[int, float], Trajectory]:
    """Return the recorded paths by (steps per contact time, angle [deg]), k = 1e6 N/m, d = 1 m."""
    folder = resources.files("harness").joinpath("engines", "mfix", "recorded")
    found = {}
    for entry in sorted(folder.iterdir(), key=lambda entry: entry.name):
        if match := _NAME.fullmatch(entry.name):
            with entry.open(encoding="utf-8") as lines:
                t, x, y, vx, vy, _ = np.loadtxt(lines, delimiter=",", skiprows=1, unpack=True)
            key = int(match[1]), float(match[2])
            found[key] = Trajectory(t, x - _LEFT_SPHERE, y, vx, vy)
    return found


def as_series(motions: Mapping[tuple[int, float], Trajectory]) -> list[VelocitySeries]:
    """Return the recorded paths as velocity series, finest step and smallest angle first."""
    return [
        VelocitySeries(f"MFiX-DEM, {steps} steps", angle, not turns_back(path), path)
        for (steps, angle), path in sorted(motions.items(), key=lambda m: (-m[0][0], m[0][1]))
    ]


def turns_back(path: Trajectory) -> bool:
    """Return whether the grain ever moved uphill along the row.

    Without friction, a grain that turns back in a well has not the energy for the
    crest and stays. The small rebound in a well turns its velocity by less than
    the 60 deg left until it points uphill.
    """
    return bool((path.vx_m_per_s < 0).any())
