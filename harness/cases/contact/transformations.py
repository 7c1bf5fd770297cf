"""Transformations of a run that may change nothing: turned, mirrored, restarted, over ranks ...

A transformation makes a scene of a scene, and gives a motion of the second back as one of the
first: by the symmetries of mechanics, and of every contact law, both are the same. Each says what
may differ: nothing, round-off, or round-off whose size is known (that of mdr's force, of one
impact).

Frames, numbers and units are changed in the scene, whatever the engine; what an engine does with
ranks, lists and restarts it declares itself. Walls of earlier interfaces are turned like the
others: as regions, and by an exchange of axes as coordinate planes.

Reversed in time are elastic contacts without friction only: dashpots, sliding, and the attraction
of JKR, which begins and ends at different overlaps, dissipate, and a tangential spring slides as it
parts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import starmap
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.contact.motion import Array, Motion, job_of
from harness.cases.contact.parameters import ContactSystem
from harness.cases.contact.submodels import Submodel, Trial
from harness.cases.contract import LevelName
from harness.cases.verification import Study, places
from harness.engines.contract import Engine, Job, Variation
from harness.errors import EngineError
from harness.parameters.law import ContactLaw
from harness.parameters.scene import ZERO, Body, ContactScene, Plane, Segment, Vector
from harness.parameters.submodels import DIMENSIONS

if TYPE_CHECKING:
    from harness.cases.contact.contact_case import ContactCase


WIDEST = 1e-6
"""Of the sizes: a limit's width; what moves a run by more hides what an invariance is to show."""


def has_width(scene: ContactScene) -> bool:
    """Return whether round-off of mdr's force is known: of one contact that does not stick."""
    single_contact = len(scene.bodies) + len(scene.planes) == 2
    return single_contact and not scene.segments and not scene.law.surface_energy


def why_not(scene: ContactScene, width: float) -> str:
    """Return why an invariance that rounds is not judged, or nothing.

    ``width`` is what its force's round-off may move, of the sizes.
    """
    if scene.law.normal != "mdr":
        return ""
    if not has_width(scene):
        return (
            "its force loses digits as an overlap shrinks: what that leaves is known of a single "
            "contact, without adhesion"
        )
    if not width <= WIDEST:
        return (
            f"its force loses digits as an overlap shrinks: that may move it by {width:.2g}, more "
            f"than {WIDEST:g}"
        )
    return ""


Axes = tuple[Vector, Vector, Vector]

SAME: Axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class View:
    """Axes and a velocity [m/s]: what was at x is at M x + t v, M orthogonal.

    Angular velocities and torques are axial: a mirror turns their sign.
    """

    matrix: Axes = SAME
    velocity: Vector = ZERO

    def scene(self, scene: ContactScene) -> ContactScene:
        """Return a scene as it is seen."""
        return replace(
            scene,
            bodies=tuple(map(self._body, scene.bodies)),
            planes=tuple(map(self._plane, scene.planes)),
            gravity=self._polar(scene.gravity),
            segments=tuple(map(self._segment, scene.segments)),
        )

    def back(self, motion: Motion) -> Motion:
        """Return the motion of the scene that was looked at."""
        m = np.array(self.matrix)
        sign = np.linalg.det(m).round()
        v = np.array(self.velocity)
        return Motion(
            motion.time,
            (motion.position - motion.time[:, None, None] * v) @ m,
            (motion.velocity - v) @ m,
            sign * motion.omega @ m,
            motion.force @ m,
            sign * motion.torque @ m,
        )

    def _body(self, body: Body) -> Body:
        return replace(
            body,
            position=self._polar(body.position),
            velocity=self._seen(body.velocity),
            omega=self._axial(body.omega),
        )

    def _plane(self, plane: Plane) -> Plane:
        return Plane(
            self._polar(plane.point), self._polar(plane.normal), self._seen(plane.velocity)
        )

    def _segment(self, piece: Segment) -> Segment:
        return Segment(
            piece.steps,
            tuple(map(self._seen, piece.velocities)),
            tuple(map(self._axial, piece.omegas)),
        )

    def _polar(self, vector: tuple[float, ...]) -> Vector:
        return _vector(np.array(self.matrix) @ vector)

    def _seen(self, velocity: Vector) -> Vector:
        return _vector(np.array(self._polar(velocity)) + self.velocity)

    def _axial(self, vector: Vector) -> Vector:
        return _vector(np.linalg.det(self.matrix).round() * np.array(self._polar(vector)))


