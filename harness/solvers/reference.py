"""The reference: any scene, stepped as DEM codes step it, under the conventions of a code.

A step of velocity Verlet kicks the velocities by half a step, moves the positions, computes forces
there by the velocities of half a step, and kicks again; the schemes of MFiX are beside it. Its limit
of small steps is the solution of the contact law. At the step of a code it is that code's result to
round-off, or one of the two is wrong.

The physics is that of :mod:`harness.model.law`, conventions and known defects are those of
:mod:`harness.model.conventions`. Springs follow Luding, Granular Matter 10, 235 (2008): one is
turned into the plane of the contact, grows by the slip of the step, and is cut back at Coulomb's
limit to what the limit leaves (his section 4.2). Written from the literature and manuals.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from harness.compiled import compiled, shielded
from harness.errors import EngineNaNError
from harness.model.conventions import Faults, Rules
from harness.model.law import DAMPING, Law, damping_ratio
from harness.model.motion import Floats, Motion
from harness.model.scene import Body, Scene, Wall
from harness.solvers import mdr

Records = Any  # a record, or an array of records, of one of the dtypes below
Triple = tuple[float, float, float]
Number = TypeVar("Number", float, Floats)

# ---- running a scene


def run(scene: Scene, rules: Rules | None = None, faults: Faults | None = None) -> Motion:
    """Return the motion of a scene by the conventions and known defects of a code.

    Samples are those at the start and after every ``scene.every`` steps. Raise EngineNaNError
    where the motion overflows.
    """
    simulation = Simulation(scene, rules, faults)
    simulation.advance(scene.steps)
    return simulation.motion()


class Simulation:
    """A scene on its way: ``step_number`` steps are taken."""

    def __init__(
        self, scene: Scene, rules: Rules | None = None, faults: Faults | None = None
    ) -> None:
        self.scene, self.rules, self.faults = scene, rules or Rules(), faults or Faults()
        self.step_number = 0
        self._system = _system(scene, self.rules, self.faults)
        starts = np.cumsum([0, *(segment.steps for segment in scene.segments)]).tolist()
        self._segments = dict(zip(starts, scene.segments, strict=False))
        setups = {0, *self._segments, *scene.setups}
        self._events = sorted({*setups, *self.faults.torsion_reversed_at})
        self._setups = setups
        samples = scene.steps // scene.every + 1
        self._samples = np.empty((samples, len(scene.bodies), PARTS, 3))
        self._temperatures = np.empty((samples, len(scene.bodies)))
        self._begin()

    def advance(self, steps: int) -> None:
        """Take so many steps, with the setups and segments of the scene on the way."""
        end = self.step_number + steps
        while self.step_number < end:
            until = min([at for at in self._events if at > self.step_number] + [end])
            self._step(until - self.step_number)

    def advance_until(self, place: float, most: int, look: int = 50) -> bool:
        """Take at most so many steps until the first body is beyond x = place [m], or moves back.

        It is looked at each so many steps, counted from the start. Return whether it was so.
        """
        return self._step(most, look, place)

    def set_up(self) -> None:
        """Compute forces by the velocities of the whole step, as codes do where a run begins."""
        if self.faults.springs_lost_in_setup and self.step_number:
            self._system.contacts["springs"][:, 0] = 0.0
        if self.faults.tsuji_again_in_setup and self.step_number:
            self._take_tsuji_again()
        set_forces(self._system, 0.0, self.step_number * self.scene.step)
        if not self.step_number:
            self._system.state[0, TORQUE] += self.faults.setup_torque
        set_accelerations_before(self._system)

    def motion(self) -> Motion:
        """Return the samples so far; raise EngineNaNError for one that is not finite."""
        taken = self.step_number // self.scene.every + 1
        samples = self._samples[:taken]
        if not np.isfinite(samples).all():
            raise EngineNaNError("reference: the motion is not finite (NaN)")
        time = np.arange(taken) * (self.scene.every * self.scene.step)
        parts = [np.ascontiguousarray(samples[:, :, part]) for part in range(PARTS)]
        warms = any(law.heat != "none" for law in self.scene.all_laws)
        return Motion(time, *parts, self._temperatures[:taken] if warms else None)

    @property
    def state(self) -> Floats:
        """Return position, velocity, angular velocity, force and torque now, (N, 5, 3)."""
        return self._system.state

    def _begin(self) -> None:
        self._act_at(0)
        self._samples[0], self._temperatures[0] = self._system.state, self._system.heat[:, 0]

    def _step(self, steps: int, look: int = 0, place: float = math.inf) -> bool:
        taken = shielded(
            take_steps, self._system, self.step_number, steps, self.scene.every,
            self._samples, self._temperatures, look, place,
        )  # fmt: skip
        self.step_number += abs(taken)
        if self.step_number < self.scene.steps:
            self._act_at(self.step_number)
        return taken < 0

    def _act_at(self, number: int) -> None:
        """Do what happens at a step: change hands, prescribe velocities, set forces up."""
        if number in self._segments:
            segment, state = self._segments[number], self._system.state
            state[:, VELOCITY], state[:, SPIN] = segment.velocities, segment.angular_velocities
        if number in self.faults.torsion_reversed_at:
            self._system.contacts["springs"][:, 1:] *= -1.0
        if number in self._setups:
            self.set_up()

    def _take_tsuji_again(self) -> None:
        laws = self._system.laws
        laws["restitution"] = tsuji(laws["restitution"])
        again = _tsuji_dashpot(laws["restitution"], self.faults)
        laws["dashpot"] = np.where(laws["tsuji"], again, laws["dashpot"])


# ---- the limit of small steps


class Limit(NamedTuple):
    """A quantity at step zero, and a bound of its error."""

    value: float
    error: float


def limit(
    quantities: Callable[[int], Mapping[str, float]],
    tolerance: float | Mapping[str, float],
    *,
    first: int = 100,
    most: int = 102_400,
) -> dict[str, Limit]:
    """Return the limits of quantities by name, of runs with ever more steps of the same time.

    ``quantities`` runs with a number of steps, which doubles from ``first`` until the errors are
    within the ``tolerance`` (of all, or by name), or to ``most``. Richardson's extrapolation of
    first order, 2 y(h/2) - y(h); the error is the spread of the last three.
    """
    runs, steps = [dict(quantities(first))], first
    names = runs[0]
    allowed = tolerance if isinstance(tolerance, Mapping) else dict.fromkeys(names, tolerance)
    limits = {name: Limit(runs[0][name], math.inf) for name in names}
    while 2 * steps <= most and any(not limits[n].error <= allowed[n] for n in names):
        steps *= 2
        runs.append(dict(quantities(steps)))
        for name in names:
            values = [run[name] for run in runs[-4:]]
            steady = [
                2.0 * after - before for before, after in zip(values, values[1:], strict=False)
            ]
            error = max(steady) - min(steady) if len(steady) > 2 else math.inf
            limits[name] = Limit(steady[-1], error)
    return limits


# ---- a scene as records, for compiled code

POSITION, VELOCITY, SPIN, FORCE, TORQUE = range(5)
PARTS = 5
HOOKE, HERTZ, DMT, JKR, MDR = range(5)
NORMALS = {"hooke": HOOKE, "hertz": HERTZ, "dmt": DMT, "jkr": JKR, "mdr": MDR}
TURNED, PROJECTED, ROTATED, ROOM = range(4)
FRAMES = {"turned": TURNED, "projected": PROJECTED, "rotated": ROTATED, "room": ROOM}
RADIUS, CONTACT_POINT, HEIGHT = range(3)
LEVERS = {"radius": RADIUS, "contact_point": CONTACT_POINT, "height": HEIGHT}
VERLET, EULER, ADAMS_BASHFORTH = range(3)
SCHEMES = {
    "velocity_verlet": VERLET,
    "mfix_euler": EULER,
    "mfix_adams_bashforth": ADAMS_BASHFORTH,
}
PLANE, CYLINDER, SPHERE = range(3)
SHAPES = {"plane": PLANE, "cylinder": CYLINDER, "sphere": SPHERE}
AT_LIMIT = 1.0 + 1e-15  # a spring that was cut back may be off its limit by rounding
HEATS = {"none": 0, "radius": 1, "area": 2}

_F, _I, _B, _V = np.float64, np.int64, np.bool_, (np.float64, 3)
LAW = np.dtype([
    ("normal", _I), ("stiffness", _F), ("surface", _F), ("dashpot", _F), ("mass_power", _F),
    ("radius_power", _F), ("secant", _B), ("tsuji", _B), ("restitution", _F), ("clipped", _B), ("shear", _F),
    ("by_radius", _B), ("by_force", _B), ("rescaled", _B), ("projected", _B),
    ("tangential_damping", _F), ("friction", _F), ("rolling", *_V), ("twisting", *_V),
    ("marshall", _B), ("marshall_by_radius", _B), ("cut_by_radius", _B), ("pull_loads", _B),
    ("poisson", _F), ("yield_stress", _F), ("bulk_share", _F), ("by_slope", _B), ("heat", _I),
    ("conductance", _F),
])  # fmt: skip
RULES = np.dtype([
    ("scheme", _I), ("sticking_only", _B), ("torque_lever", _I), ("velocity_lever", _I),
    ("wall_lever", _I), ("wall_spin_levered", _B), ("wall_curvature", _F), ("least_overlap", _F),
    ("wall_touches_at_zero", _B), ("spring_frame", _I), ("torsion_frame", _I),
    ("mean_spin", _B), ("turned_arms", _B), ("by_displacement", _B), ("forgets_setup", _B),
    ("wall_magnified", _B), ("growth_screened", _B), ("growth_steps", _F),
    ("limit_by_rate", _B), ("longest_neck", _F), ("wall_at_rest_in_setup", _B),
    ("quaternion", _B), ("damping_interchanged", _B), ("sticking_share", _F),
    ("newton_error", _F), ("mdr_parts_at_zero", _B), ("step", _F), ("drag", _F),
    ("period", *_V), ("cylinder_shear", *_V), ("heats", _B), ("grows", _B),
])  # fmt: skip
BODY = np.dtype([
    ("radius", _F), ("inverse_mass", *_V), ("inverse_inertia", _F), ("gravity", *_V),
    ("dragged", _F), ("heat_capacity", _F),
])  # fmt: skip
WALL = np.dtype([
    ("shape", _I), ("point", *_V), ("direction", *_V), ("radius", _F), ("velocity", *_V),
    ("amplitude", *_V), ("frequency", _F), ("surface_velocity", *_V), ("spin", *_V),
    ("temperature", _F),
])  # fmt: skip
CONTACT = np.dtype([
    ("first", _I), ("second", _I), ("law", _I), ("mass", _F), ("radius", _F),
    ("normal", *_V), ("springs", _F, (3, 3)), ("largest", _F), ("slope", _F),
])  # fmt: skip


class System(NamedTuple):
    """A scene as records: what is given, and what moves.

    ``state`` (N, 5, 3) are position, velocity, angular velocity, force and torque; ``before``
    (N, 2, 3) accelerations of the step before; ``heat`` (N, 2) temperature and heat flow. The
    second body of a contact at wall k is -1 - k; its radius is the contact radius of the step
    before, 0 apart; its springs are the tangential, rolling and twisting one.
    """

    rules: Records
    laws: Records
    bodies: Records
    walls: Records
    contacts: Records
    state: Floats
    before: Floats
    heat: Floats
    mdr_bodies: Records
    sides: Records


def _system(scene: Scene, rules: Rules, faults: Faults) -> System:
    bodies, laws = scene.bodies, _Laws(scene, faults)
    contacts = [_contact(scene, rules, laws, i, j) for i, j in _partners(scene)]
    state = np.zeros((len(bodies), PARTS, 3))
    for part, name in enumerate(("position", "velocity", "angular_velocity")):
        state[:, part] = [getattr(body, name) for body in bodies]
    heat = np.array([(body.temperature, 0.0) for body in bodies])
    return System(
        rules=_records(RULES, [_rules_record(scene, rules, faults)]),
        laws=_records(LAW, laws.records),
        bodies=_records(BODY, [_body_record(scene, body) for body in bodies]),
        walls=_records(WALL, [_wall_record(wall) for wall in scene.walls]),
        contacts=_records(CONTACT, contacts),
        state=state,
        before=np.zeros((len(bodies), 2, 3)),
        heat=heat,
        mdr_bodies=mdr.first_state(np.array([body.radius for body in bodies])),
        sides=np.zeros((len(contacts), 2), dtype=mdr.SIDE),
    )


def _records(kind: np.dtype[Any], rows: list[dict[str, Any]]) -> NDArray[Any]:
    table = np.zeros(len(rows), dtype=kind)
    for record, row in zip(table, rows, strict=True):
        for name, value in row.items():
            record[name] = value
    return table


def _partners(scene: Scene) -> Iterator[tuple[int, int]]:
    """Yield the indices of bodies that may touch, and of bodies and walls (-1 - k)."""
    free = [bool(scene.segments) or body.motion == "free" for body in scene.bodies]
    count = len(free)
    pairs = scene.pairs or [(i, j) for i in range(count) for j in range(i + 1, count)]
    yield from ((i, j) for i, j in pairs if free[i] or free[j])
    yield from ((i, -1 - k) for i in range(count) for k in range(len(scene.walls)) if free[i])


class _Laws:
    """The laws of a scene as records, one for each law between bodies and at walls."""

    def __init__(self, scene: Scene, faults: Faults) -> None:
        self._scene, self._faults = scene, faults
        self._numbers: dict[tuple[Law, bool], int] = {}
        self.records: list[dict[str, Any]] = []
        self._by_types: dict[tuple[int, int, bool], int] = {}

    def number(self, first: int, second: int, wall: bool) -> int:
        key = (first, second, wall)
        if key not in self._by_types:
            law = self._scene.law_of(first, second)
            if (law, wall) not in self._numbers:
                self._numbers[law, wall] = len(self.records)
                self.records.append(_law_record(law, self._faults, wall))
            self._by_types[key] = self._numbers[law, wall]
        return self._by_types[key]


def _contact(scene: Scene, rules: Rules, laws: _Laws, i: int, j: int) -> dict[str, Any]:
    first, second = scene.bodies[i], scene.bodies[j] if j >= 0 else scene.walls[-1 - j]
    own = bool(scene.segments) or rules.frozen_mass == "own"
    masses = [body.mass for body in (first, second) if isinstance(body, Body)
              if own or body.motion != "frozen"]  # fmt: skip
    number = laws.number(first.type, second.type, j < 0)
    return {"first": i, "second": j, "law": number, "mass": 1.0 / sum(1.0 / m for m in masses)}


def _body_record(scene: Scene, body: Body) -> dict[str, Any]:
    free = not scene.segments and body.motion == "free"
    axes = free * np.array(body.axes, dtype=float)
    return {
        "radius": body.radius,
        "inverse_mass": axes / body.mass,
        "inverse_inertia": free / body.moment_of_inertia,
        "gravity": axes * np.array(scene.gravity),
        "dragged": float(free),
        "heat_capacity": body.mass * body.heat_capacity,
    }


def _wall_record(wall: Wall) -> dict[str, Any]:
    names = ("point", "direction", "velocity", "amplitude", "frequency", "surface_velocity", "spin",
             "temperature")  # fmt: skip
    radius = (wall.radius or 0.0) * (-1.0 if wall.hollow else 1.0)
    values = {name: getattr(wall, name) for name in names}
    return {**values, "shape": SHAPES[wall.shape], "radius": radius}


def _rules_record(scene: Scene, rules: Rules, faults: Faults) -> dict[str, Any]:
    return {
        "scheme": SCHEMES[rules.scheme],
        "sticking_only": rules.damping_in_cap == "sticking_only",
        "torque_lever": LEVERS[rules.torque_lever],
        "velocity_lever": LEVERS[rules.velocity_lever],
        "wall_lever": LEVERS[rules.wall_lever],
        "wall_spin_levered": rules.wall_spin == "levered",
        "wall_curvature": rules.wall_curvature,
        "least_overlap": rules.least_overlap,
        "wall_touches_at_zero": rules.wall_touches_at_zero,
        "spring_frame": FRAMES[rules.spring_frame],
        "torsion_frame": FRAMES[rules.torsion_frame],
        "mean_spin": rules.spring_spin == "mean",
        "turned_arms": rules.slip_step == "turned_arms",
        "by_displacement": rules.rescaled_from == "displacement",
        "forgets_setup": rules.forgets_setup,
        "wall_magnified": rules.mdr_wall_force == "magnified",
        "growth_screened": rules.mdr_growth == "screened",
        "growth_steps": rules.mdr_growth_steps,
        "limit_by_rate": faults.twisting_limit_by_rate,
        "longest_neck": math.inf if faults.longest_neck is None else faults.longest_neck,
        "wall_at_rest_in_setup": faults.wall_at_rest_in_setup,
        "quaternion": faults.small_angle_quaternion,
        "damping_interchanged": faults.mdr_damping_interchanged,
        "sticking_share": faults.mdr_sticking_share,
        "newton_error": faults.mdr_newton_error,
        "mdr_parts_at_zero": faults.mdr_parts_at_zero,
        "step": scene.step,
        "drag": scene.drag,
        "period": [length or 0.0 for length in scene.period],
        "cylinder_shear": faults.cylinder_shear,
        "heats": any(law.heat != "none" for law in scene.all_laws),
        "grows": any(law.normal == "mdr" for law in scene.all_laws),
    }


def _law_record(law: Law, faults: Faults, wall: bool) -> dict[str, Any]:
    where = ("all", "walls") if wall else ("all",)
    modulus, shear = law.moduli or (0.75 * (law.normal_modulus or 0.0), 0.0)
    shear *= faults.shear_factor * (faults.wall_shear_factor if wall else 1.0)
    modulus *= faults.wall_modulus_factor if wall else 1.0
    mindlin, sticky = "mindlin" in law.tangential, law.normal in ("dmt", "jkr")
    with_radius = faults.tangential_radius in where and "linear" in law.tangential
    coefficient = law.tangential_modulus or 8.0 * shear if mindlin else law.tangential_stiffness
    p, q, s = DAMPING[law.damping].powers
    parts = {"rolling": law.rolling, "twisting": law.twisting}
    sliders = {
        part: [getattr(law, f"{part}_{name}") or 0.0 for name in ("stiffness", "damping", "friction")]
        for part, model in parts.items() if model == "sds"
    }  # fmt: skip
    return {
        **sliders,
        "normal": NORMALS[law.normal],
        "stiffness": law.normal_stiffness or modulus,
        "surface": law.surface_energy or 0.0,
        "dashpot": _dashpot(law, faults),
        "mass_power": p,
        "radius_power": q,
        "secant": s,
        "tsuji": law.damping == "tsuji",
        "restitution": law.restitution or 0.0,
        "clipped": law.clipped,
        "shear": coefficient or 0.0,
        "by_radius": mindlin or with_radius,
        "by_force": law.tangential.endswith("/force"),
        "rescaled": "rescale" in law.tangential,
        "projected": "classic" in law.tangential,
        "tangential_damping": law.tangential_damping or 0.0,
        "friction": law.friction or 0.0,
        "marshall": law.twisting == "marshall",
        "marshall_by_radius": mindlin and not faults.marshall_without_radius,
        "cut_by_radius": faults.cap_without_radius in where,
        "pull_loads": sticky and not faults.dmt_limit_without_pull_off,
        "poisson": law.poisson_ratio or 0.0,
        "yield_stress": law.yield_stress or 1e300,
        "bulk_share": law.bulk_share or 0.0,
        "by_slope": law.damping == "mdr",
        "heat": HEATS[law.heat],
        "conductance": law.conductance or 0.0,
    }


def tsuji(restitution: Number) -> Number:
    """Return alpha(e) [-], the polynomial fitted to Tsuji et al. (1992), of LAMMPS's manual."""
    powers = (1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218)
    value = 0.0 * restitution
    for coefficient in reversed(powers):
        value = value * restitution + coefficient
    return value


