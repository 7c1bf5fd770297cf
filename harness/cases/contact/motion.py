"""The motion of a contact scene: from an engine's output, or from the integration of the law.

A scene becomes a job, whose values have the same names in every case; the output becomes a
:class:`Motion`, and so does the independent integration that limits are held against.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from operator import mul
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.cases.contact.parameters import Materials, one_material
from harness.engines.contract import Job, Template, Value
from harness.engines.output import SERIES, Output
from harness.engines.traits import Traits, stating
from harness.errors import EngineOutputError, RequestError
from harness.parameters.law import ContactLaw
from harness.parameters.rules import Rules
from harness.parameters.scene import ZERO, Body, ContactScene, Plane, Segment, Vector
from harness.parameters.submodels import PARTNER
from harness.solvers.pair.integration import ContactPath, Event, integrate
from harness.solvers.pair.system import same_system

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


TEMPERATURE = "temperature_K"

FORCES = ("force", "torque")
"""Which a code may not tell: NaN."""


@dataclass(frozen=True)
class Motion:
    """Samples: ``time`` [s] (M,), the rest (M, N, 3) in SI units, N bodies in order.

    ``temperature`` [K] (M, N), of a run that leaves it.
    """

    time: Array
    position: Array
    velocity: Array
    omega: Array
    force: Array
    torque: Array
    temperature: Array | None = None

    @property
    def tells_forces(self) -> bool:
        """Return whether the code left forces."""
        return not bool(np.isnan(self.force).all())


def motion_of(output: Output, scene: ContactScene) -> Motion:
    """Return the samples of a run; raise EngineOutputError where some are missing or not finite."""
    samples = output.tables.get(SERIES, {})
    columns_of = {
        p: n for p, n in COLUMNS.items() if p not in FORCES or any(c in samples for c in n)
    }
    table = output.table(["step", *(n for names in columns_of.values() for n in names)])
    shapes = {n: table[n].shape[1:] for names in columns_of.values() for n in names}
    for name, shape in shapes.items():
        if shape != (len(scene.bodies),):
            columns = shape[0] if shape else "no"
            raise EngineOutputError(
                f"{output.who} left {columns} columns of {name} of {len(scene.bodies)} bodies"
            )
    if table["step"][-1] != scene.steps // scene.every * scene.every:
        raise EngineOutputError(f"{output.who} left samples of {table['step'][-1]:g} steps alone")
    parts = {
        part: np.stack([table[n] for n in names], axis=2) for part, names in columns_of.items()
    }
    for part in set(FORCES) - set(columns_of):
        parts[part] = np.full_like(parts["position"], np.nan)
    return Motion(table["step"] * scene.step, temperature=table.get(TEMPERATURE), **parts)


def crossing(time: Array, value: Array, rate: Array, number: int = 0) -> float:
    """Return when a sampled value crosses zero for the ``number``-th time, NaN if it does not.

    Cubic between the two samples about it, from values and rates, each (M,).
    """
    changes = np.flatnonzero(np.sign(value[:-1]) * np.sign(value[1:]) < 0.0)
    if changes.size <= number:
        return float("nan")
    i = int(changes[number])
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


SAME = 1e-6
"""Relative difference of durations that makes none for the phase of a step."""

LONGEST = 64
"""Guesses of a contact's duration that are tried: a strong dashpot draws it out."""


@dataclass(frozen=True)
class Interval:
    """The time between two switches of a contact: from one on, how long [s], and what it is worth.

    ``change`` is how far the accelerations by the contacts differ in it from those after it at
    most, (bodies, 6) [m/s2, rad/s2].
    """

    begin: float
    duration: float
    change: Array


@dataclass(frozen=True)
class Followed:
    """The motion of a scene, and whether friction began or ceased to slide in it.

    ``jumps``: with a jump of the force, as the dashpot is off while it slides. ``ended``: when the
    contact last ended [s], NaN if it did not. ``intervals`` lie between its switches.
    """

    motion: Motion
    kinked: bool
    jumps: bool
    ended: float
    intervals: tuple[Interval, ...] = ()


