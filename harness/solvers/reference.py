"""The reference: any scene, stepped as DEM codes step it, under the conventions of a code.

A step of velocity Verlet kicks the velocities by half a step, moves the positions, computes forces
there by the velocities of half a step, and kicks again; the schemes of MFiX are others. The
limit of small steps is the solution of the contact law. At the step of a code the reference has
that code's result to round-off, or one of the two is wrong.

Laws are those of :mod:`harness.model.law`, conventions and known defects of codes those of
:mod:`harness.model.conventions`; :mod:`harness.solvers.contacts` has the compiled steps.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from itertools import pairwise
from operator import itemgetter
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from harness.compiled import shielded
from harness.errors import EngineNaNError
from harness.model.base import ZERO, Parameters
from harness.model.conventions import Faults, Rules
from harness.model.law import DAMPING, Law, damping_ratio
from harness.model.scene import Body, Floats, Motion, Scene, Wall
from harness.solvers import contacts, friction, kernels, mdr
from harness.solvers.contacts import System
from harness.solvers.friction import Press, Touch
from harness.solvers.kernels import FORCE, PARTS, SPIN, TORQUE, VELOCITY

Number = TypeVar("Number", float, Floats)


def run(scene: Scene, rules: Rules | None = None, faults: Faults | None = None) -> Motion:
    """Return the motion of a scene by the conventions and known defects of a code.

    Samples are those of the start and after every ``scene.every`` steps, until a look ends the
    run. Raise EngineNaNError where the motion overflows.
    """
    return shielded(_run, scene, rules, faults)


def _run(scene: Scene, rules: Rules | None, faults: Faults | None) -> Motion:
    simulation = Simulation(scene, rules, faults)
    simulation.advance(scene.steps)
    return simulation.motion()


class Simulation:
    """A scene on its way, as a ``system`` of records, of which ``step_number`` steps are taken."""

    def __init__(
        self, scene: Scene, rules: Rules | None = None, faults: Faults | None = None
    ) -> None:
        rules = rules or Rules()
        scene = _mixed(scene, rules)
        self.scene, self.faults, self.step_number = scene, faults or Faults(), 0
        self.system = system_of(scene, rules, self.faults)
        self._stages = kernels.stages_of(scene, rules)
        starts = np.cumsum([0, *(segment.steps for segment in scene.segments)]).tolist()
        self._segments = dict(zip(starts, scene.segments, strict=False))
        self._setups = {0, *self._segments, *scene.setups}
        self._events = sorted({*self._setups, *self.faults.torsion_reversed_at})
        rows = scene.steps // scene.every + 1  # those of steps that are not taken use no memory
        self._samples = np.empty((rows, *self.system.state.shape))
        self._temperatures = np.empty((rows, len(self.system.state)))
        self._act()
        for _ in range(scene.setups.count(0)):
            self._set_up(again=True)
        self._samples[0], self._temperatures[0] = self.system.state, self.system.heat[:, 0]
        kernels.keep(self.system.state, self._stages, 0)

    @property
    def over(self) -> bool:
        """Return whether all steps are taken, or a look ended the run."""
        return self.step_number >= self.scene.steps or bool(self._stages.progress[2])

    def advance(self, steps: int) -> None:
        """Take so many steps, with the segments, setups and stages of the scene on the way."""
        end = min(self.step_number + steps, self.scene.steps)
        while self.step_number < end and not self.over:
            events = [at for at in self._events if at > self.step_number]
            self._take(min([*events, end]) - self.step_number)
            if not self.over:
                self._act()

    def _take(self, steps: int) -> None:
        samples = self.scene.every, self._samples, self._temperatures
        self.step_number += shielded(
            contacts.take_steps, self.system, self._stages, self.step_number, steps, *samples
        )

    def motion(self) -> Motion:
        """Return the samples so far; raise EngineNaNError where the motion is not finite."""
        taken = self.step_number // self.scene.every + 1
        samples, ends = self._samples[:taken], self._stages.rows[: self._stages.progress[1]].copy()
        if not all(np.isfinite(part).all() for part in (samples, self.system.state, ends)):
            raise EngineNaNError("reference: the motion is not finite (NaN)")
        time = np.arange(taken, dtype=np.float64) * (self.scene.every * self.scene.step)
        x, v, w, force, torque = (samples[:, :, part].copy() for part in range(PARTS))
        temperature = self._temperatures[:taken].copy() if self.system.rules["heats"] else None
        stages = ends if self.scene.stages else None
        return Motion(time, x, v, w, force, torque, temperature, stages)

    def _act(self) -> None:
        """Prescribe velocities, change hands and set forces up, where this step is one to."""
        number, state = self.step_number, self.system.state
        if number in self._segments:
            state[:, VELOCITY] = self._segments[number].velocities
            state[:, SPIN] = self._segments[number].angular_velocities
        if number in self.faults.torsion_reversed_at:
            self.system.contacts["springs"][:, 1:] *= -1.0
        if number in self._setups:
            self._set_up(again=number > 0)

    def _set_up(self, *, again: bool) -> None:
        """Compute forces by the velocities of the whole step, as codes do where a run begins."""
        if again and self.faults.springs_lost_in_setup:
            self.system.contacts["springs"][:, 0] = 0.0
        if again and self.faults.tsuji_again_in_setup:
            laws = self.system.laws
            laws["restitution"] = tsuji(laws["restitution"])
            dashpot = _tsuji_dashpot(laws["restitution"], self.faults)
            laws["dashpot"] = np.where(laws["tsuji"], dashpot, laws["dashpot"])
        self._take(0)
        unset = self.faults.later_setup_torque if self.step_number else self.faults.setup_torque
        self.system.state[0, TORQUE] += unset
        self.system.before[:] = self.system.state[:, FORCE:]


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

    ``quantities`` runs with a number of steps, which doubles from ``first`` until all errors are
    within the ``tolerance``, or to ``most``. A limit is Richardson's of first order, 2 y(h/2) -
    y(h); its error is the spread of the last three.
    """
    runs, steps = [dict(quantities(first))], first
    limits = {name: Limit(value, math.inf) for name, value in runs[0].items()}
    allowed = tolerance if isinstance(tolerance, Mapping) else dict.fromkeys(limits, tolerance)
    while 2 * steps <= most and any(not limits[n].error <= allowed[n] for n in limits):
        steps *= 2
        runs.append(dict(quantities(steps)))
        for name in limits:
            last = [2.0 * fine[name] - coarse[name] for coarse, fine in pairwise(runs[-4:])]
            error = max(last) - min(last) if len(last) > 2 else math.inf
            limits[name] = Limit(last[-1], error)
    return limits


