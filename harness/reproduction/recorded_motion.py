"""The recorded MFiX-DEM runs of the incline, as the source checked its own angle."""

from __future__ import annotations

from collections.abc import Mapping

from harness.engines.mfix.recorded import PATHS, recorded_path
from harness.observables.trajectory import Trajectory
from harness.reproduction.figure_data import VelocitySeries


def recorded_motions() -> dict[tuple[int, float], Trajectory]:
    """Return the recorded paths by (steps per contact time of MFiX, angle [deg]), k = 1e6 N/m."""
    return {path: recorded_path(*path).trajectory for path in PATHS}


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