@dataclass(frozen=True)
class Units:
    """Units of length, mass and time: the numbers of a scene in them, as if they were SI's."""

    length: float
    mass: float
    time: float

    def scene(self, scene: ContactScene) -> ContactScene:
        """Return a scene in these units."""
        x, v, w = self._factors()[:3]
        return replace(
            scene,
            bodies=tuple(
                replace(
                    body,
                    radius=body.radius * x,
                    mass=body.mass * self.mass,
                    position=scaled(body.position, x),
                    velocity=scaled(body.velocity, v),
                    omega=scaled(body.omega, w),
                )
                for body in scene.bodies
            ),
            planes=tuple(
                Plane(scaled(plane.point, x), plane.normal, scaled(plane.velocity, v))
                for plane in scene.planes
            ),
            law=self._law(scene.law),
            step=scene.step * self.time,
            gravity=scaled(scene.gravity, v / self.time),
            segments=tuple(
                Segment(
                    piece.steps,
                    tuple(scaled(velocity, v) for velocity in piece.velocities),
                    tuple(scaled(omega, w) for omega in piece.omegas),
                )
                for piece in scene.segments
            ),
        )

    def back(self, motion: Motion) -> Motion:
        """Return a motion in these units in SI units."""
        parts = (motion.position, motion.velocity, motion.omega, motion.force, motion.torque)
        scaled = starmap(np.divide, zip(parts, self._factors(), strict=True))
        return Motion(motion.time / self.time, *scaled)

    def _factors(self) -> tuple[float, ...]:
        """Return those of positions, velocities, angular velocities, forces and torques."""
        x, m, t = self.length, self.mass, self.time
        return (x, x / t, 1.0 / t, m * x / t / t, m * x * x / t / t)

    def _law(self, law: ContactLaw) -> ContactLaw:
        dimensions = {**DIMENSIONS, "damping_coefficient": law.dashpot.dimensions}
        values = law.model_dump(exclude_none=True)
        units = np.array([self.length, self.mass, self.time])
        for name in values.keys() & dimensions.keys():
            values[name] *= float(np.prod(units ** np.array(dimensions[name], dtype=float)))
        return ContactLaw(**values)


class Renumbered:
    """The bodies in the other order."""

    def scene(self, scene: ContactScene) -> ContactScene:
        """Return a scene with the last body first."""
        segments = tuple(
            Segment(piece.steps, piece.velocities[::-1], piece.omegas[::-1])
            for piece in scene.segments
        )
        law = _exchanged(scene.law)
        return replace(scene, bodies=scene.bodies[::-1], law=law, segments=segments)

    def back(self, motion: Motion) -> Motion:
        """Return a motion in the first order."""
        return Motion(motion.time, *(getattr(motion, name)[:, ::-1] for name in PARTS))


def _exchanged(law: ContactLaw) -> ContactLaw:
    if not (law.two_materials and law.materials):
        return law
    (young, poisson), (other, its) = law.materials
    return law.replace(
        youngs_modulus=other,
        poisson_ratio=its,
        partner_youngs_modulus=young,
        partner_poisson_ratio=poisson,
    )


PARTS = ("position", "velocity", "omega", "force", "torque")


def turned_back(scene: ContactScene, motion: Motion) -> ContactScene:
    """Return the scene that begins where a motion ends, with all velocities reversed."""
    bodies = tuple(
        replace(
            body,
            position=_vector(motion.position[-1, index]),
            velocity=_vector(-motion.velocity[-1, index]),
            omega=_vector(-motion.omega[-1, index]),
        )
        for index, body in enumerate(scene.bodies)
    )
    return replace(scene, bodies=bodies)


def run_backwards(motion: Motion) -> Motion:
    """Return a motion as it is in the film that is run backwards."""
    return Motion(
        motion.time[-1] - motion.time[::-1],
        motion.position[::-1],
        -motion.velocity[::-1],
        -motion.omega[::-1],
        motion.force[::-1],
        motion.torque[::-1],
    )


def scaled(vector: tuple[float, ...], factor: float) -> Vector:
    """Return a vector times a factor."""
    return (vector[0] * factor, vector[1] * factor, vector[2] * factor)


def axes_about(up: Vector) -> Axes:
    """Return the matrix of a rotation that brings z to a direction."""
    z = np.array(up) / np.linalg.norm(up)
    x = np.cross(z, (0.8, -0.5, 0.33))
    x /= np.linalg.norm(x)
    a, b, c = map(_vector, np.column_stack([x, np.cross(z, x), z]))
    return (a, b, c)


def _vector(parts: Array) -> Vector:
    x, y, z = (float(part) for part in parts)
    return (x, y, z)


SYSTEMS: Mapping[LevelName, tuple[str, ...]] = {
    "quick": ("wall", "wall, spins"),
    "default": ("wall", "unequal spheres", "wall, spins", "frozen sphere, spins"),
}
"""Systems whose invariances a level goes through, of submodels that a case names; level full goes
through all of both."""

EQUAL = "two spheres"

QUICK = ("turned", "continued with a setup", "restarted")
"""Invariances of the shortest level, beside the run as it stands; of few pairs that are carried all
that an engine declares for these."""