def _tsuji_dashpot(restitution: Number, faults: Faults) -> Number:
    return tsuji(restitution) * (1.0 if faults.tsuji_effective_mass else math.sqrt(2.0))


def _dashpot(law: Law, faults: Faults) -> float:
    """Return the coefficient of a dashpot.

    One made for a restitution of hertz has sqrt(5) zeta (Antypov and Elliott, EPL 94, 50004
    (2011)).
    """
    if law.restitution is None:
        factor = 2.0 if law.damping == "damping_ratio" else 1.0
        return factor * (law.damping_coefficient or 0.0)
    if law.damping == "tsuji":
        return _tsuji_dashpot(law.restitution, faults)
    return damping_ratio(law.restitution) * (2.0 if law.normal == "hooke" else math.sqrt(5.0))


# ---- vectors, for compiled code


@compiled
def add(a: Triple, b: Triple) -> Triple:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@compiled
def minus(a: Triple, b: Triple) -> Triple:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@compiled
def scale(factor: float, a: Triple) -> Triple:
    return (factor * a[0], factor * a[1], factor * a[2])


@compiled
def dot(a: Triple, b: Triple) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def cross(a: Triple, b: Triple) -> Triple:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@compiled
def size(a: Triple) -> float:
    return math.sqrt(dot(a, a))