def rules_of(job: Job, traits: Traits) -> Rules:
    """Return the rules of the model by which an engine states the contact of a job."""
    return Rules(**stating(traits.contact_models, job.values)[0].rules)


def powers_of(job: Job, traits: Traits) -> tuple[float, ...]:
    """Return the powers of the step in the errors that an engine adds to those of the law."""
    springs = ("tangential", "rolling", "twisting")
    if all(job.values[part] in ("none", "linear_nohistory") for part in springs):
        return ()
    return stating(traits.contact_models, job.values)[0].turning


@lru_cache(maxsize=2048)
def asked_for(scene: ContactScene, rules: Rules) -> Rules:
    """Return rules without those that change nothing in a scene."""
    for name in rules.model_dump(exclude_defaults=True):
        without = rules.model_copy(update={name: Rules.model_fields[name].default})
        rules = without if same_system(scene, without, rules) else rules
    return rules


def followed(scene: ContactScene, rules: Rules) -> Followed:
    """Return the motion that the law asks for under a code's rules."""
    return _followed(scene, asked_for(scene, rules))


@lru_cache(maxsize=2048)
def _followed(scene: ContactScene, rules: Rules) -> Followed:
    path = integrate(scene, rules)
    motion = Motion(
        path.times, path.positions, path.velocities, path.omegas, path.forces, path.torques
    )
    law = scene.law
    dashpot = law.tangential_spring and law.tangential_damping and law.damping != "none"
    dashpot = dashpot or law.rolling_damping or law.twisting_damping
    off = rules.damping_in_cap in ("sticking_only", "until_sliding")
    jumps = off and dashpot and path.of_kind("slides", "sticks")
    kinked = path.of_kind("slides", "sticks", "clips", "repels")
    ends = [event.time for event in path.of_kind("ends")]
    ended = ends[-1] if ends else math.nan
    return Followed(motion, bool(kinked), bool(jumps), ended, _intervals(path))


def _intervals(path: ContactPath) -> tuple[Interval, ...]:
    """Return the times between switches of one contact, in order of their ends."""
    latest: dict[tuple[int, int], Event] = {}
    intervals = []
    for event in path.of_kind("begins", "slides", "sticks", "clips", "repels"):
        first = latest.get(event.contact)
        if first is not None and event.time > first.time:
            change = np.maximum(abs(first.after - event.after), abs(event.before - event.after))
            intervals.append(Interval(first.time, event.time - first.time, change))
        latest[event.contact] = event
    return tuple(intervals)


def jumps_at_the_end(scene: ContactScene, rules: Rules) -> bool:
    """Return whether a dashpot is cut off at another phase of a step on every level.

    The steps are parts of the contact's duration under the default rules: where others change
    it, the contact no longer ends at the same phase. Nor does one whose steps are parts of the
    time up to yield, or that a code draws out by steps that the bulk's response is behind; there
    a dashpot is cut off, or falls to 0 as the fourth root of what is left of the overlap.
    """
    if scene.law.lags and scene.law.damping != "none" and not scene.law.clipped:
        return math.isfinite(followed(scene, rules).ended)
    ended, plain = followed(scene, rules).ended, followed(scene, Rules()).ended
    dashpot = scene.law.damping != "none" and not scene.law.clipped
    return dashpot and math.isfinite(ended) and not math.isclose(ended, plain, rel_tol=SAME)


@lru_cache(maxsize=2048)
def yield_time(scene: ContactScene) -> float:
    """Return after which time of its first contact a sphere yields [s]; inf if it does not."""
    path = integrate(scene, Rules())
    begun = [event.time for event in path.of_kind("begins")]
    return next((event.time - begun[0] for event in path.of_kind("yields")), math.inf)


@lru_cache(maxsize=2048)
def contact_time(scene: ContactScene) -> float:
    """Return how long the first contact of a scene lasts [s]; its one step is a first guess.

    Raise RequestError for a contact that does not end.
    """
    longer = 1
    while longer <= LONGEST:
        path = integrate(replace(scene, step=scene.step * longer), Rules())
        lasted = path.contact_times()
        if lasted:
            return lasted[0]
        longer *= 4
    strong = ("damping_coefficient", "restitution", "surface_energy")
    values = [(name, getattr(scene.law, name)) for name in strong]
    named = ", ".join(f"{name} = {value!r}" for name, value in values if value is not None)
    raise RequestError(
        f"{named}: the contact does not end; less damping or attraction, or a faster impact, end it"
    )


