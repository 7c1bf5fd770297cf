"""A scene in MFiX's terms: the spheres in its box, and the values of its keywords.

No keyword of MFiX holds a particle. A particle within a radius of a mass outflow takes the
outflow's velocity and no forces (21.3.2, ``mass_outflow_dem.f``): at one of no velocity it stays,
after its first step, with whose velocity it starts. Held ones come last, and no boundary is cyclic:
contacts would count twice (``desgrid_mod.f``). The outflow is the floor of the box: held particles
must be level, and particles in a line along x stand upright, x downward, the last on the floor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from harness.errors import RequestError
from harness.parameters.law import Contact
from harness.parameters.scene import ContactScene

Floats = NDArray[np.float64]
Pair = tuple[float, float]
Scheme = Literal["EULER", "ADAMS_BASHFORTH"]  # ``DES_INTG_METHOD``

# the reference DEM's names, and the part of h^2 a in the first step's displacement
REFERENCE: dict[Scheme, str] = {"EULER": "mfix-euler", "ADAMS_BASHFORTH": "mfix-adams-bashforth"}
FIRST_STEP: dict[Scheme, float] = {"EULER": 1.0, "ADAMS_BASHFORTH": 0.5}

LEAST_FACTOR = 10.0  # of ``DTSOLID_FACTOR`` (``check_solids_dem.f``)
BEHIND, BEYOND = 2, 2  # spheres of a row behind its first one, and beyond the last stage
EQUAL = 1e-9  # relative difference of masses, or diameters, that are equal
SEARCH_CELL = 2.4  # [d] the search looks half a cell about a particle, and must reach a diameter


def steps_per_contact(factor: float, contact: Contact) -> float:
    """Return the steps per pi sqrt(m/k) that MFiX takes at a ``DTSOLID_FACTOR``.

    The factor divides the damped contact time of m/2, pi sqrt(m/k) / sqrt(2 (1 - zeta^2)). Raise
    RequestError for a factor that is not positive, or a contact with zeta >= 1 or without m/2.
    """
    if not (math.isfinite(factor) and factor > 0.0):
        raise RequestError(f"factor = {factor!r}: must be finite and greater than 0")
    if contact.effective_mass != "half":
        raise RequestError(
            "effective_mass = 'full': MFiX takes half the mass, must be 'half' "
            "(--set contact.effective_mass=half, of critical-angle --half-mass)"
        )
    if contact.zeta >= 1.0:
        raise RequestError(f"damping ratio = {contact.zeta:g}: must be less than 1 in MFiX")
    return factor * math.sqrt(2.0 * (1.0 - contact.zeta**2))


@dataclass(frozen=True)
class System:
    """A run of MFiX: a scene in a box from (0, 0), a frame every so many steps of the clock.

    ``place`` (N, 2) are all spheres in the box [m], mobile ones first. Vectors of the scene are
    those times ``axes`` (2, 2) in the box, ``origin`` is where the scene's is.
    """

    name: str
    scene: ContactScene
    steps: int
    every: int
    scheme: Scheme
    place: Floats
    axes: Floats
    origin: Pair
    box: Pair

    @property
    def mobile(self) -> int:
        """Return the number of mobile spheres."""
        return int(np.count_nonzero(~self.scene.fixed))

    @property
    def first_step(self) -> int:
        """Return the steps that the clock shows at the start.

        Such that frames of forces, which are those of a step before, come a step after a sample.
        """
        return self.every - 1 if self.scene.forces else 0

    def start_velocity(self) -> Floats:
        """Return all velocities at the start [m/s], of held spheres what their first step takes."""
        scene, n, d = self.scene, self.mobile, float(self.scene.diameter[0])
        stiffness, mass = scene.stiffness, float(scene.mass[0])
        moving = scene.velocity[:n] @ self.axes
        away = self.place[n:, None] - self.place[None, :n]
        distance = np.hypot(away[..., 0], away[..., 1])
        normal = away / distance[..., None]
        eta = 2.0 * scene.contact.zeta * math.sqrt(0.5 * stiffness * mass)
        push = stiffness * (d - distance) + eta * (moving * normal).sum(axis=-1)
        pushed = (np.where(distance < d, push, 0.0)[..., None] * normal).sum(axis=1) / mass
        taken = scene.gravity @ self.axes + pushed
        return np.vstack([moving, 0.0 - taken * FIRST_STEP[self.scheme] * scene.step])

    def keywords(self) -> dict[str, Any]:
        """Return the values of ``mfix.dat``; raise RequestError for too coarse a step."""
        scene, (width, height) = self.scene, self.box
        gravity = scene.gravity @ self.axes
        d, mass, contact = float(scene.diameter[0]), float(scene.mass[0]), scene.contact
        steps = math.pi * math.sqrt(mass / scene.stiffness) / scene.step
        of_one = steps_per_contact(1.0, contact)
        if not steps / of_one >= LEAST_FACTOR:
            raise RequestError(
                f"steps_per_contact = {steps:g} is DTSOLID_FACTOR = {steps / of_one:.4g} in MFiX, "
                f"which takes {LEAST_FACTOR:g} or more: must be at least "
                f"{LEAST_FACTOR * of_one:.4g} with this contact"
            )
        nominal = math.exp(-math.pi * contact.zeta / math.sqrt(1.0 - contact.zeta**2))
        stated = contact.stated_restitution
        return {
            "name": self.name.upper().replace("-", "_")[:40],
            **{"forces": scene.forces, "held": self.mobile < len(self.place)},
            # half a step less: MFiX rounds the number of steps up, in single precision
            "stop": (self.first_step + self.steps - 0.5) * scene.step,
            "start": self.first_step * scene.step if self.first_step else "",
            **{"gravity_x": float(gravity[0]), "gravity_y": float(gravity[1])},
            **{"width": width, "columns": max(3, math.floor(0.5 * width / d))},
            **{"height": height, "rows": max(3, math.floor(0.5 * height / d))},
            "search_columns": max(1, math.floor(width / (SEARCH_CELL * d))),
            "search_rows": max(1, math.floor(height / (SEARCH_CELL * d))),
            **{"diameter": d, "density": mass * 6.0 / math.pi / d**3},
            **{"particles": len(self.place), "stiffness": scene.stiffness},
            "restitution": nominal if stated is None else stated,
            **{"factor": steps / of_one, "scheme": self.scheme},
            "interval": self.every * scene.step,
        }


def system_of(name: str, scene: ContactScene, steps: int, every: int, scheme: Scheme) -> System:
    """Return the system of the first ``steps`` of a scene, a frame every so many steps.

    Raise RequestError for a scene that MFiX cannot hold, or whose forces a scheme does not give.
    """
    place, d, fixed = scene.position, float(scene.diameter[0]), scene.fixed
    held, count = place[fixed], np.count_nonzero(~fixed)
    flat = not (np.ptp(place[:, 1]) or scene.gravity[1] or scene.velocity[:, 1].any())
    line, axes = len(place) > 1 and bool(flat), np.eye(2)
    for reason, refused in {
        "its spheres have one diameter and one mass": np.ptp(scene.diameter) > EQUAL * d
        or np.ptp(scene.mass) > EQUAL * scene.mass[0],
        "it holds no particles to the axis of a column": scene.columns is not None,
        "its fixed particles must come last": fixed[:count].any(),
        "it gives forces of lines in scheme EULER only": scene.forces
        and not (line and scheme == "EULER"),
        "its fixed particles must be level": not line and len({*held[:, 1]}) != 1,
        "particles in a line must come in order, and the last alone be fixed": line
        and (fixed[:-1].any() or np.any(np.diff(place[:, 0]) <= 0.0)),
        "it takes one particle over a row, and stages that say how far it goes": not line
        and scene.period is not None
        and not (count == 1 and scene.stages),
    }.items():
        if refused:
            raise RequestError(reason)
    if line:
        axes, steps = np.array([[0.0, -1.0], [1.0, 0.0]]), steps + 1
        origin, box = _box(scene, steps * scene.step, line=True)
    elif scene.period is None:
        origin, box = _box(scene, steps * scene.step, line=False)
    else:
        steps = every * math.ceil(steps / every)
        end = max(stage.place for stage in scene.stages) - float(held[0, 0])
        number = np.arange(1 - BEHIND, math.ceil(end / d * (1.0 - EQUAL)) + BEYOND + 1)
        row = held[0] + np.column_stack([number * d, np.zeros(len(number))])
        lift = np.array([0.0, 1e-12 * d])  # rounding of a touch must not make an overlap
        place = np.vstack([place[0] + lift, row])
        origin = ((BEHIND + 0.5) * d - float(held[0, 0]), 0.5 * d - float(held[0, 1]))
        box = ((len(number) + 2) * d, 6.0 * d)
    return System(name, scene, steps, every, scheme, place @ axes + origin, axes, origin, box)


def _box(scene: ContactScene, time: float, *, line: bool) -> tuple[Pair, Pair]:
    """Return origin and box of a line that stands, or of spheres over held ones, for a time [s]."""
    d, place, (gx, gy) = float(scene.diameter[0]), scene.position, scene.gravity
    flight = np.abs(scene.velocity).max(axis=0) * time
    if line:
        moved, falls = float(flight[0]), 0.5 * max(gx, 0.0) * time**2
        lowest = 0.5 * d if scene.fixed[-1] else 2.0 * d + (moved + falls)
        top = lowest + float(place[-1, 0] - place[0, 0])
        return (2.0 * d, top + float(place[0, 0])), (4.0 * d, top + 2.0 * d + moved)
    x0, y0 = (float(value) for value in place[scene.fixed].min(axis=0))
    x, y = place[:, 0] - x0, place[:, 1] - y0
    flight = flight + 0.5 * np.maximum([abs(gx), gy], 0.0) * time**2
    reach = float(flight[0]) + 3.0 * d
    origin = (reach - min(float(x.min()), 0.0) - x0, 0.5 * d - y0)
    return origin, (float(np.ptp(x)) + 2.0 * reach, 2.5 * d + max(float(y.max()), d) + flight[1])