@compiled
def project(a: Triple, normal: Triple) -> Triple:
    """Return the part of a vector in the plane of a contact."""
    return minus(a, scale(dot(a, normal), normal))


@compiled
def vector(values: Floats) -> Triple:
    return (values[0], values[1], values[2])


@compiled
def turn(a: Triple, angle: Triple) -> Triple:
    """Return a vector turned by an angle [rad] about itself (Rodrigues)."""
    t = size(angle)
    if t == 0.0:
        return a
    axis = scale(1.0 / t, angle)
    along = scale(2.0 * math.sin(0.5 * t) ** 2 * dot(axis, a), axis)
    return add(add(scale(math.cos(t), a), scale(math.sin(t), cross(axis, a))), along)


# ---- where two bodies touch


class Touch(NamedTuple):
    """A contact: normal towards the first body, overlap [m], radius of the second body [m].

    The radius is 0 for a plane, negative for a hollow wall and twice its own for a cylinder, for
    the mean curvature of both is the same. ``drift`` [m/s] is the velocity of a wall's surface.
    """

    normal: Triple
    overlap: float
    other: float
    drift: Triple


@compiled
def separation(system: System, i: int, j: int) -> Triple:
    """Return the vector [m] from body j, or its nearest periodic image, to body i."""
    x = system.state
    apart = minus(vector(x[i, POSITION]), vector(x[j, POSITION]))
    length = system.rules[0].period
    if length[0] > 0.0 or length[1] > 0.0 or length[2] > 0.0:
        a, b, c = apart
        a -= length[0] * math.floor(a / length[0] + 0.5) if length[0] > 0.0 else 0.0
        b -= length[1] * math.floor(b / length[1] + 0.5) if length[1] > 0.0 else 0.0
        c -= length[2] * math.floor(c / length[2] + 0.5) if length[2] > 0.0 else 0.0
        return (a, b, c)
    return apart