COMPONENTS = ("x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz")
MOST_SEGMENTS = 6
AXES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
UP = AXES[2]
MOVED = ("vx", "vy", "vz", "wx", "wy", "wz")
"""Of the body that is moved, in each segment of a prescribed motion."""
OF_MDR = ("yield_stress", "bulk_response")
"""Parts of a law that are written only where the law has them."""


def values_of(
    scene: ContactScene, interface: str = "current", materials: Materials = "stated"
) -> dict[str, Value]:
    """Return the values of a script for a scene with one or two spheres and parallel planes.

    Two ``materials`` are stated as the one that stands for both, or both are given, to be mixed.
    Raise RequestError for one with more, or with other planes.
    """
    if len(scene.bodies) > 2:
        raise RequestError(f"bodies: scripts take one or two, got {len(scene.bodies)}")
    values: dict[str, Value] = {
        "interface": interface,
        **_law(scene.law, materials),
        **dict(_planes(scene.planes)),
        **dict(zip(("gravity_x", "gravity_y", "gravity_z"), scene.gravity, strict=True)),
        "room": _room(scene),
        "step_size": scene.step,
        "steps": scene.steps,
        "series_every": scene.every,
    }
    for number, body in enumerate(scene.bodies, 1):
        values |= _body(number, body, moved=bool(scene.segments))
    return {**values, **dict(_segments(scene))} if scene.segments else values


def job_of(scene: ContactScene, interface: str, materials: Materials = "stated") -> Job:
    """Return the job of a scene, which writes its samples."""
    where = "plane" if len(scene.bodies) == 1 else "pair"
    variant = f"prescribed-{where}" if scene.segments else where
    return Job(TEMPLATE, values_of(scene, interface, materials), variant, sampled=True)


def _law(law: ContactLaw, materials: Materials) -> dict[str, Value]:
    apart = (*OF_MDR, *PARTNER)
    values = {name: getattr(law, name) for name in ContactLaw.model_fields if name not in apart}
    numbers: dict[str, Value] = {n: 0.0 if v is None else v for n, v in values.items()}
    if law.yield_stress is not None:
        numbers["yield_stress"] = law.yield_stress
    if law.bulk_response:
        numbers["bulk_response"] = "yes"
    if law.two_materials and law.materials:
        if materials == "stated":
            numbers |= zip(("youngs_modulus", "poisson_ratio"), one_material(law), strict=True)
        else:
            numbers |= zip(PARTNER, law.materials[1], strict=True)
    return {**numbers, "clipped": "yes" if law.clipped else "no"}


def _planes(planes: Sequence[Plane]) -> Iterator[tuple[str, Value]]:
    """Yield the heights of a floor and a ceiling, and what they are where not horizontal, at rest.

    Heights are along the floor's normal. Raise RequestError for other planes.
    """
    up, drift = (planes[0].direction, planes[0].velocity) if planes else (UP, ZERO)
    down = tuple(-part for part in up)
    if [plane.direction for plane in planes] not in ([], [up], [up, down]) or any(
        plane.velocity != drift for plane in planes
    ):
        raise RequestError("planes: scripts take none, a floor, or a floor and a ceiling")
    heights = [sum(map(mul, up, plane.point)) for plane in planes]
    yield "planes", len(planes)
    yield from zip(("floor", "ceiling"), [*heights, 0.0, 0.0], strict=False)
    if up != UP or drift != ZERO:
        coordinate = {AXES[0]: "xplane", AXES[1]: "yplane", UP: "zplane"}
        yield "walls_as", "region" if drift != ZERO else coordinate.get(up, "region")
        yield from zip(("up_x", "up_y", "up_z"), up, strict=True)
        yield from zip(("drift_x", "drift_y", "drift_z"), drift, strict=True)


