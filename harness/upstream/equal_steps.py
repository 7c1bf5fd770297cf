"""A test at equal steps: its errors over the reference, and the known defects that explain them."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np
from scipy.optimize import root

from harness.engines.output import release_of
from harness.errors import RequestError
from harness.model.scene import Floats, Motion, Scene
from harness.results.defects import KnownDefect, Trial
from harness.solvers import reference
from harness.store.committed import known_defects
from harness.upstream.scene import RECORDED, Reading, State

EQUAL_STEPS = 1e-9  # difference at equal steps, over the scale of a quantity: round-off is below
MOST_PAIR_STEPS = 3e8  # of one run of the reference: some seconds
NUDGE = 1e-13  # of place and radius: some hundred units of rounding
MOST_SWITCHES = 3  # known defects that one motion shows together

SPEEDS = ("v", "r omega_")  # errors of centres and rims
Errors = Mapping[str, Floats]  # over their scale by name, (segments, N, 3) or a part of it


def reference_motion(reading: Reading) -> Motion:
    """Return the motion of the reference.

    Raise RequestError for a scene that is too large, and where bodies may come nearer than the
    skin before a neighbour list is made anew.
    """
    scene, number = reading.scene, len(reading.scene.bodies)
    if number * (0.5 * (number - 1) + len(scene.walls)) * scene.steps > MOST_PAIR_STEPS:
        raise RequestError(f"{number} spheres for {scene.steps} steps: too many here")
    speed = np.linalg.norm(reading.motion.velocity, axis=-1).max()
    nearer = 2.0 * scene.step * reading.list_steps * speed
    if number > 1 and not nearer <= reading.skin:
        raise RequestError(
            f"neigh_modify: a list of {reading.list_steps} steps and a skin of {reading.skin:g} "
            "may miss contacts"
        )
    return reading.motion


def uncertainty(reading: Reading, errors: Errors, states: Sequence[State]) -> float:
    """Return by how much the errors change where the start is off by round-off, over their scales.

    Bounces of little damping pass it on a thousandfold each.
    """
    bodies = tuple(
        body.replace(position=tuple(x + n * NUDGE * (abs(x) + body.radius) for x in body.position))
        for n, body in enumerate(reading.scene.bodies, 1)
    )
    nudged = reference.run(reading.scene.model_copy(update={"bodies": bodies}), reading.rules)
    return largest(
        *(e - errors[name] for name, e in scaled_errors(reading, nudged, states).items())
    )


def is_behind_a_plane(reading: Reading) -> bool:
    """Return whether a sphere ever is behind a plane: LAMMPS's push to both sides."""
    place = reading.motion.position
    return any(
        np.any((place[:, list(wall.bodies or ())] - wall.point) @ wall.direction <= 0.0)
        for wall in reading.scene.walls
    )


