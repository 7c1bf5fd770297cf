"""Contact cases: each law in each system, one check a quantity, at equal steps.

An engine runs a scene once. The reference takes the same steps by the engine's conventions, and
what differs is round-off, or a fault. That the reference converges to the law is a property of this
package, shown in its tests; the note of a row has the error of the step where a closed form exists.

Laws, systems and presets are tables, laws.toml and presets.toml. A law is a change of a case's
default parameters, and so is a system.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property, lru_cache, partial
from importlib.resources import files
from typing import Any, NamedTuple, TypeVar

import numpy as np

from harness.cases.base import LEVELS, Case, Check, Level, Value
from harness.cases.bench import Bench
from harness.cases.checks import equal_steps_check, equal_steps_tolerance, runs_at
from harness.cases.contacts.parameters import ContactSystem
from harness.engines.base import Engine, Job, Output, scene_job
from harness.engines.output import SERIES
from harness.engines.process import cores, parallel_map
from harness.engines.scenes import motion_in, moved_bodies, unknown_parts
from harness.errors import EngineNaNError, EngineOutputError, Unsupported
from harness.model.conventions import Rules
from harness.model.scene import Motion, Scene
from harness.report.content import Discs, Section
from harness.results.rows import Tolerance
from harness.solvers import reference

P = TypeVar("P", bound=ContactSystem)
Changes = Mapping[str, Any]

STEPS = 50  # of a contact, in checks
SAMPLES = 50  # at least, of a run that is held against the reference
QUICK_VARIATION = "defaults"  # of an engine, at level quick
MOTION = "motion"  # quantity of the rows on all samples of a run
PLAIN: Changes = {
    "normal": "hooke", "damping": "none", "tangential": "none", "rolling": "none",
    "twisting": "none", "clipped": False, "interface": "current",
}  # fmt: skip
USUAL_SYSTEMS = ("wall", "two spheres", "unequal spheres", "frozen sphere")
TWO_MATERIALS = ("two materials, stated", "two materials, mixed", "wall of another material")
# a code mixes restitution and friction of two bodies itself; bodies touch at no overlap
OF_FEW_LAWS = ("two spheres, mixed", "wall, at touch")
SLOW_SYSTEMS = ("unequal spheres", "frozen sphere", "two spheres, turned", *TWO_MATERIALS)
VARIED_SYSTEM = "two spheres"  # of an engine's variations below level full


@dataclass(eq=False)
class ContactCase(Case[P]):
    """A contact system in the laws and systems of its table.

    The docstring of ``parameters`` is the summary, and below it the expected values in words.
    ``units`` are those of an engine's script.
    """

    name: str
    parameters: type[P]  # type: ignore[misc]  # of an instance here, of a class in others
    units: str = ""

    def __post_init__(self) -> None:
        self.summary, _, formula = (self.parameters.__doc__ or "").partition("\n\n")
        self.formula = " ".join(formula.split())
        self.quantities = self.parameters.quantities
        self.group, self.presets, self.sources = "contacts", {}, {}
        for name, values in _read("presets.toml")[self.name].items():
            plain = {key: value for key, value in values.items() if key != "source"}
            self.presets[name] = self.parameters(**plain)
            if source := values.get("source"):
                self.sources[name] = source

    # ---- one run

    def scene(self, parameters: P) -> Scene:
        """Return the scene of a run, made once, with :data:`SAMPLES` or more."""
        return _sampled_scene(parameters)

    def job(self, parameters: P) -> Job:
        """Return the job of one run."""
        return self.job_of(self.scene(parameters))

    def job_of(self, scene: Scene, variation: str = "") -> Job:
        """Return the job of a scene in the units of the case, perhaps in a variation."""
        values = {"units": self.units, "variation": variation}
        return scene_job(scene, **{name: value for name, value in values.items() if value})

    def measure(self, parameters: P, output: Output) -> Mapping[str, float]:
        """Return the quantities of a run. Raise EngineOutputError for samples of no contact."""
        return observe(parameters, motion_in(output, self.scene(parameters)))

    def exact(self, parameters: P) -> Mapping[str, float]:
        """Return the quantities with a closed form."""
        return _exact(parameters)

    def names(self, parameters: P) -> list[str]:
        """Return the names of the quantities that a run with these parameters has."""
        absent = parameters.absent()
        return [each.name for each in self.quantities if each.name not in absent]

    def film_job(self, parameters: P, frames: int) -> Job:
        """Return the job of a run whose samples make a film of so many frames."""
        scene = self.scene(parameters)
        return self.job_of(scene.replace(every=max(1, scene.steps // max(1, frames))))

    def discs(self, parameters: P, output: Output) -> Discs:
        """Return the bodies in the plane of x and z, and a floor."""
        table, scene = output.tables[SERIES], self.scene(parameters)
        radii = np.array([body.radius for body in scene.bodies])
        x, z, margin = table["x_m"], table["z_m"], 2.0 * float(radii.max())
        start, end = float(x.min()) - margin, float(x.max()) + margin
        planes = [wall.point[2] for wall in scene.walls if wall.shape == "plane"]
        lines = np.array([[(start, height), (end, height)] for height in planes])
        return Discs(self.name, table["time_s"], x, z, radii, lines=lines.reshape(-1, 2, 2))

    # ---- verification

    @cached_property
    def trials(self) -> tuple[Trial, ...]:
        """Return each law in its systems."""
        return tuple(_trials(self))

    def checks(self, engine: Engine) -> Iterable[Check]:
        """Return the checks of an engine, of all levels."""
        return self.checks_up_to(engine, "full")

    def checks_up_to(self, engine: Engine, level: Level) -> Iterator[Check]:
        """Yield the checks of an engine of a level and shorter ones; no scene of others is made."""
        chosen = [trial for trial in self.trials if runs_at(trial.level, level)]
        parallel_map(lambda trial: trial.scene, chosen, cores())
        for trial in chosen:
            yield from trial.checks(engine)
        for trial in self.trials:
            varied = trial.varied
            if varied is None or not runs_at(varied, level):
                continue
            if engine.refuses(trial.job):
                if trial not in chosen:  # one row stands for its variations as well
                    yield from replace(trial, level=varied).checks(engine)
                continue
            for name, scene in engine.variations(trial.scene):
                later = varied == "quick" and name != QUICK_VARIATION
                shortest = "default" if later else varied
                if runs_at(shortest, level):
                    other = replace(trial, level=shortest, variation=name, varied_scene=scene)
                    yield from other.checks(engine)

    def notes(self, bench: Bench) -> Any:
        """Return how much conventions of the engine move runs."""
        from harness.cases.contacts import report

        return report.moved_by_conventions(self, bench)

    def sections(self, benches: Mapping[str, Bench]) -> Sequence[Section]:
        """Return the matrix of laws and systems for each engine, after the overview of all."""
        from harness.cases.contacts import report

        return report.sections(self, benches)


@dataclass(frozen=True, eq=False)
class Trial:
    """A law of a case in a system, perhaps in a variation of an engine, against the reference.

    ``changes`` are those of the default parameters of the case. ``level`` is the shortest that runs
    it, ``varied`` the shortest that runs an engine's variations of it, None for none.
    ``varied_scene`` is what the reference steps in a variation.
    """

    case: ContactCase[Any] = field(repr=False)
    law: str
    system: str
    changes: Changes
    level: Level
    varied: Level | None
    variation: str = ""
    varied_scene: Scene | None = None

    @cached_property
    def parameters(self) -> Any:
        """Return the parameters of a run."""
        return self.case.default.replace(**self.changes, steps_per_contact=STEPS)

    @property
    def setup(self) -> str:
        """Return the name of the setup of its checks."""
        return f"{self.law}, {self.system}"

    @cached_property
    def scene(self) -> Scene:
        """Return what the reference steps: the scene of the run, or that of a variation."""
        return self.varied_scene or self.case.scene(self.parameters)

    @cached_property
    def job(self) -> Job:
        """Return the job of the run."""
        return self.case.job_of(self.case.scene(self.parameters), self.variation)

    def checks(self, engine: Engine) -> Iterator[Check]:
        """Yield a check of each quantity; the first alone where the engine refuses the scene."""
        common: dict[str, Any] = {
            "setup": self.setup, "check": self.variation, "level": self.level, "jobs": (self.job,),
        }  # fmt: skip
        refused = bool(engine.refuses(self.job))
        exact = {} if self.variation or refused else self.case.exact(self.parameters)
        values, expected = partial(_values, self), partial(_expected_values, self)
        of_motion = partial(observe, self.parameters)
        for name in self.case.names(self.parameters)[: 1 if refused else None]:
            quantity = self.case.quantity(name)
            size = quantity.size(self.parameters)
            tolerance = partial(equal_steps_tolerance, of_motion, self.scene, name, size)
            yield equal_steps_check(
                quantity, values, expected, tolerance, exact=exact.get(name), **common
            )
        if refused:
            return
        common |= {"unit": "1", "expected": 0.0}
        yield Check(
            quantity=MOTION,
            measure=self._motion_difference,
            tolerance=self._motion_tolerance,
            **common,
        )

    def moved(self, bench: Bench, other: Rules) -> tuple[float, str]:
        """Return the largest change of a quantity from a bench's conventions to others.

        In parts of its scale, and the name of the quantity; by the reference.
        """
        case, p = self.case, self.parameters
        try:
            first = _expected_values(self, bench)
            second = self._values_by(other)
        except EngineNaNError:  # a run that the other rows report
            return 0.0, ""
        changes = {
            name: abs(first[name] - second[name]) / case.quantity(name).size(p)
            for name in case.names(p)
            if math.isfinite(first[name] - second[name])
        }
        name = max(changes, key=changes.__getitem__, default="")
        return changes.get(name, 0.0), name

    @lru_cache(maxsize=8192)  # noqa: B019 - of frozen objects, and codes share conventions
    def _values_by(self, rules: Rules) -> Mapping[str, float]:
        return observe(self.parameters, reference.run(self.scene, rules))

    def _motion_difference(self, bench: Bench) -> Value:
        motion, unwritten = bench.motion(self.job), bench.unwritten([self.job])
        if self.scene.segments and len(unknown_parts(self.scene, motion)) > 1:
            raise Unsupported(unwritten)  # what is left is prescribed
        difference = motion_difference(self.scene, motion, bench.reference(self.scene))
        return Value(difference, note=unwritten)

    def _motion_tolerance(self, bench: Bench) -> Tolerance:
        expected = bench.reference(self.scene)

        def differences(motion: Motion) -> Mapping[str, float]:
            return {MOTION: motion_difference(self.scene, motion, expected)}

        return equal_steps_tolerance(differences, self.scene, MOTION, 1.0, bench)


def _values(trial: Trial, bench: Bench) -> Mapping[str, float]:
    return observe(trial.parameters, bench.motion(trial.job))


def _expected_values(trial: Trial, bench: Bench) -> Mapping[str, float]:
    return observe(trial.parameters, bench.reference(trial.scene))


def observe(parameters: ContactSystem, motion: Motion) -> Mapping[str, float]:
    """Return the quantities of a motion. Raise EngineOutputError for samples of no contact."""
    try:
        with np.errstate(all="ignore"):  # a value that is not a number fails in its row
            return parameters.observe(motion)
    except (ArithmeticError, IndexError, ValueError) as error:
        raise EngineOutputError(f"the samples show no contact ({error})") from None


def motion_difference(scene: Scene, motion: Motion, other: Motion) -> float:
    """Return the largest difference of two motions of a scene [-], over all samples.

    Positions are over the longest path or the overlap at rest, velocities and r times angular
    velocities over the largest of both or the gain of gravity in a contact time, forces over the
    largest force, and torques over r times that, r the smallest radius. Forces on bodies that are
    not free may be unknown, and all forces or torques; NaN elsewhere makes the difference NaN.
    """
    r = min(body.radius for body in scene.bodies)
    moved = moved_bodies(scene)
    gravity, time = math.hypot(*scene.gravity), scene.step * STEPS
    length = _length(scene, other)
    rim = r * np.abs(other.angular_velocity).max()
    speed = max(np.abs(other.velocity).max(), rim, gravity * time) or 1.0
    force = np.abs(other.force[:, moved]).max() or 1.0
    differences = [
        np.abs(motion.position - other.position).max() / length,
        np.abs(motion.velocity - other.velocity).max() / speed,
        np.abs(motion.angular_velocity - other.angular_velocity).max() * r / speed,
    ]
    sizes, unknown = {"force": force, "torque": force * r}, unknown_parts(scene, motion)
    for name in sizes.keys() - unknown:
        difference = np.abs(getattr(motion, name) - getattr(other, name))[:, moved]
        differences.append(difference.max() / sizes[name])
    if motion.temperature is not None and other.temperature is not None:
        warmed = np.ptp(other.temperature) or 1.0
        differences.append(np.abs(motion.temperature - other.temperature).max() / warmed)
    return float(np.max(differences))


def _length(scene: Scene, motion: Motion) -> float:
    """Return the longest path or the overlap at rest [m], the smallest radius where both are 0."""
    path = np.abs(motion.position - motion.position[0]).max()
    overlap = math.hypot(*scene.gravity) * (scene.step * STEPS / math.pi) ** 2
    return float(max(path, overlap)) or min(body.radius for body in scene.bodies)


@lru_cache(maxsize=4096)
def _sampled_scene(parameters: ContactSystem) -> Scene:
    """Return the scene with :data:`SAMPLES` or more, which changes no quantity."""
    scene = parameters.scene()
    if scene.segments or scene.steps // scene.every >= SAMPLES:
        return scene
    most = max(scene.steps // SAMPLES, 1)
    every = next(n for n in range(most, 0, -1) if scene.every % n == 0)
    return scene.model_copy(update={"every": every})  # a divisor needs no check


@lru_cache(maxsize=4096)
def _exact(parameters: ContactSystem) -> Mapping[str, float]:
    return parameters.exact()


# ---- tables of laws and systems


class _Law(NamedTuple):
    """Changes of parameters, systems (all unless given), and a row of laws.toml's options."""

    changes: Changes
    systems: Sequence[str]
    quick: bool
    two_materials: bool

    def goes_with(self, system: str) -> bool:
        if system in TWO_MATERIALS:
            return self.two_materials
        return system in self.systems or (not self.systems and system not in OF_FEW_LAWS)


