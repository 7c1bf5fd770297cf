"""What engines are told of a contact scene: the names of all values, whatever the case."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from operator import mul

from harness.cases.contact_base.parameters import Materials, one_material
from harness.engines.contract import Job, Template, Value
from harness.errors import RequestError
from harness.parameters.contact_coefficients import PARTNER
from harness.parameters.contact_law import ContactLaw
from harness.parameters.contact_scene import ZERO, Body, ContactScene, Plane, Segment, Vector

COMPONENTS = ("x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz")
MOST_SEGMENTS = 6
AXES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
UP = AXES[2]
MOVED = ("vx", "vy", "vz", "wx", "wy", "wz")
"""Of the body that is moved, in each segment of a prescribed motion."""
OF_MDR = ("yield_stress", "bulk_response")
"""Parts of a law that are told where they are there."""


def values_of(
    scene: ContactScene, interface: str = "current", materials: Materials = "stated"
) -> dict[str, Value]:
    """Return what a script is told of a scene with one or two spheres and parallel planes.

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
    told: dict[str, Value] = {n: 0.0 if v is None else v for n, v in values.items()}
    if law.yield_stress is not None:
        told["yield_stress"] = law.yield_stress
    if law.bulk_response:
        told["bulk_response"] = "yes"
    if law.two_materials and law.materials:
        if materials == "stated":
            told |= zip(("youngs_modulus", "poisson_ratio"), one_material(law), strict=True)
        else:
            told |= zip(PARTNER, law.materials[1], strict=True)
    return {**told, "clipped": "yes" if law.clipped else "no"}


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
        for index, told in enumerate(zip(piece.velocities, piece.omegas, strict=True))
        if told != begun[index]
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


def _default(bodies: int, segments: int = 0) -> dict[str, Value]:
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
        "plane": _default(bodies=1),
        "pair": _default(bodies=2),
        "prescribed-plane": _default(bodies=1, segments=1),
        "prescribed-pair": _default(bodies=2, segments=1),
    },
    notes={
        "plane": "a sphere and horizontal planes.",
        "pair": "two spheres.",
        "prescribed-plane": "a sphere that moves along a given path over a plane.",
        "prescribed-pair": "two spheres, the first of which moves along a given path.",
    },
)