@compiled
def touch_body(system: System, i: int, j: int, apart: Triple) -> Touch:
    distance, other = size(apart), system.bodies[j].radius
    overlap = system.bodies[i].radius + other - distance
    return Touch(scale(1.0 / distance, apart), overlap, other, (0.0, 0.0, 0.0))


@compiled
def touch_wall(system: System, i: int, k: int, time: float) -> Touch:
    wall, radius = system.walls[k], system.bodies[i].radius
    place, velocity = vector(wall.point), vector(wall.velocity)
    swing, phase = vector(wall.amplitude), wall.frequency * time
    place = add(place, add(scale(time, velocity), scale(1.0 - math.cos(phase), swing)))
    drift = add(velocity, scale(wall.frequency * math.sin(phase), swing))
    drift = add(drift, vector(wall.surface_velocity))
    apart, axis = minus(vector(system.state[i, POSITION]), place), vector(wall.direction)
    if wall.shape == PLANE:
        return Touch(axis, radius - dot(apart, axis), 0.0, drift)
    other = wall.radius
    if wall.shape == CYLINDER:
        apart, other = project(apart, axis), 2.0 * wall.radius
        drift = add(drift, vector(system.rules[0].cylinder_shear))
    distance = math.copysign(size(apart), wall.radius)
    outward = scale(1.0 / abs(distance), apart)
    drift = add(drift, scale(abs(wall.radius), cross(vector(wall.spin), outward)))
    return Touch(scale(1.0 / distance, apart), radius + wall.radius - distance, other, drift)