def law_part(name: str) -> Changes:
    """Return the coefficients of a part of a law."""
    coefficients: Changes = _read("laws.toml")["parts"][name]
    return coefficients


def _trials(case: ContactCase[Any]) -> Iterator[Trial]:
    """Yield each law of a case in each of its systems."""
    table, named = _read("laws.toml")["cases"][case.name], _read("laws.toml")["systems"]
    laws = _laws(table["laws"])
    if isinstance(table["laws"], dict):
        laws = {name: law._replace(systems=table["laws"][name]) for name, law in laws.items()}
    systems = table.get("systems", USUAL_SYSTEMS)
    systems = systems if isinstance(systems, dict) else {name: {} for name in systems}
    varied = {law: level for level in reversed(LEVELS) for law in _laws(table.get(level, ()))}
    turn = 0  # of the laws of level quick in the systems
    for name, law in laws.items():
        chosen = [system for system in systems if law.goes_with(system)]
        quick = _quick_systems(table, name, law, chosen, turn) if law.quick else set()
        turn += law.quick
        for system in chosen:
            changes = {**PLAIN, **law.changes, **named.get(system, {}), **systems[system]}
            level: Level = "quick" if system in quick else "default"
            variations = varied.get(name)
            if variations and system != VARIED_SYSTEM:
                variations = "full"
            yield Trial(case, name, system, changes, level, variations)