STEPS = 20
"""Of a contact: what holds exactly needs no fine step."""

SAMPLES = 12
PLAIN = ""
MOVED = "moved"
STEPPED = "sampled at every step"
ROUNDINGS = 4.0

ROUNDED = (
    f"each step rounds positions and velocities, {ROUNDINGS:g} times at most: eps times coordinate "
    "over overlap, and eps times speed in the frame over that in the contact; times the steps"
)

UP = (0.48, 0.6, 0.64)
"""What z is turned to: across all axes."""

TURNED = axes_about(UP)
MIRRORED = (scaled(TURNED[0], -1.0), TURNED[1], TURNED[2])
EXCHANGED = ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))

DIRECTION, WAY = (0.6, -0.48, 0.64), 5.0
"""Of a moving frame, and how far it goes in a run, in radii: spheres cross boundaries in turn."""

SLANTED = (0.35, -0.88, 0.32)
"""What z is turned to for a pair that is carried: less than a bin of LAMMPS's apart along z, and in
another order along y. Codes that sort by bins have now one of them first, now the other."""

CARRIED, FAR, MANY = "carried", 20.0, 4200
"""A pair carried along z by so many radii in so many steps, or some more: six pieces of a
prescribed motion, in each of the last two of which LAMMPS sorts once by default."""

SMALLER = Units(2.0**-12, 2.0**-36, 2.0**-12)
"""4096 times smaller, of the same density, modulus and speed: powers of two round nothing."""


@dataclass(frozen=True)
class TransformedRun:
    """A run of a trial that must change nothing: scene, job, and the run it is compared with.

    ``back`` gives the motion in the frame of the case. ``drift`` [m/s] and ``reach`` [m] are what
    the run adds to speeds and coordinates; where it is ``exact`` not one bit may change. One that
    is not ``judged`` only serves to compare another with.
    """

    name: str
    scene: ContactScene
    job: Job
    back: Callable[[Motion], Motion] = lambda motion: motion
    against: str = PLAIN
    why: str = ROUNDED
    exact: bool = False
    drift: float = 0.0
    reach: float = 0.0
    ranks: int = 1
    judged: bool = True


@dataclass
class TrialRuns:
    """The runs of one trial, and the motion of each, or why there is none."""

    case: ContactCase[Any]
    trial: Trial
    runs: dict[str, TransformedRun]
    motions: dict[str, Motion | EngineError | str] = field(default_factory=dict)

    def motion(self, name: str) -> Motion | None:
        """Return the motion of a run, None where it did not run."""
        motion = self.motions.get(name)
        return motion if isinstance(motion, Motion) else None


def chosen(case: ContactCase[Any], level: LevelName) -> Iterator[Trial]:
    """Yield the trials of a case whose invariances a level goes through."""
    if not case.has_invariances:
        return
    systems = {submodel.name: _systems(submodel, level) for submodel in case.invariant}
    for trial in case.trials("full"):  # the shortest level has not all systems of a submodel
        here = trial.system in systems.get(trial.submodel, ())
        if level == "full" or here or _is_carried(case, trial, level):
            yield replace(trial, parameters=trial.parameters.replace(steps_per_contact=STEPS))


def selected(case: ContactCase[Any], trials: Iterable[Trial], study: Study) -> Iterator[Trial]:
    """Yield the trials that a study asks for: by their place, or by a row that they leave."""
    return (trial for trial in trials if study.selects(*labels(case, trial)))


def labels(case: ContactCase[Any], trial: Trial) -> Iterator[str]:
    """Yield what a pattern may call a trial: its place, its quantities, its rows."""
    yield from places(case.name, trial.submodel, trial.system)
    for quantity in case.quantities:
        yield quantity.name
        yield f"{case.name}, {trial.system}: {trial.submodel}: {quantity.name}"


def _is_carried(case: ContactCase[Any], trial: Trial, level: LevelName) -> bool:
    """Return whether a level takes the spheres of a trial through the room: the shortest few."""
    if level == "quick":
        return trial.system == EQUAL and trial.submodel in case.by_defaults
    return not case.scene(trial.parameters).planes and trial.parameters.normal != "mdr"


def _systems(submodel: Submodel, level: LevelName) -> Sequence[str]:
    """Return the systems of a level; where it is stated for equal spheres alone, these."""
    if level == "full" or (level == "quick" and not submodel.quick):
        return ()
    of_submodel = submodel.systems or SYSTEMS[level]
    unequal = "unequal spheres"
    return [
        EQUAL if name == unequal and unequal not in of_submodel else name for name in SYSTEMS[level]
    ]