@compiled
def lever(kind: int, overlap: float, radius: float) -> float:
    """Return the distance of a contact from the centre of a sphere [m], by a convention."""
    if kind == RADIUS:
        return radius
    return radius - (overlap if kind == HEIGHT else 0.5 * overlap)


@compiled
def jkr_end(law: Records, radius: float) -> float:
    """Return the overlap [m] at which JKR parts, at its largest tension: a^3 = 9 pi g R^2 / 4 E*."""
    cube = 9.0 * math.pi * law.surface * radius * radius / (4.0 * law.stiffness)
    return float(-(cube ** (2.0 / 3.0)) / (3.0 * radius))


@compiled
def ends(system: System, c: int, touch: Touch, radius: float) -> bool:
    """Return whether bodies are apart, of which a contact may have been closed before."""
    contact, rules = system.contacts[c], system.rules[0]
    law, least = system.laws[contact.law], 0.0
    if contact.radius > 0.0 and law.normal == JKR:
        least = max(jkr_end(law, radius), -rules.longest_neck)
    elif contact.radius > 0.0 and law.normal == MDR and not rules.mdr_parts_at_zero:
        if system.sides[c, 0].stuck > 0.0 or system.sides[c, 1].stuck > 0.0:
            return False
    elif rules.least_overlap > 0.0:
        least = rules.least_overlap * (system.bodies[contact.first].radius + max(touch.other, 0.0))
    if touch.overlap == least and contact.second < 0 and rules.wall_touches_at_zero:
        return False
    return bool(touch.overlap <= least)


# ---- the forces of a contact


@compiled
def jkr_radius(modulus: float, surface: float, radius: float, overlap: float) -> float:
    """Return a [m] of d = a^2/R - 2 sqrt(pi gamma a/E*) on its stable branch, by Newton in sqrt(a).

    At overlaps below the end of that branch it is the radius there.
    """
    c = math.sqrt(math.pi * surface / modulus)
    fold = (0.5 * c * radius) ** (1.0 / 3.0)
    if fold**4 / radius - 2.0 * c * fold >= overlap:
        return fold * fold
    root = (2.0 * c * radius) ** (1.0 / 3.0) + max(overlap * radius, 0.0) ** 0.25  # from above
    for _ in range(60):
        slope = 4.0 * root**3 / radius - 2.0 * c
        change = (root**4 / radius - 2.0 * c * root - overlap) / slope
        root -= change
        if change <= 4e-16 * root:
            break
    return root * root


@compiled
def elastic(law: Records, radius: float, overlap: float) -> tuple[float, float, float]:
    """Return elastic force [N], contact radius [m] and pull-off force [N]."""
    if law.normal == JKR and law.surface > 0.0:
        a = jkr_radius(law.stiffness, law.surface, radius, overlap)
        tension = 4.0 * math.sqrt(math.pi * law.surface * law.stiffness * a**3)
        force = 4.0 / 3.0 * law.stiffness * a**3 / radius - tension
        return force, a, 3.0 * math.pi * law.surface * radius
    a = math.sqrt(max(radius * overlap, 0.0))
    if law.normal == HOOKE:
        return law.stiffness * overlap, a, 0.0
    pull = 4.0 * math.pi * law.surface * radius if law.normal == DMT else 0.0
    return 4.0 / 3.0 * law.stiffness * a * overlap - pull, a, pull


@compiled
def elastic_mdr(system: System, c: int, touch: Touch, moves: bool) -> tuple[float, float]:
    """Return elastic force [N] and contact radius [m] of mdr, the mean of both sides."""
    contact, rules = system.contacts[c], system.rules[0]
    law, wall = system.laws[contact.law], contact.second < 0
    contact.largest = max(contact.largest, touch.overlap)
    sides, force, a = system.sides[c], 0.0, 0.0
    i, j = contact.first, contact.first if wall else contact.second
    radii = (system.bodies[i].radius, touch.other)
    depths = (
        mdr.flat_depth(sides, 0, touch.overlap, contact.largest, radii[0], radii[1]),
        mdr.flat_depth(sides, 1, touch.overlap, contact.largest, radii[1], radii[0]),
    )
    for k in range(1 if wall else 2):
        body = system.mdr_bodies[i if k == 0 else j]
        of_side, edge = mdr.side_force(law, rules, body, sides[k], depths[k], moves)
        force, a = force + of_side, a + edge
    if not wall:
        return 0.5 * force, 0.5 * a
    if rules.wall_magnified:
        depth = sides[0].depth_in_first / system.mdr_bodies[i].first_radius
        force *= 1.0 + math.exp(10.7 * depth - 10.0)
    return force, a


@compiled
def dashpot(system: System, c: int, force: float, a: float, overlap: float, moves: bool) -> float:
    """Return the normal dashpot eta [kg/s] of an elastic force [N] and a contact radius [m]."""
    contact, rules = system.contacts[c], system.rules[0]
    law, mass = system.laws[contact.law], contact.mass
    eta = law.dashpot
    if law.normal == MDR and a <= 0.0:  # a dent that does not touch
        return 0.0
    if law.by_slope:
        if moves:
            wall = contact.second < 0
            factor = (0.5 if wall else 2.0) if rules.damping_interchanged else 1.0
            slope = 2.0 * (2.0 if wall else 1.0) * law.stiffness * a
            contact.slope = factor * math.sqrt(mass * slope)
        return float(eta * contact.slope)
    if law.mass_power > 0.0:
        eta *= mass
    if law.radius_power > 0.0:
        eta *= a
    if law.secant:
        eta *= math.sqrt(max(mass * force / overlap, 0.0)) if overlap != 0.0 else 0.0
    return float(eta)