# ---- a scene as records, for compiled code


def system_of(scene: Scene, rules: Rules, faults: Faults) -> System:
    """Return the records of a scene at its start, whose laws have one restitution and friction."""
    laws: dict[tuple[Law, bool], dict[str, Any]] = {}
    pairs = [_contact(scene, rules, faults, laws, i, j) for i, j in _partners(scene)]
    state = np.zeros((len(scene.bodies), PARTS, 3))
    for part, name in enumerate(("position", "velocity", "angular_velocity")):
        state[:, part] = [getattr(body, name) for body in scene.bodies]
    return System(
        rules=_records(RULES, [_rules(scene, rules, faults)])[0],
        laws=_records(LAW, [*laws.values()]),
        bodies=_records(BODY, [_body(scene, body, faults) for body in scene.bodies]),
        walls=_records(WALL, [_wall(wall) for wall in scene.walls]),
        contacts=_records(CONTACT, pairs),
        state=state,
        before=np.zeros((len(scene.bodies), 2, 3)),
        heat=np.array([(body.temperature, 0.0) for body in scene.bodies]),
        mdr_bodies=mdr.first_state(np.array([body.radius for body in scene.bodies])),
        sides=np.zeros((len(pairs), 2), dtype=mdr.SIDE),
        movers=np.array([b for b, body in enumerate(scene.bodies) if _moves(scene, body)]),
    )


def _mixed(scene: Scene, rules: Rules) -> Scene:
    """Return a scene whose laws have the restitution and friction of a pair, mixed by a code."""
    if not any(law.two_materials for law in scene.all_laws):
        return scene
    means = rules.restitution_mean, rules.friction_mean
    laws = tuple(row._replace(law=row.law.mixed(*means)) for row in scene.laws)
    return scene.model_copy(update={"law": scene.law.mixed(*means), "laws": laws})


