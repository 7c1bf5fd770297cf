"""The one unknown of some defects: fitted on the first sample that shows it, held by all others.

The step at which a spring changes its sign, or a torque of memory that was never set, cannot be
known beforehand. One number is taken from one sample, so that the others remain a test.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import combinations

import numpy as np

from harness.model.motion import Motion
from harness.model.scene import Scene

Reference = Callable[..., Motion | None]  # with the unknown by its name
Holds = Callable[[Motion], bool]
DETECTION_LIMIT = 1e-9  # [-] of the largest value: smaller differences show no unknown
WINDOWS = 3  # sample intervals with reversals that are fitted, one after the other


def holds_with_setup_torque(reference: Reference, _: Scene, observed: Motion, holds: Holds) -> bool:
    """Return whether a run holds with the setup torque [N m] that its first sample shows."""
    plain = reference()
    if plain is None:
        return False
    torque = tuple((observed.torque[0, 0] - plain.torque[0, 0]).tolist())
    if not all(map(math.isfinite, torque)):
        return False
    fitted = reference(setup_torque=torque)
    return fitted is not None and holds(fitted)


def holds_with_reversals(
    reference: Reference, scene: Scene, observed: Motion, holds: Holds
) -> bool:
    """Return whether a run holds with steps at which torsional springs change their sign.

    Each interval between two samples is fitted on the first sample after it that differs. Where
    that fails, and the motion is prescribed, each body may have a copy of the spring of its own.
    """
    steps: tuple[int, ...] = ()
    current = reference()
    for _ in range(WINDOWS):
        sample = 0 if current is None else first_difference(scene, observed, current)
        if current is None or sample >= len(observed):
            break
        agreed, current = sample, None
        for chosen in _reversals_before(sample, scene):
            trial = reference(torsion_reversed_at=(*steps, *chosen))
            if trial is None:
                continue
            if holds(trial):
                return True
            first = first_difference(scene, observed, trial)
            if first > agreed:
                agreed, current, best = first, trial, chosen
        steps = (*steps, *best) if current is not None else ()
    return bool(scene.segments) and _holds_with_copies(reference, scene, observed, holds)


def _reversals_before(sample: int, scene: Scene) -> Iterator[tuple[int, ...]]:
    """Yield steps before a sample: one, or two where a contact goes to a neighbour and back."""
    window = range(max(1, (sample - 1) * scene.every), sample * scene.every)
    yield from combinations(window, 1)
    yield from combinations(window, 2)


def _holds_with_copies(reference: Reference, scene: Scene, observed: Motion, holds: Holds) -> bool:
    """Return whether each sample of each body is that of one of the copies of a spring.

    Of a contact over a boundary both sides compute one, without newton, and each side turns its
    copy round at a step of its own; where both bodies are on one side again, one copy is left. The
    other copies are fitted on the first sample of a body that is not of the first one.
    """
    plain = reference()
    if plain is None:
        return False
    copies = [plain]
    for body in range(len(scene.bodies)):
        sample = first_difference(scene, observed, plain, body)
        if sample < len(observed):
            runs = (reference(torsion_reversed_at=s) for s in _reversals_before(sample, scene))
            found = [run for run in runs if run is not None]
            copies.append(max(found, key=lambda m: first_difference(scene, observed, m, body)))
    torques = np.stack([copy.torque for copy in copies])  # (copies, samples, bodies, 3)
    errors = np.abs(torques - observed.torque).max(axis=3)
    nearest = errors.argmin(axis=0)[None, :, :, None]
    torque = np.take_along_axis(torques, nearest, axis=0)[0]
    return holds(replace(plain, torque=torque))


FITS: Mapping[str, Callable[[Reference, Scene, Motion, Holds], bool]] = {
    "torsion_reversed_at": holds_with_reversals,
    "setup_torque": holds_with_setup_torque,
}


def first_difference(
    scene: Scene, observed: Motion, reference: Motion, body: int | None = None
) -> int:
    """Return the first sample that differs, of all bodies or one; their number where none does.

    Velocities of a free motion, forces of a prescribed one; angular parts on the scale of the
    largest radius.
    """
    radius = max(body.radius for body in scene.bodies)
    if scene.segments:
        parts = {"force": 1.0, "torque": 1.0 / radius}
    else:
        parts = {"velocity": 1.0, "angular_velocity": radius}
    size = max(k * float(np.abs(getattr(reference, name)).max()) for name, k in parts.items())
    first = len(observed)
    for name, k in parts.items():
        difference = k * np.abs(getattr(observed, name) - getattr(reference, name))
        difference = difference if body is None else difference[:, body]
        largest = np.nan_to_num(difference).reshape(len(difference), -1).max(axis=1)
        seen = np.flatnonzero(largest > DETECTION_LIMIT * (size or 1.0))
        first = min([first, *seen[:1].tolist()])
    return first