@compiled
def limit_slider(
    sticking_only: bool, q: Triple, u: Triple, k: float, eta: float, cap: float
) -> tuple[Triple, Triple, bool]:
    """Return force and spring of a spring k and a dashpot eta, and whether it slides.

    ``q`` and ``u`` are displacement and velocity; the force is at most ``cap``, beyond which the
    spring is cut back.
    """
    spring, drag = scale(-k, q), scale(-eta, u)
    held = add(spring, drag)
    sticking_only = sticking_only and k > 0.0
    limited = spring if sticking_only else held
    length = size(limited)
    if length <= cap * AT_LIMIT:
        return held, q, False
    force = scale(cap / length, limited)
    if k > 0.0:
        left = scale(-1.0, force) if sticking_only else minus(drag, force)
        q = scale(1.0 / k, left)
    return force, q, True


@compiled
def carry_spring(q: Triple, frame: int, normal: Triple, last: Triple, twist: float) -> Triple:
    """Return a spring of the step before, in the contact as it is now."""
    if frame == TURNED:
        across = project(q, normal)
        now = size(across)
        return scale(size(q) / now, across) if now > 0.0 else across
    if frame == ROTATED:  # by small angles one after the other: it grows by their squares
        q = minus(q, cross(q, cross(last, normal)))
        return add(q, scale(twist, cross(last, q)))
    return q


class Slips(NamedTuple):
    """How a contact moves along its surface."""

    slip: Triple  # [m/s]
    moved: Triple  # [m] in the step
    along: float  # [m] along the normal in the step
    spin: Triple  # [rad/s] between the bodies
    both: Triple  # [rad/s] the sum of both


@compiled
def slips_of(system: System, c: int, touch: Touch, relative: Triple, h: float) -> Slips:
    """Return how a contact slips, by the relative velocity of its bodies [m/s]."""
    contact, rules, n = system.contacts[c], system.rules[0], touch.normal
    i, j = contact.first, contact.second
    radius, spin = system.bodies[i].radius, vector(system.state[i, SPIN])
    kind = rules.velocity_lever if j >= 0 else rules.wall_lever
    first, second, other = lever(kind, touch.overlap, radius), 0.0, (0.0, 0.0, 0.0)
    if j >= 0:
        second, other = lever(kind, touch.overlap, touch.other), vector(system.state[j, SPIN])
    arms = add(scale(first, spin), scale(second, other))
    slip = minus(project(relative, n), cross(arms, n))
    moved, along = scale(h, slip), h * dot(relative, n)
    if rules.turned_arms and h > 0.0:
        moved = minus(scale(h, relative), turned_arms(rules, n, (first, second), (spin, other), h))
        along = dot(moved, n)
        moved = project(moved, n)
    felt = minus(spin, other)
    if j < 0 and rules.wall_spin_levered:
        felt = scale((radius - 0.5 * touch.overlap) / (radius - touch.overlap), felt)
    return Slips(slip, moved, along, felt, add(spin, other))


@compiled
def turned_arms(
    rules: Records, n: Triple, levers: tuple[float, float], spins: tuple[Triple, Triple], h: float
) -> Triple:
    """Return how far the turning of both arms in a step moves the contact points apart [m].

    At a wall the arm turns back by the angle.
    """
    first, second = scale(-levers[0], n), scale(levers[1], n)
    if levers[1] == 0.0:
        return minus(turn(first, small_angle(rules, scale(-h, spins[0]))), first)
    by_first = minus(turn(first, small_angle(rules, scale(h, spins[0]))), first)
    by_second = minus(turn(second, small_angle(rules, scale(h, spins[1]))), second)
    return minus(by_second, by_first)


@compiled
def small_angle(rules: Records, angle: Triple) -> Triple:
    """Return the angle [rad] by which a quaternion of small angles turns, t half the angle."""
    t = 0.5 * size(angle)
    if not rules.quaternion or t == 0.0 or t**4 / 24.0 >= 2.220446049250313e-16:
        return angle
    return scale(math.atan2(t * (1.0 - t * t / 6.0), 1.0 + 0.5 * t * t) / t, angle)


@compiled
def tangential_force(
    system: System, c: int, touch: Touch, slips: Slips, h: float, a: float, radius: float,
    eta: float, load: float,
) -> Triple:  # fmt: skip
    """Return the tangential force [N] on the first body, and bring its spring on."""
    contact, rules, n = system.contacts[c], system.rules[0], touch.normal
    law = system.laws[contact.law]
    k = law.shear * (a if law.by_radius and not law.by_force else 1.0)
    q, last = vector(contact.springs[0]), n
    if contact.radius > 0.0:
        last = vector(contact.normal)
    if law.rescaled and h > 0.0:
        before = contact.radius
        if rules.by_displacement:
            before = math.sqrt(radius * max(touch.overlap + slips.along, 0.0))
        if a < before:
            q = scale(a / before, q)
    twist = 0.5 * h * dot(slips.both, last) if rules.mean_spin else 0.0
    frame = PROJECTED if law.projected else rules.spring_frame
    q = carry_spring(q, frame, n, last, twist)
    if rules.mean_spin and frame != ROTATED:
        q = add(q, scale(0.5 * h * dot(slips.both, n), cross(n, q)))
    if law.shear > 0.0:
        q = add(q, scale(a if law.by_force else 1.0, slips.moved))
    if frame == PROJECTED and h > 0.0:
        q = project(q, n)
    slack = size(q) == 0.0
    cap, drag = law.friction * load, law.tangential_damping * eta
    force, spring, slides = limit_slider(rules.sticking_only, q, slips.slip, k, drag, cap)
    if slides and k > 0.0:
        spring = scale(a, spring) if law.cut_by_radius else spring
        if slack:  # a dashpot beyond the limit, without a spring: in a setup
            force, spring = (0.0, 0.0, 0.0), q
    store(contact.springs[0], spring)
    return force


@compiled
def store(place: Floats, values: Triple) -> None:
    place[0], place[1], place[2] = values


@compiled
def rolling_torque(
    system: System, c: int, touch: Touch, slips: Slips, h: float, radius: float, load: float
) -> Triple:
    """Return the torque of rolling resistance [N m] on the first body, and bring its spring on."""
    contact, rules, n = system.contacts[c], system.rules[0], touch.normal
    k, eta, mu = vector(system.laws[contact.law].rolling)
    if mu <= 0.0:
        return (0.0, 0.0, 0.0)
    turned = rules.torsion_frame == TURNED
    u = cross(slips.spin, n) if turned else project(slips.spin, n)
    u, q = scale(radius, u), carry_torsion(system, c, touch, slips, 1, h)
    q = add(q, scale(torsion_step(rules, h), u))
    slack = size(q) == 0.0
    force, spring, slides = limit_slider(rules.sticking_only, q, u, k, eta, mu * load)
    if slides and k > 0.0 and slack:
        force, spring = (0.0, 0.0, 0.0), q
    keep_torsion(rules, contact.springs[1], spring, h)
    return scale(radius, cross(n, force) if turned else force)


