"""The base of contact cases: each law in each system, one check a quantity, at equal steps.

An engine runs a scene once. The reference takes the same steps by the engine's conventions, and
what differs is round-off, or a fault. That the reference converges to the law is a property of this
package, shown in its tests; the note of a row has the error of the step where a closed form exists.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, partial
from typing import Any, ClassVar, TypeVar, cast

import numpy as np

from harness.cases.base import Case, Check, Level, Quantity, Value
from harness.cases.bench import Bench
from harness.cases.checks import runs_at
from harness.cases.contacts import tables
from harness.cases.contacts.differences import STEPS, motion_difference
from harness.cases.contacts.parameters import ContactSystem
from harness.cases.equal_steps import REASON, ROUND_OFF
from harness.engines.base import Engine, Job, Output, scene_job
from harness.engines.output import SERIES
from harness.engines.scene_tables import motion_in
from harness.errors import EngineNaNError, EngineOutputError
from harness.model.conventions import Rules
from harness.model.motion import Motion
from harness.model.scene import Scene
from harness.report.content import Discs, Drawing, Section
from harness.results.rows import Kind, Tolerance
from harness.solvers import reference

P = TypeVar("P", bound=ContactSystem)

QUICK_VARIATION = "defaults"  # of an engine, at level quick
VARIED_SYSTEM = "two spheres"  # of variations below level full
MOTION = "motion"  # quantity of the rows on all samples of a run
MOVED = "moved_by_conventions"  # quantity of the findings on an engine's conventions
SAMPLES = 50  # at least, of a run that is held against the reference


@dataclass(frozen=True)
class Trial:
    """A law of a case in a system, and the shortest level that runs it."""

    case: ContactCase[Any] = field(repr=False)
    law: str
    system: str
    level: Level

    @cached_property
    def parameters(self) -> Any:
        """Return the parameters of a run."""
        case = self.case
        changes = {**tables.PLAIN, **case.laws[self.law].law, **case.systems[self.system]}
        return case.default.replace(**changes, steps_per_contact=STEPS)

    @property
    def setup(self) -> str:
        """Return the name of the setup of its checks."""
        return f"{self.law}, {self.system}"

    @property
    def comparison(self) -> Comparison:
        """Return the run as the engine does it by itself, against the reference."""
        return Comparison(self.case, self.parameters, self.case.sampled_scene(self.parameters))


class ContactCase(Case[P]):
    """A scene, the quantities of its motion, and closed forms; laws and systems are tables.

    ``formula`` states what is expected. ``laws`` and ``systems`` change the default parameters.
    """

    group: ClassVar[str] = "contacts"
    formula: ClassVar[str]
    parameters: ClassVar[type[ContactSystem]]
    laws: ClassVar[tables.Laws]
    systems: ClassVar[Mapping[str, tables.Changes]] = tables.SYSTEMS
    units: ClassVar[str] = "si"
    two_materials_law: ClassVar[str] = ""  # runs in pairs of two materials at level quick, too
    always: ClassVar[Sequence[str]] = ()  # systems in which level quick runs each law
    varied: ClassVar[Sequence[str]] = ()  # laws with variations of an engine at level full
    varied_by_default: ClassVar[Sequence[str]] = ()  # one of each kind of memory
    varied_in_quick: ClassVar[Sequence[str]] = ()

    def __init__(self) -> None:
        kind, presets = cast("type[P]", self.parameters), tables.presets(self.name)
        sources = {name: values.pop("source", "") for name, values in presets.items()}
        self.presets = {name: kind(**values) for name, values in presets.items()}
        type(self).sources = {name: source for name, source in sources.items() if source}
        self.listed: dict[str, Level] = {}  # the level of the last list of checks, by engine

    # ---- one run

    @abstractmethod
    def build(self, parameters: P) -> Scene:
        """Return the scene. Raise RequestError for parameters that cannot be run."""

    def scene(self, parameters: P) -> Scene:
        """Return the scene of a run, made once."""
        return _scene(self, parameters)

    def sampled_scene(self, parameters: P) -> Scene:
        """Return the scene with :data:`SAMPLES` or more, which changes no quantity."""
        return _sampled_scene(self, parameters)

    @abstractmethod
    def observe(self, parameters: P, motion: Motion) -> Mapping[str, float]:
        """Return the quantities of a motion."""

    def job(self, parameters: P) -> Job:
        """Return the job of one run."""
        return self.job_of(self.scene(parameters))

    def job_of(self, scene: Scene, variation: str = "") -> Job:
        """Return the job of a scene in the units of the case, perhaps in a variation."""
        values = {"units": "" if self.units == "si" else self.units, "variation": variation}
        return scene_job(scene, **{name: value for name, value in values.items() if value})

    def measure(self, parameters: P, output: Output) -> Mapping[str, float]:
        """Return the quantities of a run. Raise EngineOutputError for samples of no contact."""
        return self.values(parameters, motion_in(output, self.scene(parameters)))

    def values(self, parameters: P, motion: Motion) -> Mapping[str, float]:
        """Return the quantities of a motion. Raise EngineOutputError for samples of no contact."""
        try:
            with np.errstate(all="ignore"):  # a value that is not a number fails in its row
                return self.observe(parameters, motion)
        except (ArithmeticError, IndexError, ValueError) as error:
            raise EngineOutputError(f"the samples show no contact ({error})") from None

    def names(self, parameters: P) -> Iterable[str]:
        """Return the names of the quantities that a run with these parameters has."""
        return [quantity.name for quantity in self.quantities]

    def tolerance(self, parameters: P, quantity: Quantity[P]) -> Tolerance:
        """Return the tolerance on the difference from the reference at equal steps."""
        return Tolerance(absolute=ROUND_OFF * quantity.size(parameters), reason=REASON)

    def film_job(self, parameters: P, frames: int) -> Job:
        """Return the job of a run whose samples make a film of so many frames."""
        scene = self.scene(parameters)
        return self.job_of(scene.replace(every=max(1, scene.steps // max(1, frames))))

    def discs(self, parameters: P, output: Output) -> Discs:
        """Return the bodies in the plane of x and z, and a floor."""
        table, scene = output.tables[SERIES], self.scene(parameters)
        radii = np.array([body.radius for body in scene.bodies])
        reach = 2.0 * float(radii.max())
        x, z = table["x_m"], table["z_m"]
        ends = np.array([float(x.min()) - reach, float(x.max()) + reach])
        planes = [wall for wall in scene.walls if wall.shape == "plane"]
        lines = [np.stack([ends, np.full(2, wall.point[2])], axis=1) for wall in planes]
        walls = np.array(lines) if lines else np.empty((0, 2, 2))
        return Discs(self.name, table["time_s"], x, z, radii, lines=walls)

    # ---- verification

    def trials(self) -> Iterator[Trial]:
        """Yield each law in its systems, with the shortest level that runs it.

        At level quick the laws take turns in the systems that are not slow, but those of earlier
        interfaces, whose walls and pairs share no code.
        """
        names = [name for name, row in self.laws.items() if row.quick]
        for name, row in self.laws.items():
            systems = [system for system in self.systems if row.goes_with(system)]
            quick = set(self._quick_systems(name, row, systems, names))
            for system in systems:
                yield Trial(self, name, system, "quick" if system in quick else "default")

    def _quick_systems(
        self, name: str, row: tables.LawRow, systems: Sequence[str], names: Sequence[str]
    ) -> Iterator[str]:
        if not row.quick:
            return
        fast = [system for system in systems if system not in tables.SLOW_SYSTEMS]
        if row.law.get("interface") == "old":
            yield from fast
            return
        others = [system for system in fast if system not in self.always]
        yield from (system for system in fast if system in self.always)
        if others:
            yield others[names.index(name) % len(others)]
        if name == self.two_materials_law:
            yield from (system for system in systems if system.startswith("two materials"))

    def checks(self, engine: Engine) -> Iterable[Check]:
        """Return the checks of an engine, of all levels."""
        return self.checks_up_to(engine, "full")

    def checks_up_to(self, engine: Engine, level: Level) -> Iterator[Check]:
        """Yield the checks of an engine of a level and shorter ones; no scene of others is made."""
        self.listed[engine.name] = level
        for trial in self.trials():
            if runs_at(trial.level, level):
                yield from trial.comparison.checks(engine, trial.setup, trial.level)
        for trial in self.trials():
            if runs_at(self._variation_level(trial, QUICK_VARIATION), level):
                yield from self._varied_checks(engine, trial, level)

    def _variation_level(self, trial: Trial, variation: str) -> Level | None:
        """Return the shortest level that runs a variation of a trial, None for no level."""
        in_quick = trial.law in self.varied_in_quick
        if trial.system == VARIED_SYSTEM and in_quick and variation == QUICK_VARIATION:
            return "quick"
        if trial.system == VARIED_SYSTEM and (in_quick or trial.law in self.varied_by_default):
            return "default"
        return "full" if in_quick or trial.law in (*self.varied, *self.varied_by_default) else None

    def _varied_checks(self, engine: Engine, trial: Trial, level: Level) -> Iterator[Check]:
        plain = trial.comparison
        if engine.refuses(plain.job):
            return
        for name, varied in engine.variations(plain.scene):
            shortest = self._variation_level(trial, name)
            if shortest is not None and runs_at(shortest, level):
                run = replace(plain, scene=varied, variation=name)
                yield from run.checks(engine, trial.setup, shortest)

    def drawings(self, benches: Mapping[str, Bench]) -> Sequence[Drawing]:
        """Return the figures of the case in the overview of all."""
        return ()

    def sections(self, benches: Mapping[str, Bench]) -> Sequence[Section]:
        """Return the matrix of laws and systems for each engine, after the overview of all."""
        from harness.cases.contacts import report

        return report.sections(self, benches)


@dataclass(frozen=True)
class Comparison:
    """A run in an engine, perhaps in one of its variations, against the reference.

    ``scene`` is what the reference steps.
    """

    case: ContactCase[Any]
    parameters: Any
    scene: Scene
    variation: str = ""

    @property
    def job(self) -> Job:
        """Return the job of the run."""
        return self.case.job_of(self.case.sampled_scene(self.parameters), self.variation)

    def checks(self, engine: Engine, setup: str, level: Level) -> Iterator[Check]:
        """Yield a check of each quantity; the first alone where the engine refuses the scene."""
        p, job = self.parameters, self.job
        common: dict[str, Any] = {
            "setup": setup, "check": self.variation, "level": level, "jobs": (job,),
        }  # fmt: skip
        refused = bool(engine.refuses(job))
        for name in list(self.case.names(p))[: 1 if refused else None]:
            quantity = self.case.quantity(name)
            yield Check(
                quantity=name,
                unit=quantity.unit,
                measure=partial(self._measure, name),
                expected=partial(self._expected, name),
                tolerance=self.case.tolerance(p, quantity),
                **common,
            )
        if refused:
            return
        width = Tolerance(absolute=ROUND_OFF, reason=REASON)
        yield Check(
            quantity=MOTION, unit="1", measure=self._motion_difference, expected=0.0,
            tolerance=width, **common,
        )  # fmt: skip
        if not self.variation and self._is_moved(engine.rules(self.scene)):
            yield Check(
                quantity=MOVED, unit="1", measure=self._moved, expected=0.0, kind=Kind.FINDING,
                **common,
            )  # fmt: skip

    def differences(self, bench: Bench) -> dict[str, float]:
        """Return the difference of each quantity from the reference, in parts of its scale."""
        found, case = bench.once(Comparison._values, self, bench), self.case
        return {
            name: abs(found[name] - self._expected(name, bench))
            / case.quantity(name).size(self.parameters)
            for name in case.names(self.parameters)
        }

    @lru_cache(maxsize=8192)  # noqa: B019 - of frozen objects, as those of scenes
    def moved(self, rules: Rules, other: Rules) -> tuple[float, str]:
        """Return the largest change of a quantity from one set of conventions to another.

        In parts of its scale, and the name of the quantity; by the reference.
        """
        case, p = self.case, self.parameters
        one, two = (case.values(p, reference.run(self.scene, each)) for each in (rules, other))
        changes = {
            name: abs(one[name] - two[name]) / case.quantity(name).size(p)
            for name in case.names(p)
            if math.isfinite(one[name] - two[name])
        }
        name = max(changes, key=changes.__getitem__, default="")
        return changes.get(name, 0.0), name

    def _is_moved(self, rules: Rules) -> bool:
        """Return whether conventions of a code move a quantity beyond round-off."""
        try:
            return bool(rules.changed) and self.moved(rules, Rules())[0] > ROUND_OFF
        except EngineNaNError:  # a run that the other rows report
            return False

    def _motion(self, bench: Bench) -> Motion:
        job = self.job
        return motion_in(bench.output(job), bench.engine.scene_of(job))

    def _values(self, bench: Bench) -> Mapping[str, float]:
        return self.case.values(self.parameters, self._motion(bench))

    def _reference_values(self, bench: Bench) -> Mapping[str, float]:
        return self.case.values(self.parameters, bench.reference(self.scene))

    def _measure(self, name: str, bench: Bench) -> Value:
        value = bench.once(Comparison._values, self, bench)[name]
        exact = {} if self.variation else _exact(self.case, self.parameters)
        if name not in exact:
            return Value(value)
        error = self._expected(name, bench) - exact[name]
        return Value(value, note=f"error of the step {error:.2g} (closed form {exact[name]:.9g})")

    def _expected(self, name: str, bench: Bench) -> float:
        return bench.once(Comparison._reference_values, self, bench)[name]

    def _motion_difference(self, bench: Bench) -> float:
        return motion_difference(self.scene, self._motion(bench), bench.reference(self.scene))

    def _moved(self, bench: Bench) -> Value:
        rules = bench.rules(self.scene)
        size, name = self.moved(rules, Rules())
        changed = ", ".join(f"{rule} = {word}" for rule, word in rules.changed.items())
        return Value(size, note=f"{name}, by {changed}: part of its scale, by the reference")


@lru_cache(maxsize=4096)
def _scene(case: ContactCase[P], parameters: P) -> Scene:
    return case.build(parameters)


@lru_cache(maxsize=4096)
def _sampled_scene(case: ContactCase[P], parameters: P) -> Scene:
    scene = case.scene(parameters)
    if scene.segments or scene.steps // scene.every >= SAMPLES:
        return scene
    every = max(scene.steps // SAMPLES, 1)
    while scene.every % every:
        every -= 1
    return scene.replace(every=every)


@lru_cache(maxsize=4096)
def _exact(case: ContactCase[P], parameters: P) -> Mapping[str, float]:
    return case.exact(parameters)
