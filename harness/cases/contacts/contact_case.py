"""Contact cases: each law in each system, one check a quantity, at equal steps.

An engine runs a scene once. The reference takes the same steps by the engine's conventions, and
what differs is round-off, or a fault. That the reference converges to the law is a property of this
package, shown in its tests; the note of a row has the error of the step where a closed form exists.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, partial
from typing import Any, TypeVar

import numpy as np

from harness.cases.base import Case, Check, Level, Value
from harness.cases.bench import Bench
from harness.cases.checks import REASON, ROUND_OFF, runs_at, with_step_error
from harness.cases.contacts import tables
from harness.cases.contacts.parameters import ContactSystem
from harness.engines.base import Engine, Job, Output, scene_job
from harness.engines.output import SERIES
from harness.engines.process import cores, parallel_map
from harness.engines.scenes import motion_in
from harness.errors import EngineNaNError, EngineOutputError
from harness.model.conventions import Rules
from harness.model.scene import Motion, Scene
from harness.report.content import Discs, Section
from harness.results.rows import Kind, Tolerance
from harness.solvers import reference

P = TypeVar("P", bound=ContactSystem)

STEPS = 50  # of a contact, in checks
SAMPLES = 50  # at least, of a run that is held against the reference
QUICK_VARIATION = "defaults"  # of an engine, at level quick
MOTION = "motion"  # quantity of the rows on all samples of a run
MOVED = "moved_by_conventions"  # quantity of the findings on an engine's conventions


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
        presets = tables.presets(self.name)
        sources = {name: values.pop("source", "") for name, values in presets.items()}
        self.group = "contacts"
        self.presets = {name: self.parameters(**values) for name, values in presets.items()}
        self.sources = {name: source for name, source in sources.items() if source}

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
        ends = np.array([float(x.min()) - margin, float(x.max()) + margin])
        planes = [wall for wall in scene.walls if wall.shape == "plane"]
        lines = [np.stack([ends, np.full(2, wall.point[2])], axis=1) for wall in planes]
        walls = np.array(lines) if lines else np.empty((0, 2, 2))
        return Discs(self.name, table["time_s"], x, z, radii, lines=walls)

    # ---- verification

    @cached_property
    def trials(self) -> tuple[Trial, ...]:
        """Return each law in its systems."""
        return tuple(Trial(self, entry) for entry in tables.entries(self.name))

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
            if runs_at(trial.entry.varied, level) and not engine.refuses(trial.job):
                for name, scene in engine.variations(trial.scene):
                    varied = replace(trial, variation=name, varied_scene=scene)
                    if runs_at(varied.level, level):
                        yield from varied.checks(engine)

    def sections(self, benches: Mapping[str, Bench]) -> Sequence[Section]:
        """Return the matrix of laws and systems for each engine, after the overview of all."""
        from harness.cases.contacts import report

        return report.sections(self, benches)


@dataclass(frozen=True, eq=False)
class Trial:
    """A law of a case in a system, perhaps in a variation of an engine, against the reference.

    ``varied_scene`` is what the reference steps in a variation.
    """

    case: ContactCase[Any] = field(repr=False)
    entry: tables.Entry
    variation: str = ""
    varied_scene: Scene | None = None

    @cached_property
    def parameters(self) -> Any:
        """Return the parameters of a run."""
        return self.case.default.replace(**self.entry.changes, steps_per_contact=STEPS)

    @property
    def level(self) -> Level:
        """Return the shortest level that runs it."""
        varied = self.entry.varied
        if not self.variation or varied is None:
            return self.entry.level
        return "default" if varied == "quick" and self.variation != QUICK_VARIATION else varied

    @property
    def setup(self) -> str:
        """Return the name of the setup of its checks."""
        return f"{self.entry.law}, {self.entry.system}"

    @property
    def scene(self) -> Scene:
        """Return what the reference steps: the scene of the run, or that of a variation."""
        return self.varied_scene or self.case.scene(self.parameters)

    @property
    def job(self) -> Job:
        """Return the job of the run."""
        return self.case.job_of(self.case.scene(self.parameters), self.variation)

    def checks(self, engine: Engine) -> Iterator[Check]:
        """Yield a check of each quantity; the first alone where the engine refuses the scene."""
        common: dict[str, Any] = {
            "setup": self.setup, "check": self.variation, "level": self.level, "jobs": (self.job,),
        }  # fmt: skip
        refused = bool(engine.refuses(self.job))
        for name in self.case.names(self.parameters)[: 1 if refused else None]:
            quantity = self.case.quantity(name)
            width = ROUND_OFF * quantity.size(self.parameters)
            yield Check(
                quantity=name,
                unit=quantity.unit,
                measure=partial(self._measured, name),
                expected=partial(self._expected, name),
                tolerance=Tolerance(absolute=width, reason=REASON),
                **common,
            )
        if refused:
            return
        common |= {"unit": "1", "expected": 0.0}
        common |= {"tolerance": Tolerance(absolute=ROUND_OFF, reason=REASON)}
        yield Check(quantity=MOTION, measure=self._motion_difference, **common)
        rules = engine.rules(self.scene)
        if rules.changed and not self.variation and self.moved(rules, Rules())[0] > ROUND_OFF:
            common |= {"tolerance": Tolerance()}
            yield Check(quantity=MOVED, measure=self._moved, kind=Kind.FINDING, **common)

    def values(self, bench: Bench) -> Mapping[str, float]:
        """Return the quantities of the run in the engine."""
        return observe(self.parameters, bench.motion(self.job))

    def expected_values(self, bench: Bench) -> Mapping[str, float]:
        """Return the quantities of the reference under the engine's conventions."""
        return observe(self.parameters, bench.reference(self.scene))

    @lru_cache(maxsize=8192)  # noqa: B019 - of frozen objects, as those of scenes
    def moved(self, rules: Rules, other: Rules) -> tuple[float, str]:
        """Return the largest change of a quantity from one set of conventions to another.

        In parts of its scale, and the name of the quantity; by the reference.
        """
        case, p = self.case, self.parameters
        try:
            first, second = (observe(p, reference.run(self.scene, each)) for each in (rules, other))
        except EngineNaNError:  # a run that the other rows report
            return 0.0, ""
        changes = {
            name: abs(first[name] - second[name]) / case.quantity(name).size(p)
            for name in case.names(p)
            if math.isfinite(first[name] - second[name])
        }
        name = max(changes, key=changes.__getitem__, default="")
        return changes.get(name, 0.0), name

    def _measured(self, name: str, bench: Bench) -> Value:
        value = bench.once(Trial.values, self, bench)[name]
        exact = {} if self.variation else self.case.exact(self.parameters)
        return with_step_error(value, exact.get(name), partial(self._expected, name, bench))

    def _expected(self, name: str, bench: Bench) -> float:
        return bench.once(Trial.expected_values, self, bench)[name]

    def _motion_difference(self, bench: Bench) -> float:
        return motion_difference(self.scene, bench.motion(self.job), bench.reference(self.scene))

    def _moved(self, bench: Bench) -> Value:
        rules = bench.rules(self.scene)
        size, name = self.moved(rules, Rules())
        changed = ", ".join(f"{rule} = {word}" for rule, word in rules.changed.items())
        return Value(size, note=f"{name}, by {changed}: part of its scale, by the reference")


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
    not free may be unknown; NaN elsewhere makes the difference NaN.
    """
    r = min(body.radius for body in scene.bodies)
    free = [bool(scene.segments) or body.motion == "free" for body in scene.bodies]
    gravity, time = math.hypot(*scene.gravity), scene.step * STEPS
    path = np.abs(other.position - other.position[0]).max()
    length = max(path, gravity * (time / math.pi) ** 2) or r
    rim = r * np.abs(other.angular_velocity).max()
    speed = max(np.abs(other.velocity).max(), rim, gravity * time) or 1.0
    force = np.abs(other.force[:, free]).max() or 1.0
    differences = [
        np.abs(motion.position - other.position).max() / length,
        np.abs(motion.velocity - other.velocity).max() / speed,
        np.abs(motion.angular_velocity - other.angular_velocity).max() * r / speed,
        np.abs(motion.force - other.force)[:, free].max() / force,
        np.abs(motion.torque - other.torque)[:, free].max() / force / r,
    ]
    if motion.temperature is not None and other.temperature is not None:
        warmed = np.ptp(other.temperature) or 1.0
        differences.append(np.abs(motion.temperature - other.temperature).max() / warmed)
    return float(np.max(differences))


@lru_cache(maxsize=4096)
def _sampled_scene(parameters: ContactSystem) -> Scene:
    """Return the scene with :data:`SAMPLES` or more, which changes no quantity."""
    scene = parameters.scene()
    if scene.segments or scene.steps // scene.every >= SAMPLES:
        return scene
    every = max(scene.steps // SAMPLES, 1)
    while scene.every % every:
        every -= 1
    return scene.replace(every=every)


@lru_cache(maxsize=4096)
def _exact(parameters: ContactSystem) -> Mapping[str, float]:
    return parameters.exact()
