"""Known defects of codes: cause, releases, and the switch of the reference that reproduces them.

A run that fails, and passes against the reference with the switch, has the defect: it is counted,
never a pass. A run that passes although the switch would move it is free of the defect.
``inputs/known-defects.toml`` has the entries.

An entry may give a number by name where it depends on the scene: another coefficient of the scene's
law, or a value of :data:`VALUES`. The step at which a spring changes its sign, or a torque of
memory that was never set, cannot be known beforehand: it is taken from the first sample that shows
it, so that all others remain a test.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import translate
from functools import cache, partial
from itertools import combinations, product
from typing import Any, Literal, Self, get_args

import numpy as np
from pydantic import Field, model_validator

from harness.engines.output import release_of
from harness.errors import EngineNaNError, RequestError
from harness.model.base import Parameters, Vector
from harness.model.conventions import Faults, Rules
from harness.model.law import COEFFICIENTS, Law
from harness.model.scene import Motion, Scene
from harness.results.rows import Row

Motions = Mapping[Scene, Motion]
Patterns = tuple[str, ...]
NO_MOTION = (RequestError, EngineNaNError)  # of the reference with a switch
DETECTION_LIMIT = 1e-9  # [-] of the largest value: smaller differences show no unknown
WINDOWS = 3  # sample intervals with reversals that are fitted, one after the other


class KnownDefect(Parameters):
    """A defect: in which rows of which releases it acts, why, and what it makes of a run.

    ``laws`` and ``systems`` are patterns of the two parts of a setup "LAW, SYSTEM", ``variations``
    of a row's ``check``; * and ? match. Exactly one effect is given: fields of ``faults``,
    ``rules`` and ``law`` of the reference, a text where a value or coefficient of the scene is
    meant; the name of an unknown to ``fit``; an ``error``, part of the message with which the run
    ends; or the reason why the effect is ``undetermined``. Of such a one ``largest`` is the most by
    which it moves a value.
    """

    # fmt: off
    name: str = Field(description="[-]")
    engine: str = Field(description="[-]")
    cases: Patterns = Field(("*",), min_length=1, description="[-]")
    laws: Patterns = Field(("*",), min_length=1, description="[-]")
    systems: Patterns = Field(("*",), min_length=1, description="[-]")
    variations: Patterns = Field(
        ("",), min_length=1, description="[-] that it breaks; empty: the plain run, and all others")
    kind: Literal["defect", "documented limitation"] = Field("defect", description="[-]")
    cause: str = Field(min_length=20, description="[-]")
    since: str = Field("", description="[-] first release known to have it, empty for all")
    until: str = Field("", description="[-] last release known to have it, empty for all")
    command: str = Field(
        "", description="[-] option of the program that brings it; runs without it have it not")
    unless: str = Field(
        "", description="[-] option with which the program runs another style, without it")
    upstream: str = Field(min_length=5, description="[-] what its developers wrote of it")
    script: str = Field("", description="[-] file that shows it with the engine alone")
    faults: dict[str, Any] = Field({}, description="[-]")
    rules: dict[str, Any] = Field({}, description="[-]")
    law: dict[str, Any] = Field({}, description="[-]")
    fit: Literal["", "torsion_reversed_at", "setup_torque"] = Field("", description="[-]")
    error: str = Field("", description="[-]")
    undetermined: str = Field("", description="[-]")
    largest: float | None = Field(
        None, gt=1.0, description="[-] effect of an undetermined one over tolerances; any, if none")
    # fmt: on

    @model_validator(mode="after")
    def _check(self) -> Self:
        effects = [self.switched, bool(self.fit), bool(self.error), bool(self.undetermined)]
        if sum(effects) != 1:
            raise ValueError("needs one of faults, rules and law; fit; error; undetermined")
        if self.largest and not self.undetermined:
            raise ValueError("largest: goes with undetermined alone")
        Faults(**{k: v for k, v in self.faults.items() if not _is_computed(k, v)})
        Rules(**self.rules)
        for name, value in self.law.items():  # its other fields are those of the scene's law
            if name not in Law.model_fields:
                raise ValueError(f"law.{name}: must be one of {', '.join(Law.model_fields)}")
            named = [*VALUES, *COEFFICIENTS] if name in COEFFICIENTS else ["mixed_damping"]
            words = [*filter(None, get_args(Law.model_fields[name].annotation)), *named]
            if Law.model_fields[name].annotation is bool and not isinstance(value, bool):
                raise ValueError(f"law.{name} = {value!r}: must be true or false")
            if not (isinstance(value, int | float) or value in words):
                text = ", ".join(word for word in words if isinstance(word, str))
                raise ValueError(f"law.{name} = {value!r}: must be a number or one of {text}")
        return self

    @property
    def switched(self) -> bool:
        """Return whether the reference has a switch of it without an unknown."""
        return bool(self.faults or self.rules or self.law)

    @property
    def note(self) -> str:
        """Return its line in a report."""
        pointer = f"; {self.script} shows it" if self.script else ""
        word = "known defect" if self.kind == "defect" else self.kind
        option = f" with {self.command}" if self.command else ""
        note = f"{word} {self.name}{option}: {self.cause}; upstream: {self.upstream}{pointer}"
        if not self.undetermined:
            return note
        size = f" up to {self.largest:g} tolerances" if self.largest else ""
        hidden = f"whatever else may be wrong in this row{size} is hidden by it"
        return f"{self.undetermined}; {hidden}; {note}"

    def concerns(self, row: Row) -> bool:
        """Return whether it may act in a row: its case, setup, engine, check and version."""
        checks = ("*",) if "" in self.variations else self.variations
        return (
            row.engine == self.engine
            and _pattern(self.cases).match(row.case) is not None
            and _setup_pattern(self.laws, self.systems).match(row.setup) is not None
            and _pattern(checks).match(row.check) is not None
            and self.has_release(row.version)
        )

    def is_in_program(self, how: str) -> bool:
        """Return whether a program has it that was started with these options."""
        words = how.split()
        brought = not self.command or self.command.split()[-1] in words
        return brought and not (self.unless and self.unless.split()[-1] in words)

    def has_release(self, version: str) -> bool:
        """Return whether a version is of the releases that are known to have it."""
        release, last = release_of(version), release_of(self.until)
        if last and not release:
            return False  # a version without numbers is not known to have it
        return release >= release_of(self.since) and (not last or release[: len(last)] <= last)


def _is_computed(name: str, value: Any) -> bool:
    """Return whether a fault has a value that is computed in each scene, by its name."""
    field = Faults.model_fields.get(name)
    is_flag = field is not None and field.annotation is bool
    return isinstance(value, str) and value in VALUES and not is_flag


@dataclass(frozen=True)
class Trial:
    """A run of one or more scenes that is to be explained.

    ``holds`` returns whether all its rows pass against other motions of the reference. ``motion``
    is that of its only scene, None for several scenes, or without a motion of the run.
    """

    rules: Mapping[Scene, Rules]
    holds: Callable[[Motions], bool]
    motion: Motion | None = None

    def motions(self, defects: Sequence[KnownDefect] = (), **fitted: Any) -> Motions:
        """Return the motions of the reference with defects, the first of which prevail.

        ``fitted`` are more fields of ``faults``. Raise RequestError or EngineNaNError where the
        reference has no motion.
        """
        from harness.solvers import reference  # compiled: slow to import

        return {
            scene: reference.run(*_altered(scene, rules, defects, fitted))
            for scene, rules in self.rules.items()
        }

    def is_changed_by(self, defect: KnownDefect) -> bool:
        """Return whether the switch of a defect changes the reference of a scene."""
        return any(
            _altered(scene, rules, (defect,), {}) != (scene, rules, Faults())
            for scene, rules in self.rules.items()
        )

    def motion_with(self, defects: Sequence[KnownDefect], **fitted: Any) -> Motion | None:
        """Return :meth:`motions` of its only scene, None where there is none."""
        try:
            (motion,) = self.motions(defects, **fitted).values()
        except NO_MOTION:
            return None
        return motion

    def holds_with(self, defects: Sequence[KnownDefect], **fitted: Any) -> bool:
        """Return whether all rows pass with the switches of defects."""
        try:
            motions = self.motions(defects, **fitted)
        except NO_MOTION:
            return False
        return self.holds(motions)

    def passing_rules(self) -> list[str]:
        """Return the single conventions, as ``wall_lever = height``, under which it would pass."""
        ((scene, rules),) = self.rules.items()
        passing = []
        for name, field in Rules.model_fields.items():
            words = (True, False) if field.annotation is bool else get_args(field.annotation)
            for word in words:
                other = replace(self, rules={scene: rules.replace(**{name: word})})
                if word != getattr(rules, name) and other.holds_with(()):
                    passing.append(f"{name} = {word}")
        return passing


def explanation(defects: Sequence[KnownDefect], trial: Trial) -> tuple[KnownDefect, ...]:
    """Return the known defects of a failing run, none where they do not explain all its rows.

    Of defects that act together, those without which the run does not hold are returned.
    """
    switched = tuple(defect for defect in defects if defect.switched)
    groups: list[tuple[KnownDefect, ...]] = [(defect,) for defect in switched]
    if len(switched) > 1:
        groups += [switched, *(_without(switched, defect) for defect in switched)]
    for group in groups:
        if trial.holds_with(group):
            needed = tuple(d for d in group if not trial.holds_with(_without(group, d)))
            return needed or group[:1]
    fitted = [defect for defect in defects if defect.fit and trial.motion is not None]
    for defect, others in product(fitted, (switched, ()) if switched else ((),)):
        if holds_with := FITS[defect.fit](trial, others):
            return (defect, *(d for d in others if not holds_with(_without(others, d))))
    return ()


def error_defect(defects: Sequence[KnownDefect], message: str) -> KnownDefect | None:
    """Return the defect whose error is part of the message of a run that failed."""
    return next((d for d in defects if d.error and d.error in message), None)


@cache
def _setup_pattern(laws: Patterns, systems: Patterns) -> re.Pattern[str]:
    """Return the pattern of "LAW, SYSTEM"; any setup, also of one part, where both are free."""
    pairs = product(laws, systems)
    return _pattern(tuple("*" if pair == ("*", "*") else ", ".join(pair) for pair in pairs))


@cache
def _pattern(patterns: Patterns) -> re.Pattern[str]:
    return re.compile("|".join(map(translate, patterns)))


def _without(group: tuple[KnownDefect, ...], other: KnownDefect) -> tuple[KnownDefect, ...]:
    return tuple(defect for defect in group if defect is not other)


# ---- values by name. E* and G* are those of Johnson (1985), equations 4.3 and 7.43.


def _altered(
    scene: Scene, rules: Rules, defects: Sequence[KnownDefect], fitted: Mapping[str, Any]
) -> tuple[Scene, Rules, Faults]:
    """Return what the reference runs with the switches of defects."""
    law, changes = _switches("law", defects, scene), _switches("rules", defects, scene)
    faults = Faults(**_switches("faults", defects, scene), **fitted)
    return _with_law(scene, law) if law else scene, rules.replace(**changes), faults


def _switches(part: str, defects: Sequence[KnownDefect], scene: Scene) -> dict[str, Any]:
    """Return the fields of ``faults``, ``rules`` or ``law`` of defects in a scene."""
    return {
        name: _value_in(scene, name, value)
        for defect in reversed(defects)
        for name, value in getattr(defect, part).items()
    }


def _value_in(scene: Scene, field: str, value: Any) -> Any:
    """Return the value of a field in a scene, computed where it is given by name."""
    if not isinstance(value, str):
        return value
    if value in COEFFICIENTS and field in COEFFICIENTS:
        return getattr(_first_law(scene), value) or 0.0
    return VALUES[value](scene) if value in VALUES else value


def _with_law(scene: Scene, changes: Mapping[str, Any]) -> Scene:
    """Return a scene with another law, without the check that its steps resolve the contact."""
    laws = tuple(entry._replace(law=entry.law.replace(**changes)) for entry in scene.laws)
    return scene.model_copy(update={"law": scene.law.replace(**changes), "laws": laws})


def _first_law(scene: Scene) -> Law:
    """Return the law between the first two bodies, or the first body and wall."""
    types = [*(body.type for body in scene.bodies), *(wall.type for wall in scene.walls)]
    return scene.law_of(*types[:2]) if len(types) > 1 else scene.law


def _poisson_ratio(scene: Scene) -> float | None:
    """Return nu of the one material with E* and G* of both bodies, None without a material."""
    law = _first_law(scene)
    current = law.materials is not None and law.interface == "current"
    return (law.one_material.poisson_ratio or 0.0) if current else None


def normal_modulus_factor(scene: Scene) -> float:
    """Return E / (2 (1 - nu)) over E / (2 (1 - nu^2)) = 1 + nu [-], 1 without a material."""
    nu = _poisson_ratio(scene)
    return 1.0 if nu is None else 1.0 + nu


def shear_modulus_factor(scene: Scene) -> float:
    """Return E/4 (2 - nu) (1 + nu) over 8 E/4 / ((2 - nu) (1 + nu)) [-], 1 without a material."""
    nu = _poisson_ratio(scene)
    return 1.0 if nu is None else ((2.0 - nu) * (1.0 + nu)) ** 2 / 8.0


def mixed_shear_factor(scene: Scene) -> float:
    """Return the G* [-], over the right one, of two bodies with E = E* and the mixed nu."""
    law = _first_law(scene)
    if law.materials is None or law.moduli is None:
        return 1.0
    nu = math.sqrt(law.materials[0][1] * law.materials[1][1])
    return law.moduli[0] / (4.0 * (2.0 - nu) * (1.0 + nu)) / law.moduli[1]


def mixed_normal_stiffness(scene: Scene) -> float:
    """Return the geometric mean of 4/3 E* of both materials, each with itself, as N/m."""
    materials = _first_law(scene).materials or ((1.0, 0.0),)
    return math.prod(math.sqrt(2.0 / 3.0 * e / (1.0 - nu * nu)) for e, nu in materials)


def mixed_tangential_stiffness(scene: Scene) -> float:
    """Return the geometric mean of 8 G* of both materials, each with itself, as N/m."""
    materials = _first_law(scene).materials or ((1.0, 0.0),)
    return math.prod(math.sqrt(2.0 * e / ((2.0 - nu) * (1.0 + nu))) for e, nu in materials)


def mixed_damping(scene: Scene) -> str:
    """Return the dashpot that takes the coefficient of a dashpot of hertz: that of velocity."""
    damping = _first_law(scene).damping
    return "velocity" if damping in ("viscoelastic", "tsuji") else damping


def mixed_dashpot(scene: Scene) -> float | None:
    """Return the coefficient that this dashpot takes, as kg/s: alpha(e) of tsuji, else its own."""
    from harness.solvers.reference import tsuji  # compiled: slow to import

    law = _first_law(scene)
    return tsuji(law.restitution or 0.0) if law.damping == "tsuji" else law.damping_coefficient


def shear_along_x(scene: Scene) -> Vector:
    """Return the speed [m/s] of the surface of a cylinder that turns about z, along x."""
    turning = [-wall.spin[2] * (wall.radius or 0.0) for wall in scene.walls]
    return (next(filter(None, turning), 0.0), 0.0, 0.0)


def thin_skin(scene: Scene) -> float:
    """Return half of the longest neck of jkr between the smallest bodies [m].

    The neck at the largest tension of equal spheres is a^2 / (3 R*) with
    a^3 = 9 pi gamma R*^2 / (4 E*) at that tension (Johnson, Kendall and Roberts 1971).
    """
    law, radius = _first_law(scene), min(body.radius for body in scene.bodies)
    if law.normal != "jkr" or law.moduli is None:
        return 0.01 * radius
    cube = 9.0 * math.pi * (law.surface_energy or 0.0) * (0.5 * radius) ** 2 / (4.0 * law.moduli[0])
    return min(0.01 * radius, 0.5 * math.pow(cube, 2.0 / 3.0) / (1.5 * radius))


VALUES: Mapping[str, Callable[[Scene], Any]] = {
    function.__name__: function
    for function in (
        normal_modulus_factor, shear_modulus_factor, mixed_shear_factor, mixed_normal_stiffness,
        mixed_tangential_stiffness, mixed_damping, mixed_dashpot, shear_along_x, thin_skin,
    )
}  # fmt: skip


# ---- unknowns: the one of a defect in a run of one scene, with which it holds next to other
# defects. What is returned tells whether it holds next to some of them, None where it does not.

HoldsWith = Callable[[Sequence[KnownDefect]], bool]


def _fit_setup_torque(trial: Trial, others: Sequence[KnownDefect]) -> HoldsWith | None:
    """Take the torque of the setup [N m] from the first sample."""
    plain = trial.motion_with(others)
    if plain is None or trial.motion is None:
        return None
    torque = tuple((trial.motion.torque[0, 0] - plain.torque[0, 0]).tolist())
    holds_with = partial(trial.holds_with, setup_torque=torque)
    return holds_with if all(map(math.isfinite, torque)) and holds_with(others) else None


def _fit_reversals(trial: Trial, others: Sequence[KnownDefect]) -> HoldsWith | None:
    """Search the steps at which torsional springs change their sign.

    They are those of the interval before the first sample that differs, then of the next one.
    Where none fit and the motion is prescribed, each body may have a copy of the spring.
    """
    ((scene, _),), observed, plain = trial.rules.items(), trial.motion, trial.motion_with(others)
    if plain is None or observed is None:
        return None
    steps: tuple[int, ...] = ()
    sample = first_difference(scene, observed, plain)
    for _ in range(WINDOWS if sample < len(observed) else 0):
        agreed: dict[tuple[int, ...], int] = {}  # samples, by the steps of the trial
        for more in _reversals_before(sample, scene):
            run = trial.motion_with(others, torsion_reversed_at=(*steps, *more))
            if run is not None and trial.holds({scene: run}):
                return partial(trial.holds_with, torsion_reversed_at=(*steps, *more))
            if run is not None:
                agreed[*steps, *more] = first_difference(scene, observed, run)
        before, sample = sample, max(agreed.values(), default=0)
        if not before < sample < len(observed):
            break
        steps = max(agreed, key=agreed.__getitem__)
    has_copies = scene.segments and _holds_with_copies(trial, others)
    return partial(_holds_with_copies, trial) if has_copies else None


def _reversals_before(sample: int, scene: Scene) -> Iterator[tuple[int, ...]]:
    """Yield steps before a sample: one, or two where a contact goes to a neighbour and back."""
    window = range(max(1, (sample - 1) * scene.every), sample * scene.every)
    yield from combinations(window, 1)
    yield from combinations(window, 2)


def _holds_with_copies(trial: Trial, others: Sequence[KnownDefect]) -> bool:
    """Return whether each sample of each body is that of one of the copies of a spring.

    Of a contact over a boundary both sides compute one, without newton, and each side turns its
    copy round at a step of its own; where both bodies are on one side again, one copy remains. The
    others are fitted on the first sample of a body that is not of the first one.
    """
    (scene,), observed, plain = trial.rules, trial.motion, trial.motion_with(others)
    if plain is None or observed is None:
        return False
    copies = [plain]
    for body in range(len(scene.bodies)):
        sample = first_difference(scene, observed, plain, body)
        if sample < len(observed):
            reversals = _reversals_before(sample, scene)
            runs = (trial.motion_with(others, torsion_reversed_at=steps) for steps in reversals)
            solved = [run for run in runs if run is not None]
            copies.append(max(solved, key=lambda m: first_difference(scene, observed, m, body)))
    torques = np.stack([copy.torque for copy in copies])  # (copies, samples, bodies, 3)
    errors = np.abs(torques - observed.torque).max(axis=3)
    nearest = errors.argmin(axis=0)[None, :, :, None]
    torque = np.take_along_axis(torques, nearest, axis=0)[0]
    return trial.holds({scene: replace(plain, torque=torque)})


FITS: Mapping[str, Callable[[Trial, Sequence[KnownDefect]], HoldsWith | None]] = {
    "torsion_reversed_at": _fit_reversals,
    "setup_torque": _fit_setup_torque,
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