@compiled
def twisting_torque(
    system: System, c: int, touch: Touch, slips: Slips, h: float, a: float, eta: float, load: float
) -> Triple:
    """Return the torque of twisting [N m] on the first body, and bring its spring on."""
    contact, rules, n = system.contacts[c], system.rules[0], touch.normal
    law = system.laws[contact.law]
    k, drag, mu = vector(law.twisting)
    if law.marshall:
        k = 0.5 * law.shear * (a if law.marshall_by_radius else 1.0) * a * a
        drag, mu = 0.5 * law.tangential_damping * eta * a * a, 2.0 / 3.0 * a * law.friction
    if mu <= 0.0:
        return (0.0, 0.0, 0.0)
    u = scale(dot(slips.spin, n), n)
    q = carry_torsion(system, c, touch, slips, 2, h)
    q = add(q, scale(torsion_step(rules, h), u))
    torque, spring, slides = limit_slider(rules.sticking_only, q, u, k, drag, mu * load)
    if slides and rules.limit_by_rate:
        torque = scale(-mu * load * np.sign(dot(u, n)), n)
        spring = scale(-1.0 / k, add(torque, scale(drag, u)))
    keep_torsion(rules, contact.springs[2], spring, h)
    return torque


@compiled
def carry_torsion(
    system: System, c: int, touch: Touch, slips: Slips, kind: int, h: float
) -> Triple:
    """Return the rolling (1) or twisting (2) spring of the step before, in the contact now."""
    contact, rules, n = system.contacts[c], system.rules[0], touch.normal
    q, last = vector(contact.springs[kind]), n
    if contact.radius > 0.0:
        last = vector(contact.normal)
    if kind == 2 and rules.torsion_frame == TURNED:
        return scale(math.copysign(size(q), dot(q, n)), n)
    twist = 0.5 * h * dot(slips.both, last) if rules.mean_spin else 0.0
    return carry_spring(q, rules.torsion_frame, n, last, twist)


@compiled
def torsion_step(rules: Records, h: float) -> float:
    return float(rules.step if rules.forgets_setup and h == 0.0 else h)


@compiled
def keep_torsion(rules: Records, place: Floats, spring: Triple, h: float) -> None:
    if not (rules.forgets_setup and h == 0.0):
        store(place, spring)


@compiled
def add_contact(system: System, c: int, touch: Touch, radius: float, h: float) -> None:
    """Add the forces of a contact to those of its bodies; h = 0 moves no spring."""
    contact, rules, n = system.contacts[c], system.rules[0], touch.normal
    i, j, law, state = contact.first, contact.second, system.laws[contact.law], system.state
    relative = vector(state[i, VELOCITY])
    if j >= 0:
        relative = minus(relative, vector(state[j, VELOCITY]))
    elif h > 0.0 or not rules.wall_at_rest_in_setup:
        relative = minus(relative, touch.drift)

    if law.normal == MDR:
        elastic_force, edge = elastic_mdr(system, c, touch, h > 0.0)
        eta = dashpot(system, c, elastic_force, edge, touch.overlap, h > 0.0)
        a, pull = math.sqrt(max(radius * touch.overlap, 0.0)), 0.0
    else:
        elastic_force, a, pull = elastic(law, radius, touch.overlap)
        eta = dashpot(system, c, elastic_force, a, touch.overlap, h > 0.0)
    normal_force = elastic_force - eta * dot(relative, n)
    if law.clipped:
        normal_force = max(normal_force, 0.0)
    load = abs(normal_force)
    if pull > 0.0:
        load = abs(elastic_force + (2.0 * pull if law.pull_loads else 0.0))

    force, torque = scale(normal_force, n), (0.0, 0.0, 0.0)
    slips = slips_of(system, c, touch, relative, h)
    if law.friction > 0.0:
        kept = vector(contact.springs[0])
        tangential = tangential_force(system, c, touch, slips, h, a, radius, eta, load)
        if rules.forgets_setup and h == 0.0:
            store(contact.springs[0], kept)
        force, torque = add(force, tangential), cross(n, tangential)
    couple = rolling_torque(system, c, touch, slips, h, radius, load)
    couple = add(couple, twisting_torque(system, c, touch, slips, h, a, eta, load))
    contact.radius = max(a, 1e-300)
    store(contact.normal, n)

    kind = rules.torque_lever if j >= 0 else rules.wall_lever
    arm = lever(kind, touch.overlap, system.bodies[i].radius)
    act(state[i], force, minus(couple, scale(arm, torque)), 1.0)
    if j >= 0:
        arm = lever(kind, touch.overlap, touch.other)
        act(state[j], force, add(couple, scale(arm, torque)), -1.0)
    if rules.heats and law.heat > 0:
        conduct(system, c, a)


@compiled
def act(body: Floats, force: Triple, torque: Triple, sign: float) -> None:
    for k in range(3):
        body[FORCE, k] += sign * force[k]
        body[TORQUE, k] += sign * torque[k]


@compiled
def conduct(system: System, c: int, a: float) -> None:
    """Add the heat that flows through a contact of radius a [m]: 2 k a, or h pi a^2, times K."""
    contact, heat = system.contacts[c], system.heat
    i, j, law = contact.first, contact.second, system.laws[contact.law]
    other = heat[j, 0] if j >= 0 else system.walls[-1 - j].temperature
    area = 2.0 * a if law.heat == 1 else math.pi * a * a
    flow = law.conductance * area * (other - heat[i, 0])
    heat[i, 1] += flow
    if j >= 0:
        heat[j, 1] -= flow


# ---- steps