def scaled_errors(reading: Reading, motion: Motion, states: Sequence[State]) -> Errors:
    """Return the errors at the ends of segments over their scales.

    The scale is the radius, or the largest speed of centre or rim, or force, of the whole run.
    Raise RequestError where spheres came or went.
    """
    scene, expected = reading.scene, reading.motion
    at = [end // scene.every for end in reading.ends]
    if any(len(state["id"]) != len(scene.bodies) for state in states):
        number = len(states[-1]["id"])
        raise RequestError(f"{number} of {len(scene.bodies)} spheres are left at the end")
    radii = np.array([body.radius for body in scene.bodies])[:, None]
    acted = np.array([bool(scene.segments) or b.motion == "free" for b in scene.bodies])[:, None]
    mass = np.array([b.mass if b.motion == "free" else 0.0 for b in scene.bodies])[:, None]
    weight, rims = mass * np.array(scene.gravity), radii * motion.angular_velocity[at]
    x, v, torque, spin = (_columns(states[1:], names) for names in RECORDED.values())
    force, period = _columns(states[1:], ("fx", "fy", "fz")), np.array(scene.period, float)
    moved = x - motion.position[at]
    moved -= np.nan_to_num(period * np.round(moved / period))
    fall = scene.step * np.array(scene.gravity)  # in a step: what lies at rest has noise alone
    rim_speed = radii * expected.angular_velocity
    speed = largest(v, radii * spin, expected.velocity, rim_speed, fall) or 1.0
    loads = [(force - weight) * acted, torque / radii * acted, weight, expected.force * acted]
    load = largest(*loads) or 1.0
    return {
        "": moved / radii.max(),
        "v": (v - motion.velocity[at]) / speed,
        "r omega_": (radii * spin - rims) / speed,
        "f": (force - weight - motion.force[at]) * acted / load,
        "torque/r ": (torque - motion.torque[at]) / radii * acted / load,
    }


def largest(*values: Floats) -> float:
    """Return the largest size of any value."""
    return float(np.max([np.abs(value).max() for value in values]))  # NaN where one has NaN


def place_of(errors: Errors) -> str:
    """Return quantity, sphere and segment of the largest error."""
    name = max(errors, key=lambda name: largest(errors[name]))
    sizes = np.abs(errors[name])
    segment, sphere, axis = np.unravel_index(int(sizes.argmax()), sizes.shape)
    return f"{name}{'xyz'[axis]} of sphere {sphere + 1} after segment {segment}"


def _columns(states: Sequence[State], names: Sequence[str]) -> Floats:
    """Return vectors of all spheres at the ends of segments, (segments, N, 3)."""
    return np.stack([np.column_stack([state[name] for name in names]) for state in states])


# ---- known defects

SHOWN_BY: Mapping[str, tuple[str, str, str]] = {
    "tsuji-restitution": ("damping", "tsuji", "all"),
    "old-wall-friction": ("tangential", "linear_history_classic", "old walls"),
    "linear-history-classic": ("tangential", "linear_history_classic", "all"),
    "old-wall-cap-without-radius": ("tangential", "mindlin_classic", "old walls"),
    "classic-cap-without-radius": ("tangential", "mindlin_classic", "all"),
    "marshall-twist-with-mindlin": ("twisting", "marshall", "all"),
    "twisting-limit-by-rate": ("twisting", "marshall|sds", "all"),
    "dmt-limit-without-pull-off": ("normal", "dmt|jkr", "all"),
    "wall-tsuji-again": ("damping", "tsuji", "walls"),
    "wall-touched-at-no-overlap": ("normal", ".*", "walls"),
    "wall-youngs-modulus": ("normal", "hertz|dmt|jkr", "walls"),
    "wall-shear-modulus": ("tangential", "mindlin.*", "walls"),
    "mixed-tangential-stiffness": ("tangential", "mindlin.*", "all"),
    "rolling-uninitialised-in-setup": ("rolling", "sds", "all"),
}  # by known defect: the part of a law, the submodels, and the contacts that can show it


def known_defects_of(reading: Reading, states: Sequence[State], release: str = "") -> str:
    """Return the known defects of a release that together give a motion, by name, or nothing.

    Of a release without a date they are those of all.
    """

    def holds(motions: Mapping[Scene, Motion]) -> bool:
        (motion,) = motions.values()
        errors = scaled_errors(reading, motion, states)
        return largest(*errors.values()) <= EQUAL_STEPS

    trial = Trial({reading.scene: reading.rules}, holds)
    is_dated = bool(release_of(release))
    candidates = [d for d in _candidates(reading.scene) if not is_dated or d.has_release(release)]
    for number in range(1, MOST_SWITCHES + 1):
        for group in combinations(candidates, number):
            unknowns: dict[str, Any] = {
                defect.fit: _unset_torque(reading, states) for defect in group if defect.fit
            }
            if unknowns and any(reading.scene.setups) and not trial.holds_with(group, **unknowns):
                run = partial(trial.motion_with, group, **unknowns)
                unknowns["later_setup_torque"] = _later_torque(reading, states, run)
            if trial.holds_with(group, **unknowns):
                return ", ".join(defect.name for defect in group)
    return ""


def _candidates(scene: Scene) -> list[KnownDefect]:
    """Return the known defects that a scene may show."""
    kinds = {wall.type for wall in scene.walls}
    laws = {"all": [row.law for row in scene.laws]}
    laws["walls"] = [row.law for row in scene.laws if kinds & set(row.types)]
    laws["old walls"] = [law for law in laws["walls"] if law.interface == "old"]
    defects = {defect.name: defect for defect in known_defects()}
    return [
        defects[name]
        for name, (part, submodels, contacts) in SHOWN_BY.items()
        if any(re.fullmatch(submodels, getattr(law, part)) for law in laws[contacts])
    ]


def _unset_torque(reading: Reading, states: Sequence[State]) -> tuple[float, ...]:
    """Return the torque of the first setup beyond the reference's: it was never set."""
    torque = _columns(states[:1], RECORDED["run_torque"])[0, 0]
    return tuple(torque - reading.motion.torque[0, 0])


def _later_torque(
    reading: Reading, states: Sequence[State], motion_with: Callable[..., Motion | None]
) -> tuple[float, ...]:
    """Return the torque of later setups: that of the first spin which differs at a segment's end.

    No dump shows it. Place, velocity, force and torque there must agree as well.
    """
    scene = reading.scene
    unit = float(np.abs(reading.motion.force[:, 0]).max()) * scene.bodies[0].radius
    spins = _columns(states[1:], RECORDED["run_omega"])[:, 0]
    size = float(np.abs(spins).max())

    def errors(torque: Floats) -> Floats:
        """Return the errors of the spins at the ends of segments, (segments, 3)."""
        motion = motion_with(later_setup_torque=tuple((unit * torque).tolist()))
        if motion is None:
            return np.full(spins.shape, np.inf)
        at = [end // scene.every for end in reading.ends]
        return (motion.angular_velocity[at, 0] - spins) / size

    wrong = np.flatnonzero(np.abs(errors(np.zeros(3))).max(axis=1) > EQUAL_STEPS)
    if not size or not unit or not wrong.size:
        return (0.0, 0.0, 0.0)

    def first_error(torque: Floats) -> Floats:
        return np.asarray(errors(torque)[wrong[0]])

    solution = root(first_error, np.zeros(3), tol=1e-14)
    return tuple((unit * solution.x).tolist())