def _quick_systems(
    table: Mapping[str, Any], name: str, law: _Law, systems: Sequence[str], turn: int
) -> set[str]:
    """Return the systems of a law at level quick.

    The laws take turns in the systems that are not slow; those of earlier interfaces go through all
    of them, as their walls and pairs share no code.
    """
    fast = [system for system in systems if system not in SLOW_SYSTEMS]
    if law.changes.get("interface") == "old":
        return set(fast)
    chosen = {system for system in fast if system in table.get("always", ())}
    if turns := [system for system in fast if system not in chosen]:
        chosen.add(turns[turn % len(turns)])
    if name == table.get("two_materials_law"):
        chosen |= {system for system in systems if system.startswith("two materials")}
    return chosen


def _laws(names: Iterable[str]) -> dict[str, _Law]:
    """Return laws by the names of groups and of laws, in this order."""
    chosen: dict[str, _Law] = {}
    for name in names:
        group = _groups().get(name)
        # of two groups with a law of this name, the first
        chosen |= group or {name: next(g[name] for g in _groups().values() if name in g)}
    return chosen


@cache
def _groups() -> dict[str, dict[str, _Law]]:
    groups: dict[str, dict[str, _Law]] = {}
    for name, group in _read("laws.toml").items():
        if name not in ("parts", "systems", "cases"):
            systems, quick = group.get("systems", ()), group.get("quick", True)
            groups[name] = {}
            for law, parts in group["laws"].items():
                rows = [law_part(each) if isinstance(each, str) else each for each in parts]
                changes = {key: value for row in rows for key, value in row.items()}
                both = law in group.get("two_materials", ())
                groups[name][law] = _Law(changes, systems, quick, both)
    return groups


@cache
def _read(name: str) -> dict[str, Any]:
    return tomllib.loads((files(__package__) / name).read_text("utf-8"))
