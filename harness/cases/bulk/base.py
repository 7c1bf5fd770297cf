"""Bulk cases: a system from many seeds, means over them, engines against one another.

Bulk is chaotic: motions of one seed part between codes, so that means over seeds are compared. Two
codes are equivalent where the 90 % interval of the ratio of their means lies within 5 % of one.
Where codes have different rules of the contact law, a ratio of their means is a finding; a code
whose scripts take the rules as values also runs under those of the other, and is compared with it.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np

from harness.cases.base import LEVELS, Case, Check, Level, Quantity, Value
from harness.cases.bench import OWN, Bench
from harness.cases.bulk.beds import Bed, Floats
from harness.cases.bulk.law import ALLOWED, StatedLaw, bulk_law, stated_law
from harness.cases.bulk.report import Curve, Line, bulk_section, plane_section
from harness.cases.bulk.samples import (
    BY_CHANCE,
    EQUIVALENT,
    TIME,
    Sample,
    ratio_of_means,
    same_shares,
)
from harness.engines.base import Engine, Job, Output, Template
from harness.errors import EngineError, EngineUndecidedError, Unsupported
from harness.model.allowed import allowed_in, descriptions
from harness.report.content import Discs, Section
from harness.results.rows import Kind, Tolerance

B = TypeVar("B", bound=Bed)

AT_REST = 0.01  # kinetic energy of a bed at rest over that of its process
SLOW = 3.0  # [us] of a step of ten particles: slower engines leave long setups to longer levels
SECONDS_PER_STEP = 4e-6  # of a particle in the slowest code, for time limits
ABOUT = {  # values of scripts that are no parameters
    "settle_steps": "before the bed is disturbed",
    "steps": "after that",
    "series_every": "steps between two rows of the series",
    "damping": "of the contacts",
    "bed": "lattice, or file: the grains of a data file of atom_style sphere",
    "length": "[m] of the box along x",
    "width": "[m] along y, likewise",
}
IN_SCRIPTS = {"places": "the data file; large grains are of type 1"}  # not as of the parameter
ELASTIC = "elastic_ratio"  # energy of the bed's normal springs over the scale of energy gained
BED_STATE = (
    Quantity[Any]("bed_solid_fraction", "1", "of the bed at rest, up to its level surface", 0.5),
    Quantity[Any]("bed_coordination", "1", "contacts of a grain in the bed at rest", 5.0),
)
WALL_TIME = Quantity[Any](TIME, "us", "wall time of a particle and step, of a run among others")


@dataclass(frozen=True)
class Setup(Generic[B]):
    """Runs of a system that are judged together.

    ``system`` is the title of its section after that of the case, ``compared`` are the quantities
    that engines are compared in. Slow engines run it at level ``slow`` and above.
    """

    name: str
    system: str
    runs: tuple[B, ...]
    level: Level
    compared: tuple[str, ...]
    slow: Level = "default"

    def level_in(self, *engines: Engine) -> Level:
        """Return the shortest level at which all engines run it."""
        late = any(engine.traits.microseconds_per_step > SLOW for engine in engines)
        return max(self.level, self.slow if late else self.level, key=LEVELS.index)


def seed_setups(
    parameters: B, seeds: Mapping[Level, int], compared: tuple[str, ...], system: str = ""
) -> list[Setup[B]]:
    """Return a setup of a system for each level, from so many seeds."""
    setups = []
    for level, count in seeds.items():
        runs = tuple(parameters.replace(seed=seed) for seed in range(1, count + 1))
        name = f"{system}, {count} seeds".removeprefix(", ")
        setups.append(Setup(name, system, runs, level, compared))
    return setups


Measured = Callable[[Sample], Any]


class BulkCase(Case[B]):
    """A system of many grains, run from several seeds (parameter ``seed``).

    Its scripts have the case's name in each engine, and take the parameters as values.
    """

    group = "bulk"
    parameters: ClassVar[type[Bed]]
    template: ClassVar[Template]
    text: ClassVar[str]  # after the summary
    curves: ClassVar[tuple[Curve, ...]]
    setups: ClassVar[Sequence[Setup[Any]]]  # what is verified
    gain: ClassVar[str]  # quantity: energy gained
    rest: ClassVar[str] = "bed_kinetic_ratio"  # quantity: energy of the bed before it is disturbed
    rest_scale: ClassVar[str]  # energy of which a bed at rest has 1 % at most

    def __init_subclass__(cls, **more: Any) -> None:
        """Make the template of the case from its parameters."""
        super().__init_subclass__(**more)
        kind = cls.parameters
        # scripts without rolling resistance run beds without it
        neutral = {"rolling_friction": 0.0} if "rolling_friction" in kind.model_fields else {}
        cls.template = Template(
            cls.name,
            {"": kind().values},
            {"": f"{cls.summary} {cls.text}"},
            allowed=allowed_in(kind) | ALLOWED,
            neutral=neutral,
            about=ABOUT | descriptions(kind) | IN_SCRIPTS,
        )

    @property
    def title(self) -> str:
        """Return the process, which the summary names first."""
        return self.summary.partition(":")[0]

    # ---- what a case adds

    @abstractmethod
    def columns(self, parameters: B, output: Output) -> Mapping[str, Floats]:
        """Return the columns of :attr:`curves`, each (M,)."""

    @abstractmethod
    def plane(self, parameters: B) -> tuple[float, Sequence[Line]]:
        """Return the plane of a film: its y [m] and the walls in it."""

    def film_radii(self, parameters: B) -> Floats | None:
        """Return the radius of each particle (N,) [m]; None where the run of a film writes it."""
        return None

    def elastic_bound(self, parameters: B, sample: Sample) -> float:
        """Return a bound of :data:`ELASTIC` for engines that do not measure it."""
        return math.nan

    def more_checks(self, setup: Setup[B]) -> Iterable[Check]:
        """Return the checks of an engine by itself beyond energy gained and bed at rest."""
        return ()

    # ---- runs

    def job(self, parameters: B, law: StatedLaw | None = None) -> Job:
        """Return the job of a run, perhaps under a law; raise RequestError for a bad bed."""
        values = parameters.values if law is None else law.values(parameters.values)
        seconds = SECONDS_PER_STEP * parameters.particle_steps
        return Job(self.template, values, sampled=True, seconds=seconds)

    def cost(self, parameters: B) -> float:
        """Return the steps of a run times its grains."""
        return parameters.particle_steps

    def film_job(self, parameters: B, frames: int) -> Job:
        """Return the job whose series is that of all particles."""
        job = self.job(parameters)
        values = {**job.values, "series_every": max(1, parameters.steps // (frames - 1))}
        if self.film_radii(parameters) is None:
            values["particles"] = 1
        return replace(job, values=values)

    def discs(self, parameters: B, output: Output) -> Discs:
        """Return the film of a cut through the middle."""
        (y, lines), radii = self.plane(parameters), self.film_radii(parameters)
        step = output.table(("step",))["step"] - parameters.settle_steps
        return plane_section(self.title, output, step * parameters.step_size, y, lines, radii)

    def profile(self, parameters: B, output: Output) -> Mapping[str, Sequence[float]]:
        """Return the curves over the abscissa of the first one."""
        x = self.curves[0].x
        columns = self.columns(parameters, output)
        names = [x, *(curve.y for curve in self.curves if curve.x == x)]
        return {name: columns[name].tolist() for name in names}

    def sample(self, bench: Bench, setup: Setup[B], law: StatedLaw | None = None) -> Sample:
        """Return the runs of a setup; raise the first error of an engine."""
        return bench.once(self._sample, bench, setup, law)

    def _sample(self, bench: Bench, setup: Setup[B], law: StatedLaw | None) -> Sample:
        rows, curves, undecided = [], [], []
        outcomes = bench.outcomes([self.job(p, law) for p in setup.runs])
        for p, outcome in zip(setup.runs, outcomes, strict=True):
            if isinstance(outcome, EngineError):
                raise outcome
            try:
                rows.append(self.measure(p, outcome))
            except EngineUndecidedError as error:
                undecided.append(f"seed {p.seed}: {error}")
            else:
                curves.append(self.columns(p, outcome))
        return Sample(tuple(rows), tuple(curves), tuple(undecided))

    # ---- an engine by itself

    def checks(self, engine: Engine) -> Iterable[Check]:
        """Return the checks of an engine by itself."""
        for setup in self.setups:
            jobs, level = [self.job(p) for p in setup.runs], setup.level_in(engine)
            for check in (self._gain(setup), self._rest(setup), *self.more_checks(setup)):
                yield replace(check, level=level, jobs=jobs)

    def _gain(self, setup: Setup[B]) -> Check:
        """Return the check that no seed gains more energy than the springs of its bed hold."""
        p = setup.runs[0]

        def worst(sample: Sample) -> tuple[float, float]:
            gains = sample.values(self.gain)
            springs = sample.values(ELASTIC) * (1.0 + p.tangential_share)
            if not np.isfinite(springs).all():
                springs = np.full(len(gains), self.elastic_bound(p, sample))
            seed = int(np.argmax(gains - springs))
            return float(gains[seed]), float(springs[seed])

        share = f"tangential ones at most {p.tangential_share:.2g} times the normal ones"
        reason = f"energy of the bed's springs at rest, {share}"
        return self.check(
            setup, self.gain, lambda s: worst(s)[0],
            tolerance=lambda s: Tolerance(worst(s)[1], reason=reason),
        )  # fmt: skip

    def _rest(self, setup: Setup[B]) -> Check:
        """Return the check that each bed is at rest before it is disturbed.

        A bed swings for a time that its law decides, in each code alike: where it still moves, the
        time to settle is too short, and no code is at fault.
        """

        def worst(sample: Sample) -> float:
            value = float(sample.values(self.rest).max())
            if value > AT_REST:
                raise Unsupported(
                    f"the bed is not at rest: it has {value:.2%} of {self.rest_scale}, must have "
                    f"{AT_REST:.0%} at most; settle_time = {setup.runs[0].settle_time:g} s is too "
                    "short"
                )
            return value

        reason = f"a bed that moves adds 1 % to {self.rest_scale} at most"
        return self.check(setup, self.rest, worst, tolerance=Tolerance(AT_REST, reason=reason))

    def check(
        self,
        setup: Setup[B],
        quantity: str,
        measure: Measured,
        expected: float | Measured = 0.0,
        tolerance: Tolerance | Measured | None = None,
        kind: Kind = Kind.ANALYTIC,
        note: str = "",
    ) -> Check:
        """Return a check whose value, expected value and tolerance may be functions of a sample."""

        def of_bench(item: Any) -> Any:
            decided = lambda bench: item(self.sample(bench, setup).decided())  # noqa: E731
            return decided if callable(item) else item

        return Check(
            setup=setup.name, quantity=quantity, unit=self.quantity(quantity).unit, kind=kind,
            measure=of_bench(measure), expected=of_bench(expected),
            tolerance=of_bench(tolerance or Tolerance()), note=note,
        )  # fmt: skip

    # ---- engines against one another

    def comparisons(self, engines: Sequence[Engine]) -> Iterable[tuple[Engine, Check]]:
        """Return the comparisons of every two engines in every setup that both can run."""
        for setup in self.setups:
            p = setup.runs[0]
            able = [engine for engine in engines if not engine.refuses(self.job(p))]
            laws = {engine.name: self._law(engine, p) for engine in able}
            for pair in combinations(able, 2):
                level = setup.level_in(*pair)
                for engine, check in self._pair_checks(setup, *pair, laws):
                    yield engine, replace(check, level=level)

    def _law(self, engine: Engine, parameters: B) -> StatedLaw:
        rolling = getattr(parameters, "rolling_friction", 0.0)
        return stated_law(engine, bulk_law(parameters.poisson_ratio, rolling))

    def _pair_checks(
        self, setup: Setup[B], first: Engine, second: Engine, laws: Mapping[str, StatedLaw]
    ) -> Iterator[tuple[Engine, Check]]:
        """Yield the checks of two engines, each under its own law and under one law.

        An engine under the law of another is compared with it, and with itself.
        """
        pair = laws[first.name], laws[second.name]
        titles = f"{first.title}: {pair[0].text}; {second.title}: {pair[1].text}"
        kind, note = (Kind.CROSS_CODE, "") if pair[0] == pair[1] else (Kind.FINDING, titles)
        for check in self._ratios(setup, (first, None, second), kind):
            yield first, replace(check, check=f"over {second.title}", note=note)
        if pair[0].rules == pair[1].rules:
            return
        for runner, partner in ((first, second), (second, first)):
            law = laws[partner.name]
            if runner.refuses(self.job(setup.runs[0], law)):
                continue
            rules = f"the rules of {partner.title}"
            kind = Kind.FINDING if law.lacks else Kind.CROSS_CODE
            note = f"{partner.title} {law.lacks}" if law.lacks else ""
            for check in self._ratios(setup, (runner, law, partner), kind):
                yield (
                    runner,
                    replace(check, check=f"under {rules}, over {partner.title}", note=note),
                )
            effect = "effect of the rules in one code; its sign is not predicted"
            for check in self._ratios(setup, (runner, law, runner), Kind.FINDING):
                yield runner, replace(check, check=rules, note=effect)

    def _ratios(
        self, setup: Setup[B], pair: tuple[Engine, StatedLaw | None, Engine], kind: Kind
    ) -> Iterator[Check]:
        """Yield the ratio of means of each compared quantity, and Fisher's test of lost runs.

        ``pair`` are an engine, the law of another one under which it runs, and its partner.
        """
        engine, law, partner = pair

        def samples(bench: Bench) -> tuple[Sample, Sample]:
            second = bench.others.get(partner.name, bench)
            return self.sample(bench, setup, law), self.sample(second, setup)

        def ratio(quantity: str, bench: Bench) -> Value:
            decided = [sample.decided() for sample in samples(bench)]
            for sample, title in zip(decided, (engine.title, partner.title), strict=True):
                sample.check_spread(title)
            return ratio_of_means(*(sample.values(quantity) for sample in decided))

        row = partial(
            Check, setup=setup.name, unit="1", expected=1.0, kind=kind,
            jobs=[self.job(p, law) for p in setup.runs],
        )  # fmt: skip
        if setup.runs[0].LEAVING and setup.compared:
            yield row(
                quantity="runs_without_value", tolerance=BY_CHANCE,
                measure=lambda bench: same_shares(*samples(bench)),
            )  # fmt: skip
        tolerance = EQUIVALENT if kind is Kind.CROSS_CODE else Tolerance()
        for name in setup.compared:
            yield row(quantity=name, measure=partial(ratio, name), tolerance=tolerance)

    # ---- report

    def sections(self, benches: Mapping[str, Bench]) -> Sequence[Section]:
        """Return a section for each system, of its setup with most runs that was run."""
        sections = {}
        for setup in self.setups:
            jobs = [self.job(p) for p in setup.runs]
            samples = {
                bench.engine.title: sample
                for name, bench in benches.items()
                if name != OWN and bench.has_run(jobs)
                if (sample := self._sample_with_value(bench, setup))
            }
            if samples:
                sections[setup.system] = bulk_section(self, setup, samples)
        return [*sections.values()]

    def _sample_with_value(self, bench: Bench, setup: Setup[B]) -> Sample | None:
        """Return the runs of a setup, None where none has a value: the rows have the error."""
        try:
            sample = self.sample(bench, setup)
        except EngineError:
            return None
        return sample if sample.rows else None