def _body(number: int, body: Body, *, moved: bool) -> dict[str, Value]:
    motion = "frozen" if body.frozen else "prescribed" if moved else "free"
    where = (*body.position, *body.velocity, *body.omega)
    return {
        f"motion_{number}": motion,
        f"radius_{number}": body.radius,
        f"mass_{number}": body.mass,
        **{f"{name}_{number}": v for name, v in zip(COMPONENTS, where, strict=True)},
    }


def _room(scene: ContactScene) -> float:
    """Return half the width of a box that no body leaves [m]."""
    time, g = scene.duration, math.hypot(*scene.gravity)
    reach = max(math.hypot(*b.position) + time * math.hypot(*b.velocity) for b in scene.bodies)
    radii = sum(body.radius for body in scene.bodies)
    return 4.0 * (reach + radii + 0.5 * g * time * time)


def _segments(scene: ContactScene) -> Iterator[tuple[str, Value]]:
    """Yield the pieces of a prescribed motion of one body; those left over are empty.

    The velocities of the other are those that it begins with.
    """
    if len(scene.segments) > MOST_SEGMENTS:
        raise RequestError(f"segments: scripts take up to {MOST_SEGMENTS}")
    begun = [(body.velocity, body.omega) for body in scene.bodies]
    movers = {
        index
        for piece in scene.segments
        for index, velocities in enumerate(zip(piece.velocities, piece.omegas, strict=True))
        if velocities != begun[index]
    }
    if len(movers) > 1:
        raise RequestError("segments: scripts move one body, the others keep their velocities")
    mover = max(movers, default=0)
    if mover:
        yield "mover", mover + 1
    for number in range(1, MOST_SEGMENTS + 1):
        piece = scene.segments[number - 1] if number <= len(scene.segments) else None
        moved = (*piece.velocities[mover], *piece.omegas[mover]) if piece else (0.0,) * len(MOVED)
        yield f"steps_in_{number}", piece.steps if piece else 0
        yield from ((f"{name}_in_{number}", v) for name, v in zip(MOVED, moved, strict=True))


def default_values(bodies: int, segments: int = 0) -> dict[str, Value]:
    """Return the values of the scripts as they stand: an oblique impact of 1 m/s at 45 degrees."""
    law = ContactLaw(
        damping="velocity", damping_coefficient=10.0, tangential="linear_history", friction=0.3
    )
    r, m, v = 0.01, 0.01, math.sqrt(0.5)
    first = Body(r, m, (0.0, 0.0, r), (v, 0.0, -v))
    second = Body(r, m, (0.0, 0.0, -r))
    still = Segment(4000, ((v, 0.0, -v), ZERO)[:bodies], (ZERO, ZERO)[:bodies])
    scene = ContactScene(
        (first, second)[:bodies],
        (Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),) if bodies == 1 else (),
        law,
        step=1e-7,
        steps=4000,
        every=40,
        segments=(still,) * segments,
    )
    return {
        **values_of(scene),
        "bodies": bodies,
        **({"segments": MOST_SEGMENTS} if segments else {}),
    }


NEUTRAL: dict[str, Value] = {
    **dict(zip(("up_x", "up_y", "up_z"), UP, strict=True)),
    **dict.fromkeys(("drift_x", "drift_y", "drift_z"), 0.0),
    **dict.fromkeys(("gravity_x", "gravity_y", "gravity_z"), 0.0),
    **{"friction": 0.0, "surface_energy": 0.0, "rolling": "none", "twisting": "none"},
}
"""Values that an engine may leave unread, where they are these."""

TEMPLATE = Template(
    name="contacts",
    neutral=NEUTRAL,
    variants={
        "plane": default_values(bodies=1),
        "pair": default_values(bodies=2),
        "prescribed-plane": default_values(bodies=1, segments=1),
        "prescribed-pair": default_values(bodies=2, segments=1),
    },
    notes={
        "plane": "a sphere and horizontal planes.",
        "pair": "two spheres.",
        "prescribed-plane": "a sphere that moves along a given path over a plane.",
        "prescribed-pair": "two spheres, the first of which moves along a given path.",
    },
)