def first_runs(case: ContactCase[Any], trial: Trial, level: LevelName) -> TrialRuns:
    """Return the scene as it stands, and other views of it."""
    scene = _sampled(case.scene(trial.parameters))
    seen = [view for view in _views(scene, trial) if level != "quick" or view.name in QUICK]
    if scene.law.normal == "mdr" and has_width(scene):
        seen.append(_run_of(STEPPED, replace(scene, every=1), trial, judged=False))
    if _is_carried(case, trial, level):
        seen.append(_carried(case, trial, scene.steps))
    return TrialRuns(case, trial, {run.name: run for run in (_run_of(PLAIN, scene, trial), *seen)})


def _carried(case: ContactCase[Any], trial: Trial, steps: int) -> TransformedRun:
    """Return a run of a pair through the room in many steps, of which it has ``steps``."""
    finer = trial.parameters.steps_per_contact * math.ceil(MANY / steps)
    scene = _sampled(case.scene(trial.parameters.replace(steps_per_contact=finer)))
    speed = FAR * trial.parameters.radius / scene.duration
    view = View(axes_about(SLANTED), (0.0, 0.0, speed))
    return _run_of(CARRIED, scene, trial, view, drift=speed, judged=False)


def _views(scene: ContactScene, trial: Trial) -> Iterator[TransformedRun]:
    """Yield a scene turned, mirrored, moved, in other units, renumbered, its axes exchanged."""
    turned, mirrored = View(TURNED), View(MIRRORED)
    speed = WAY * trial.parameters.radius / scene.duration
    moved = View(TURNED, scaled(DIRECTION, speed))
    yield _run_of("turned", scene, trial, turned)
    yield _run_of("mirrored", scene, trial, mirrored, against="turned")
    yield _run_of(MOVED, scene, trial, moved, against="turned", drift=speed)
    yield _run_of("in other units", scene, trial, SMALLER)
    if scene.planes:
        yield _run_of("axes exchanged", scene, trial, View(EXCHANGED))
    if len(scene.bodies) > 1:
        yield _run_of("renumbered", scene, trial, Renumbered())


def later_runs(runs: TrialRuns, engine: Engine, level: LevelName) -> Iterator[TransformedRun]:
    """Yield the runs that need a motion: back in time, and what the engine declares."""
    plain, motion = runs.runs[PLAIN], runs.motion(PLAIN)
    if motion is None:
        return
    if level != "quick" and _reversible(runs.trial.parameters, plain.scene):
        back = _run_of("reversed in time", turned_back(plain.scene, motion), runs.trial)
        yield replace(back, back=run_backwards)
    # spheres alone are seen from a moving frame, in which they cross boundaries
    alone = not plain.scene.planes
    for name, carried in ((MOVED if alone else PLAIN, False), (CARRIED if alone else PLAIN, True)):
        carrier, there = runs.runs.get(name), runs.motion(name)
        if carrier is None or there is None or (carried and level == "quick" and not alone):
            continue
        ends = there.position[[0, -1]].mean(axis=1)
        for variation in engine.variations(carrier.job, ends.tolist()):
            if variation.carried is carried and (
                carried or level != "quick" or variation.name in QUICK
            ):
                few = level == "full" or runs.trial.submodel in runs.case.over_ranks
                yield replace(_varied(carrier, variation), judged=variation.everywhere or few)


def _reversible(law: ContactSystem, scene: ContactScene) -> bool:
    """Return whether a contact runs backwards as it ran; jkr and mdr remember the way."""
    parts = {law.damping, law.tangential, law.rolling, law.twisting}
    return parts == {"none"} and law.normal not in {"jkr", "mdr"} and not scene.segments


def _run_of(
    name: str, scene: ContactScene, trial: Trial, view: Any = None, **more: Any
) -> TransformedRun:
    seen = scene if view is None else view.scene(scene)
    back = {} if view is None else {"back": view.back}
    parameters = trial.parameters
    job = job_of(seen, parameters.interface, parameters.materials_as)
    return TransformedRun(name, seen, job, **back, **more)


def _varied(carrier: TransformedRun, variation: Variation) -> TransformedRun:
    """Return a run with the values of a variation of the engine."""
    job = replace(carrier.job, values={**carrier.job.values, **variation.values})
    return replace(
        carrier,
        name=variation.name,
        job=job,
        against=variation.against or carrier.name,
        why=variation.why if variation.exact else f"{variation.why}; {ROUNDED}",
        exact=variation.exact,
        reach=variation.reach,
        ranks=variation.ranks,
    )


def _sampled(scene: ContactScene) -> ContactScene:
    """Return a scene sampled evenly, or with one piece of prescribed motion as two."""
    if scene.segments:
        if len(scene.segments) > 1:
            return scene
        (piece,) = scene.segments
        half = piece.steps // 2
        halves = replace(piece, steps=half), replace(piece, steps=piece.steps - half)
        return replace(scene, segments=halves)
    every = max(2, scene.steps // SAMPLES)
    return replace(scene, every=every, steps=every * math.ceil(scene.steps / every))