def _moves(scene: Scene, body: Body) -> bool:
    return bool(scene.segments) or body.motion == "free" or any(body.velocity)


def _partners(scene: Scene) -> Iterator[tuple[int, int]]:
    """Yield the indices of bodies that may touch, and of bodies and walls (-1 - k)."""
    free = [bool(scene.segments) or body.motion == "free" for body in scene.bodies]
    count = len(free)
    every = [(i, j) for i in range(count) for j in range(i + 1, count)]
    pairs = every if scene.pairs is None else scene.pairs
    yield from ((i, j) for i, j in pairs if free[i] or free[j])
    for i in range(count):
        for k, wall in enumerate(scene.walls):
            if free[i] and (wall.bodies is None or i in wall.bodies):
                yield i, -1 - k


def _contact(
    scene: Scene, rules: Rules, faults: Faults, laws: dict[tuple[Law, bool], dict[str, Any]],
    i: int, j: int,
) -> dict[str, Any]:  # fmt: skip
    first, second = scene.bodies[i], scene.bodies[j] if j >= 0 else scene.walls[-1 - j]
    key = scene.law_of(first.type, second.type), j < 0
    laws.setdefault(key, _law(key[0], faults, wall=j < 0))
    has_mass = bool(scene.segments) or rules.frozen_mass == "own"
    masses = [body.mass for body in (first, second)
              if isinstance(body, Body) and (has_mass or body.motion != "frozen")]  # fmt: skip
    values = {"first": i, "second": j, "law": [*laws].index(key)}
    return {**_NO_CONTACT, **values, "mass": 1.0 / sum(1.0 / m for m in masses)}


_NO_CONTACT: dict[str, Any] = {
    "first": 0, "second": 0, "law": 0, "mass": 0.0, "radius": 0.0, "normal": (0.0,) * 3,
    "springs": ((0.0,) * 3,) * 3, "largest": 0.0, "slope": 0.0,
}  # fmt: skip


def _body(scene: Scene, body: Body, faults: Faults) -> dict[str, Any]:
    if faults.discs_turn_as_spheres:
        body = body.replace(inertia=None)
    free = not scene.segments and body.motion == "free"
    axes = [float(free and axis) for axis in body.axes]
    return {
        "radius": body.radius,
        "inverse_mass": [axis / body.mass for axis in axes],
        "inverse_inertia": free / body.moment_of_inertia,
        "gravity": [axis * g for axis, g in zip(axes, scene.gravity, strict=True)],
        "dragged": float(free),
        "heat_capacity": body.mass * body.heat_capacity,
    }


def _wall(wall: Wall) -> dict[str, Any]:
    codes = {name: value for name, value in _codes(wall).items() if name != "bodies"}
    return {**codes, "radius": (wall.radius or 0.0) * (-1.0 if wall.hollow else 1.0)}


def _rules(scene: Scene, rules: Rules, faults: Faults) -> dict[str, Any]:
    necks = {"longest_neck": math.inf if faults.longest_neck is None else faults.longest_neck}
    return {
        **_codes(rules),
        **{name: value for name, value in _codes(faults).items() if not name.endswith("_at")},
        **necks,
        "step": scene.step,
        "drag": scene.drag,
        "period": [length or 0.0 for length in scene.period],
        "heats": any(law.heat != "none" for law in scene.all_laws),
        "grows": any(law.normal == "mdr" for law in scene.all_laws),
    }


