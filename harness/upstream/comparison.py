"""The motion of a test's scene in the reference, held against that of LAMMPS at the same steps.

A motion that is wrong, and is the reference's with the switches of known defects, is those defects.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np

from harness.errors import RequestError
from harness.model.conventions import Faults, Rules
from harness.model.law import Law
from harness.model.motion import Motion
from harness.model.scene import Scene
from harness.solvers import reference
from harness.upstream.definition import RECORDED, Floats, State
from harness.upstream.scene import Reading

EQUAL_STEPS = 1e-9  # difference at equal steps, over the scale of a quantity: round-off is below
LIMIT_ERROR = 1e-7  # of the limit of small steps, over the largest speed
MOST_STEPS = 3_000_000  # of its finest run
MOST_PAIR_STEPS = 3e8  # of one run of the reference: some seconds
MOST_SWITCHES = 3  # known defects that one motion shows together
SPEEDS = ("v", "r omega_")  # labels of velocities, of centres and rims


def check_neighbour_list(reading: Reading, motion: Motion) -> None:
    """Raise RequestError where bodies may come nearer than the skin before a list is made anew."""
    nearer = 2.0 * reading.scene.step * reading.list_steps * np.abs(motion.velocity).max()
    if len(reading.scene.bodies) > 1 and not nearer <= reading.skin:
        raise RequestError(
            f"neigh_modify: a list of {reading.list_steps} steps and a skin of {reading.skin:g} "
            "may miss contacts"
        )


def reference_motion(reading: Reading, changes: Mapping[str, Any] | None = None) -> Motion:
    """Return the motion of the reference, with switches of known defects and rules by name."""
    scene, switches = reading.scene, dict(changes or {})
    if _pairs(scene) * scene.steps > MOST_PAIR_STEPS:
        raise RequestError(f"{len(scene.bodies)} spheres for {scene.steps} steps: too many here")
    if "tsuji_again_in_setup" in switches:
        scene = _with_tsuji_again(scene, reading.setups)
    own = {name: switches.pop(name) for name in list(switches) if name in Rules.model_fields}
    return reference.run(scene, reading.rules.replace(**own), Faults(**switches))


def difference(
    reading: Reading, motion: Motion, states: Sequence[State], segment: int | None = None
) -> tuple[float, str]:
    """Return the largest relative difference at the ends of segments, and where it is.

    At the end of one segment it is that of velocities alone.
    """
    worst, where = 0.0, ""
    for number, end in enumerate(reading.ends):
        for label, apart in _differences(reading.scene, motion, states[number + 1], end):
            chosen = segment is None or (number == segment and label in SPEEDS)
            if chosen and apart.max() > worst:
                worst = float(apart.max())
                sphere, axis = np.unravel_index(int(apart.argmax()), apart.shape)
                where = f"{label}{'xyz'[axis]} of sphere {sphere + 1} after segment {number}"
    return worst, where


def _differences(
    scene: Scene, motion: Motion, state: State, end: int
) -> Iterator[tuple[str, Floats]]:
    """Yield differences from a state by quantity, (N, 3) over the scale of the quantity."""
    if len(state["id"]) != len(scene.bodies):
        raise RequestError(f"{len(state['id'])} of {len(scene.bodies)} spheres are left at the end")
    at, radii = end // scene.every, np.array([body.radius for body in scene.bodies])[:, None]
    acted = np.array([bool(scene.segments) or b.motion == "free" for b in scene.bodies])[:, None]
    weight = np.array([b.mass if b.motion == "free" else 0.0 for b in scene.bodies])[:, None]
    weight = weight * np.array(scene.gravity)

    def found(*names: str) -> Floats:
        return np.column_stack([state[name] for name in names])

    moved = found("x", "y", "z") - motion.position[at]
    period = np.array([length or np.inf for length in scene.period])
    moved -= np.where(np.isfinite(period), period, 0.0) * np.round(moved / period)
    rims, spin = radii * motion.angular_velocity, radii * found(*RECORDED["run_omega"])
    velocity, force = found("vx", "vy", "vz"), (found("fx", "fy", "fz") - weight) * acted
    torque = found(*RECORDED["run_torque"]) / radii * acted
    speed = max(np.abs(part).max() for part in (velocity, spin, motion.velocity, rims))
    load = max(np.abs(part).max() for part in (force, torque, weight, motion.force * acted))
    yield "", np.abs(moved) / radii.max()
    yield "v", np.abs(velocity - motion.velocity[at]) / (speed or 1.0)
    yield "r omega_", np.abs(spin - rims[at]) / (speed or 1.0)
    yield "f", np.abs(force - motion.force[at] * acted) / (load or 1.0)
    yield "torque/r ", np.abs(torque - motion.torque[at] / radii * acted) / (load or 1.0)


def step_error(reading: Reading, segment: int) -> float:
    """Return the error of the test's step after a segment, over the largest speed of the segment.

    It is the difference from the limit of small steps; NaN where no force moves anything.
    """
    scene, end = reading.scene, reading.ends[segment]
    if not end or scene.segments:
        return math.nan
    radii = np.array([body.radius for body in scene.bodies])[:, None]

    def speeds(steps: int) -> Floats:
        finer = steps // end
        setups = tuple(at * finer for at in scene.setups if at < end)
        finer_scene = scene.replace(
            step=scene.step / finer, steps=steps, every=steps, setups=setups
        )
        motion = reference.run(finer_scene, reading.rules)
        return np.hstack([motion.velocity, radii * motion.angular_velocity])

    own = speeds(end)
    scale = np.abs(own).max()
    if not scale:
        return math.nan
    most = max(4 * end, min(16 * end, int(MOST_STEPS / max(1.0, _pairs(scene)))))
    limits = reference.limit(
        lambda steps: {str(n): value for n, value in enumerate(speeds(steps)[-1].flat)},
        LIMIT_ERROR * scale, first=end, most=most,
    )  # fmt: skip
    values = np.array([limit.value for limit in limits.values()])
    return float(np.abs(own[-1].ravel() - values).max() / scale)


def _pairs(scene: Scene) -> float:
    return len(scene.bodies) * (0.5 * (len(scene.bodies) - 1) + len(scene.walls))


# ---- known defects

CLASSIC = {"tangential_radius": "walls", "cap_without_radius": "walls"}
ALL_CLASSIC = dict.fromkeys(CLASSIC, "all")
SWITCHES: tuple[tuple[str, str, str, str, dict[str, Any]], ...] = (
    ("damping", "tsuji", "all", "tsuji-restitution", {"tsuji_effective_mass": True}),
    ("tangential", "linear_history_classic", "old walls", "old-wall-friction", CLASSIC),
    ("tangential", "linear_history_classic", "all", "linear-history-classic", ALL_CLASSIC),
    ("tangential", "mindlin_classic", "old walls", "old-wall-cap-without-radius",
     {"cap_without_radius": "walls"}),
    ("tangential", "mindlin_classic", "all", "classic-cap-without-radius",
     {"cap_without_radius": "all"}),
    ("twisting", "marshall", "all", "marshall-twist-with-mindlin",
     {"marshall_without_radius": True}),
    ("twisting", "marshall|sds", "all", "twisting-limit-by-rate", {"twisting_limit_by_rate": True}),
    ("normal", "dmt|jkr", "all", "dmt-limit-without-pull-off",
     {"dmt_limit_without_pull_off": True}),
    ("damping", "tsuji", "walls", "wall-tsuji-again", {"tsuji_again_in_setup": True}),
    ("normal", ".*", "walls", "wall-touched-at-no-overlap", {"wall_touches_at_zero": True}),
)  # fmt: skip
# a part of a law, the submodels and contacts that may show it, a known defect, its switches


def known_defects_of(reading: Reading, states: Sequence[State]) -> str:
    """Return the known defects of LAMMPS that together give a motion, by name, or nothing."""
    switches = _switches(reading, states)
    for count in range(1, MOST_SWITCHES + 1):
        for names in combinations(switches, count):
            changes = {key: value for name in names for key, value in switches[name].items()}
            if difference(reading, reference_motion(reading, changes), states)[0] <= EQUAL_STEPS:
                return ", ".join(names)
    return ""


def _switches(reading: Reading, states: Sequence[State]) -> dict[str, dict[str, Any]]:
    """Return switches of the reference by the known defect that a scene may show.

    A torque that was never set is read off the first setup.
    """
    kinds = {wall.type for wall in reading.scene.walls}
    laws = {"all": [row.law for row in reading.scene.laws]}
    laws["walls"] = [row.law for row in reading.scene.laws if kinds & set(row.types)]
    laws["old walls"] = [law for law in laws["walls"] if law.interface == "old"]
    switches = {
        name: changes
        for part, words, contacts, name, changes in SWITCHES
        if any(re.fullmatch(words, getattr(law, part)) for law in laws[contacts])
    }
    for law in laws["walls"]:
        if (nu := law.poisson_ratio) is not None:
            shear = ((2.0 - nu) * (1.0 + nu)) ** 2 / 8.0
            switches["wall-youngs-modulus"] = {"wall_modulus_factor": 1.0 + nu}
            switches["wall-shear-modulus"] = {"wall_shear_factor": shear}
    for law in laws["all"]:
        if law.partner_youngs_modulus is not None:
            switches["mixed-tangential-stiffness"] = {"shear_factor": _mixed_shear_factor(law)}
    if any(law.rolling == "sds" for law in laws["all"]):
        torque = [states[0][name][0] for name in RECORDED["run_torque"]]
        unset = torque - reference_motion(reading).torque[0, 0]
        switches["rolling-uninitialised-in-setup"] = {"setup_torque": tuple(unset)}
    return switches


def _mixed_shear_factor(law: Law) -> float:
    """Return G* over the right one where the mixed modulus, E*, is taken for the E of both."""
    modulus, shear = law.moduli or (1.0, 1.0)
    poisson = math.sqrt((law.poisson_ratio or 0.0) * (law.partner_poisson_ratio or 0.0))
    return modulus / (4.0 * (2.0 - poisson) * (1.0 + poisson)) / shear


def _with_tsuji_again(scene: Scene, times: int) -> Scene:
    """Return a scene in which setups before the first step took alpha(e) of tsuji for e."""
    laws = {}
    for types, law in scene.laws:
        again = law.restitution
        for _ in range(times if law.damping == "tsuji" and again is not None else 0):
            again = reference.tsuji(again or 0.0)
        laws[types] = law.replace(restitution=again)
    return scene.replace(laws=laws)
