"""Unknowns of known defects, fitted on the first sample that shows them; all others must agree."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from itertools import combinations

import numpy as np

from harness.model.motion import Motion
from harness.model.scene import Scene

Holds = Callable[[Motion], bool]
Run = Callable[..., Motion | None]  # of the reference, with the unknown by its name
TOLERANCE = 1e-9  # of the largest value, from which on a sample shows an unknown
MOST_WINDOWS = 3  # between samples with reversals, each fitted on the first sample that it moves


def holds_with_torque(run: Run, _: Scene, theirs: Motion, holds: Holds) -> bool:
    """Fit the torque of the first setup on the first sample; return whether all samples hold."""
    ours = run()
    if ours is None:
        return False
    torque = tuple((theirs.torque[0, 0] - ours.torque[0, 0]).tolist())
    if not all(map(math.isfinite, torque)):
        return False
    fitted = run(setup_torque=torque)
    return fitted is not None and holds(fitted)


def holds_with_reversals(run: Run, scene: Scene, theirs: Motion, holds: Holds) -> bool:
    """Fit steps at which torsional springs change their sign; return whether all samples hold.

    Between two samples there are one or two, as a contact goes to a neighbour and back.
    """
    steps: tuple[int, ...] = ()
    ours = run()
    for _ in range(MOST_WINDOWS):
        if ours is None or (sample := _first_difference(scene, theirs, ours)) >= len(theirs):
            return False
        window = range(max(1, (sample - 1) * scene.every), sample * scene.every)
        agreed, ours = sample, None
        for chosen in (*combinations(window, 1), *combinations(window, 2)):
            trial = run(torsion_reversed_at=(*steps, *chosen))
            if trial is None:
                continue
            if holds(trial):
                return True
            first = _first_difference(scene, theirs, trial)
            if first > agreed:
                agreed, ours, best = first, trial, chosen
        steps = (*steps, *best) if ours is not None else ()
    return False


FITS: Mapping[str, Callable[[Run, Scene, Motion, Holds], bool]] = {
    "torsion_reversed_at": holds_with_reversals,
    "setup_torque": holds_with_torque,
}


def _first_difference(scene: Scene, theirs: Motion, ours: Motion) -> int:
    """Return the first sample that differs, their number where none does."""
    radius = max(body.radius for body in scene.bodies)
    pairs = [("velocity", radius)] if not scene.segments else [("force", 1.0 / radius)]
    first = len(theirs)
    for linear, lever in pairs:
        angular = "angular_velocity" if linear == "velocity" else "torque"
        parts = ((linear, 1.0), (angular, lever))
        size = max(k * float(np.abs(getattr(ours, name)).max()) for name, k in parts) or 1.0
        for name, k in parts:
            off = np.nan_to_num(k * np.abs(getattr(theirs, name) - getattr(ours, name)))
            seen = np.flatnonzero(off.reshape(len(off), -1).max(axis=1) > TOLERANCE * size)
            first = min([first, *seen[:1].tolist()])
    return first