@compiled
def find_touch(system: System, c: int, time: float) -> Touch:
    """Return where a pair is, or one of overlap -inf where it is apart for sure."""
    contact = system.contacts[c]
    i, j = contact.first, contact.second
    if j < 0:
        return touch_wall(system, i, -1 - j, time)
    apart = separation(system, i, j)
    reach = system.bodies[i].radius + system.bodies[j].radius
    if contact.radius == 0.0 and dot(apart, apart) > 1.000001 * reach * reach:
        return Touch((0.0, 0.0, 0.0), -math.inf, 0.0, (0.0, 0.0, 0.0))
    return touch_body(system, i, j, apart)


@compiled
def curvature_radius(system: System, c: int, touch: Touch) -> float:
    """Return R* [m] of a contact."""
    contact = system.contacts[c]
    radius = system.bodies[contact.first].radius
    if touch.other != 0.0:
        return float(radius * touch.other / (radius + touch.other))
    return float(radius / (1.0 + system.rules[0].wall_curvature))


@compiled
def grow_bodies(system: System, time: float) -> None:
    """Let bodies of mdr grow, and sum up the mean displacements of their surfaces."""
    law, rules = system.laws[0], system.rules[0]
    for b in range(len(system.bodies)):
        before = system.bodies[b].radius
        radius = mdr.grow(law, rules, system.mdr_bodies[b])
        if radius != before:
            system.bodies[b].radius = radius
            system.bodies[b].inverse_inertia *= (before / radius) ** 2
    for c in range(len(system.contacts)):
        contact, sides, touch = system.contacts[c], system.sides[c], find_touch(system, c, time)
        if touch.overlap <= 0.0:
            continue
        largest = max(contact.largest, touch.overlap)
        i, j = contact.first, contact.second
        first, overlap = system.bodies[i].radius, touch.overlap
        depth = mdr.flat_depth(sides, 0, overlap, largest, first, touch.other)
        if j >= 0:
            second = mdr.flat_depth(sides, 1, overlap, largest, touch.other, first)
            mdr.add_displacement(system.mdr_bodies[j], sides[1], second)
        mdr.add_displacement(system.mdr_bodies[i], sides[0], depth)


@compiled
def set_forces(system: System, h: float, time: float) -> None:
    """Set forces, torques and heat flows; h = 0 moves no spring, as in the setup of a run."""
    state, rules = system.state, system.rules[0]
    state[:, FORCE:] = 0.0
    system.heat[:, 1] = 0.0
    if rules.grows and h > 0.0:
        grow_bodies(system, time)
    for c in range(len(system.contacts)):
        contact, touch = system.contacts[c], find_touch(system, c, time)
        if touch.overlap == -math.inf:
            continue
        radius = curvature_radius(system, c, touch)
        if not ends(system, c, touch, radius):
            add_contact(system, c, touch, radius, h)
        elif contact.radius > 0.0:
            contact.radius = contact.largest = contact.slope = 0.0
            contact.springs[:] = 0.0
            system.sides[c] = np.zeros_like(system.sides[c])
    if rules.drag > 0.0:
        for b in range(len(state)):
            for k in range(3):
                state[b, FORCE, k] -= rules.drag * system.bodies[b].dragged * state[b, VELOCITY, k]


@compiled
def kick(system: System, h: float) -> None:
    """Change velocities by the forces acting for a time [s]."""
    state = system.state
    for b in range(len(state)):
        body = system.bodies[b]
        for k in range(3):
            state[b, VELOCITY, k] += h * (
                state[b, FORCE, k] * body.inverse_mass[k] + body.gravity[k]
            )
            state[b, SPIN, k] += h * state[b, TORQUE, k] * body.inverse_inertia


@compiled
def move(system: System, h: float) -> None:
    state = system.state
    for b in range(len(state)):
        for k in range(3):
            state[b, POSITION, k] += h * state[b, VELOCITY, k]


@compiled
def set_accelerations_before(system: System) -> None:
    """Keep the accelerations for the next step of Adams-Bashforth."""
    for b in range(len(system.state)):
        body = system.bodies[b]
        for k in range(3):
            force, torque = system.state[b, FORCE, k], system.state[b, TORQUE, k]
            system.before[b, 0, k] = force * body.inverse_mass[k] + body.gravity[k]
            system.before[b, 1, k] = torque * body.inverse_inertia


@compiled
def move_adams_bashforth(system: System, h: float) -> None:
    """Take a step v+ = v + h/2 (3 a - a_before), x+ = x + h/2 (v + v+)."""
    half, state = 0.5 * h, system.state
    for b in range(len(state)):
        for k in range(3):
            state[b, POSITION, k] += half * state[b, VELOCITY, k]
            state[b, VELOCITY, k] -= half * system.before[b, 0, k]
            state[b, SPIN, k] -= half * system.before[b, 1, k]
    kick(system, 1.5 * h)
    set_accelerations_before(system)
    move(system, half)


@compiled
def take_step(system: System, number: int) -> None:
    """Take step ``number``, counted from 1."""
    rules = system.rules[0]
    h = rules.step
    if rules.scheme == VERLET:
        kick(system, 0.5 * h)
        move(system, h)
        set_forces(system, h, number * h)
        kick(system, 0.5 * h)
    elif rules.scheme == EULER:
        kick(system, h)
        move(system, h)
        set_forces(system, h, number * h)
    else:
        move_adams_bashforth(system, h)
        set_forces(system, h, number * h)
    if rules.heats:
        for b in range(len(system.heat)):
            system.heat[b, 0] += h * system.heat[b, 1] / system.bodies[b].heat_capacity


@compiled
def take_steps(
    system: System, number: int, steps: int, every: int, samples: Floats, temperatures: Floats,
    look: int, place: float,
) -> int:  # fmt: skip
    """Take steps from step ``number`` on; return how many, negative where a look ended them.

    Every ``look`` steps the first body is looked at, whether its x is beyond ``place`` [m] or it
    moves back.
    """
    for k in range(1, steps + 1):
        take_step(system, number + k)
        if (number + k) % every == 0:
            samples[(number + k) // every] = system.state
            temperatures[(number + k) // every] = system.heat[:, 0]
        if look > 0 and (number + k) % look == 0:
            x, speed = system.state[0, POSITION, 0], system.state[0, VELOCITY, 0]
            if x > place or speed < 0.0:
                return -k
    return steps