@lru_cache(maxsize=4096)
def _law(law: Law, faults: Faults, *, wall: bool) -> dict[str, Any]:
    where = ("all", "walls") if wall else ("all",)
    shear = law.moduli[1] if law.moduli else 0.0
    modulus = law.effective_modulus * (faults.wall_modulus_factor if wall else 1.0)
    shear *= faults.shear_factor * (faults.wall_shear_factor if wall else 1.0)
    mindlin, (p, q, s) = "mindlin" in law.tangential, DAMPING[law.damping].powers
    along = law.tangential_modulus or 8.0 * shear if mindlin else law.tangential_stiffness
    in_metres = faults.tangential_radius in where and "linear" in law.tangential
    pulls = law.normal in ("dmt", "jkr") and not faults.dmt_limit_without_pull_off
    return {
        **_codes(law),
        "stiffness": law.normal_stiffness or modulus,
        "dashpot": dashpot_coefficient(law, faults),
        "mass_power": p,
        "radius_power": q,
        "by_secant": bool(s),
        "tsuji": law.damping == "tsuji",
        "shear": along or 0.0,
        "shear_by_radius": mindlin or in_metres,
        "keeps_force": law.tangential.endswith("/force"),
        "rescaled": "rescale" in law.tangential,
        "projected": "classic" in law.tangential,
        "cut_by_radius": faults.cap_without_radius in where,
        "marshall_by_radius": mindlin and not faults.marshall_without_radius,
        "pull_loads": pulls,
        "rubs": (law.tangential, law.rolling, law.twisting) != ("none", "none", "none"),
        "yield_stress": law.yield_stress or 1e300,
        "by_slope": law.damping == "mdr",
    }


@lru_cache(maxsize=4096)
def _codes(parameters: Parameters) -> Mapping[str, Any]:
    """Return the values of fields as numbers: words by their place, None as 0."""
    codes = dict(parameters)
    for name, value in codes.items():
        if isinstance(value, str):
            codes[name] = kernels.words(type(parameters), name)[value]
        elif value is None:
            codes[name] = 0.0
    return codes


def _kind(row: Mapping[str, Any]) -> np.dtype[Any]:
    """Return the type of records with the values of a row."""
    arrays = {name: np.asarray(value) for name, value in row.items()}
    return np.dtype([(name, array.dtype, array.shape) for name, array in arrays.items()])


def _records(kind: np.dtype[Any], rows: list[dict[str, Any]]) -> NDArray[Any]:
    values = itemgetter(*kind.names or ())  # a record is filled by place
    return np.array([values(row) for row in rows], dtype=kind)


def tsuji(restitution: Number) -> Number:
    """Return alpha(e) [-], the polynomial fitted to Tsuji et al. (1992), of LAMMPS's manual."""
    value = 0.0 * restitution
    for coefficient in (4.8218, -18.022, 27.467, -22.348, 11.087, -4.2783, 1.2728):
        value = value * restitution + coefficient
    return value


def _tsuji_dashpot(restitution: Number, faults: Faults) -> Number:
    return tsuji(restitution) * (1.0 if faults.tsuji_effective_mass else math.sqrt(2.0))


def dashpot_coefficient(law: Law, faults: Faults) -> float:
    """Return the coefficient of a dashpot by formulas of its own, independent of the law's.

    One made for a restitution of hertz has sqrt(5) zeta (Antypov and Elliott, EPL 94, 50004
    (2011)).
    """
    if law.restitution is None:
        factor = 2.0 if law.damping == "damping_ratio" else 1.0
        return factor * (law.damping_coefficient or 0.0)
    if law.damping == "tsuji":
        return _tsuji_dashpot(law.restitution, faults)
    return damping_ratio(law.restitution) * (2.0 if law.normal == "hooke" else math.sqrt(5.0))


SMALLEST = Scene(bodies=(Body(radius=1.0, mass=1.0),), step=1.0, steps=1)  # for types of records
RULES = _kind(_rules(SMALLEST, Rules(), Faults()))
LAW = _kind(_law(Law(), Faults(), wall=False))
BODY = _kind(_body(SMALLEST, SMALLEST.bodies[0], Faults()))
WALL = _kind(_wall(Wall()))
CONTACT = _kind(_NO_CONTACT)


def compile_friction() -> None:
    """Compile the kernels of friction alone, which another process then finds in the cache."""
    falling = SMALLEST.replace(walls=(Wall(),), step=1e-4)
    system = system_of(falling, Rules(), Faults())
    contact, law, rules = system.contacts[0], system.laws[0], system.rules
    touch, press = Touch(ZERO, 0.0, 0.0, ZERO), Press(1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    slip = friction.find_slip(rules, False, touch, press, 1.0, (ZERO, ZERO, ZERO), 1.0)
    friction.tangential_force(contact, law, rules, touch, press, slip, 1.0)
    friction.rolling_torque(contact, law, rules, ZERO, press, slip, 1.0)
    friction.twisting_torque(contact, law, rules, ZERO, press, slip, 1.0)
