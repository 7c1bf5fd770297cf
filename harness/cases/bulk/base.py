"""Bulk cases: a system from many seeds, means over them, engines against one another.

Bulk is chaotic: motions of one seed part between codes, so that means over seeds are compared. Two
codes are equivalent where the 90 % interval of the ratio of their means lies within 5 % of one.
Where codes state the contact law by different rules, a ratio of their means is a finding; a code
whose scripts take the rules as values also runs under those of the other, and is compared with it.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any, ClassVar, Generic, NamedTuple, TypeVar

import numpy as np

from harness.cases.base import LEVELS, Case, Check, Level, Quantity, Value
from harness.cases.bench import OWN, Bench
from harness.cases.bulk.beds import Bed
from harness.cases.bulk.law import StatedLaw, bulk_law, stated_law
from harness.cases.bulk.mixing import Floats
from harness.cases.bulk.report import Curve, Line, bulk_section, plane_section
from harness.cases.bulk.statistics import (
    BY_CHANCE,
    EQUIVALENT,
    check_different,
    mean_interval,
    ratio_of_means,
    same_shares,
)
from harness.engines.contract import Engine, Job, Output, Template
from harness.errors import EngineError, EngineUndecidedError, Unsupported
from harness.model.law import Law
from harness.report.content import Discs, Section
from harness.results.rows import Kind, Tolerance

B = TypeVar("B", bound=Bed)
Seeds = Mapping[Level, int]

AT_REST = 0.01  # kinetic energy of a bed at rest over that of its process
SLOW = 3.0  # [us] of a step of ten particles: slower engines leave long setups to longer levels
SECONDS_PER_STEP = 4e-6  # of a particle in the slowest code, for time limits
PARTICLES = "particles"  # value of scripts: 1 writes all particles in place of the series
TIME = Quantity[Any]("microseconds_per_particle_step", "us",
                     "wall time of a particle and step, of a run among others")  # fmt: skip


class Sample(NamedTuple):
    """The runs of a setup in an engine: quantities of each run with a value, and its curves.

    ``undecided`` are the reasons of runs that ended without the event that they wait for.
    """

    rows: tuple[Mapping[str, float], ...]
    curves: tuple[Mapping[str, Floats], ...]
    undecided: tuple[str, ...]

    def values(self, quantity: str) -> Floats:
        """Return the values of a quantity over the runs, (runs,)."""
        return np.array([row.get(quantity, math.nan) for row in self.rows])

    def mean(self, quantity: str) -> float:
        """Return the mean over the runs."""
        return float(self.values(quantity).mean())

    def mean_value(self, quantity: str, note: str = "") -> Value:
        """Return the mean with the half width of its 95 % interval, of few runs without one."""
        low, high = mean_interval(self.values(quantity))
        half = 0.0 if math.isnan(low) else 0.5 * (high - low)
        return Value(self.mean(quantity), half, note)

    def worst(self, quantity: str) -> float:
        """Return the largest value over the runs; NaN where one is."""
        return float(self.values(quantity).max())


@dataclass(frozen=True)
class Setup(Generic[B]):
    """Runs of a system that are judged together.

    ``title`` is that of its section, ``compared`` are the quantities that engines are
    compared in. Slow engines run it at level ``slow`` and above.
    """

    name: str
    title: str
    runs: tuple[B, ...]
    level: Level
    compared: tuple[str, ...]
    slow: Level = "default"

    def level_in(self, *engines: Engine) -> Level:
        """Return the shortest level at which all engines run it."""
        late = any(engine.traits.microseconds_per_step > SLOW for engine in engines)
        return max(self.level, self.slow if late else self.level, key=LEVELS.index)


class Side(NamedTuple):
    """One side of a comparison: an engine by name and title, under rules or its own (None)."""

    name: str
    title: str
    law: StatedLaw | None = None


Measured = Callable[[Sample], Any]


class BulkCase(Case[B]):
    """A system of many grains, run from several seeds (parameter ``seed``)."""

    group = "bulk"
    template: ClassVar[Template]
    seeds: ClassVar[Seeds]  # runs of a setup, by its level
    compared: ClassVar[tuple[str, ...]]
    curves: ClassVar[tuple[Curve, ...]]
    title: ClassVar[str]
    text: ClassVar[str]
    gain: ClassVar[str]  # quantity: energy gained, of the worst seed
    elastic: ClassVar[str] = ""  # quantity: energy of the bed's normal springs, over the same scale
    rest: ClassVar[str]  # quantity: kinetic energy of the bed before it is disturbed
    rest_reason: ClassVar[str]  # why it may be 1 %

    # ---- what a case adds

    @abstractmethod
    def elastic_bound(self, parameters: B, sample: Sample) -> float:
        """Return a bound of :attr:`elastic` for engines that do not measure it."""

    def more_checks(self, setup: Setup[B]) -> Iterable[Check]:
        """Return the checks of an engine by itself beyond energy gained and bed at rest."""
        return ()

    @abstractmethod
    def columns(self, parameters: B, output: Output) -> Mapping[str, Floats]:
        """Return the columns of :attr:`curves`, each (M,)."""

    @abstractmethod
    def plane(self, parameters: B) -> tuple[float, Sequence[Line]]:
        """Return the plane of a film: its y [m] and the walls in it."""

    def film_radii(self, parameters: B) -> Floats | None:
        """Return the radius of each particle (N,) [m]; None where the run of a film writes it."""
        return None

    def setups(self) -> Sequence[Setup[B]]:
        """Return what is verified: the default from as many seeds as each level has."""
        return self.seed_setups("", self.title, self.default)

    def law(self, parameters: B) -> Law:
        """Return the contact law of two grains, by the coefficients that matter for its rules."""
        rolling = getattr(parameters, "rolling_friction", 0.0)
        return bulk_law(parameters.poisson_ratio, rolling)

    # ---- runs

    def job(self, parameters: B) -> Job:
        """Return the job of a run; raise RequestError for a bed that cannot be run."""
        seconds = SECONDS_PER_STEP * parameters.particle_steps
        return Job(self.template, parameters.values, sampled=True, seconds=seconds)

    def job_under(self, parameters: B, law: StatedLaw | None) -> Job:
        """Return the job of a run under the rules of a law, None for the engine's own."""
        job = self.job(parameters)
        return job if law is None else replace(job, values=law.values(job.values))

    def film_job(self, parameters: B, frames: int) -> Job:
        """Return the job whose series is that of all particles."""
        job = self.job(parameters)
        every = max(1, int(job.values["steps"]) // (frames - 1))
        values = {**job.values, "series_every": every}
        if self.film_radii(parameters) is None:
            values[PARTICLES] = 1
        return replace(job, values=values)

    def discs(self, parameters: B, output: Output) -> Discs:
        """Return the film of a cut through the middle."""
        p = parameters
        y, lines = self.plane(p)
        radii = self.film_radii(p)
        return plane_section(self.title, output, p.settle_steps, p.step_size, y, lines, radii)

    def cost(self, parameters: B) -> float:
        """Return the steps of a run times its grains."""
        return parameters.particle_steps

    def profile(self, parameters: B, output: Output) -> Mapping[str, Sequence[float]]:
        """Return the curves over the abscissa of the first one."""
        x = self.curves[0].x
        names = [x, *(curve.y for curve in self.curves if curve.x == x)]
        columns = self.columns(parameters, output)
        return {name: columns[name].tolist() for name in names}

    def seed_setups(
        self, prefix: str, title: str, parameters: B, seeds: Seeds | None = None
    ) -> tuple[Setup[B], ...]:
        """Return a setup for each level, with its number of seeds."""
        return tuple(
            Setup(
                f"{prefix}{count} seeds", title, seeds_of(parameters, count), level, self.compared
            )
            for level, count in (seeds or self.seeds).items()
        )

    def sample(self, bench: Bench, setup: Setup[B], law: StatedLaw | None = None) -> Sample:
        """Return the runs of a setup; raise the first error of an engine."""
        return bench.once(self._sample, bench, setup, law)

    def _sample(self, bench: Bench, setup: Setup[B], law: StatedLaw | None) -> Sample:
        rows, curves, undecided = [], [], []
        outcomes = bench.outcomes([self.job_under(p, law) for p in setup.runs])
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

    # ---- checks

    def checks(self, engine: Engine) -> Iterable[Check]:
        """Return the checks of an engine by itself."""
        for setup in self.setups():
            jobs, level = [self.job(p) for p in setup.runs], setup.level_in(engine)
            for check in (self._gain(setup), self._rest(setup), *self.more_checks(setup)):
                yield replace(check, level=level, jobs=jobs)

    def _rest(self, setup: Setup[B]) -> Check:
        """Return the check that the bed is at rest, by its worst seed."""
        tolerance = Tolerance(AT_REST, reason=self.rest_reason)
        return self.check(setup, self.rest, lambda s: s.worst(self.rest), tolerance=tolerance)

    def _gain(self, setup: Setup[B]) -> Check:
        """Return the check that no seed gains more energy than the springs of its bed hold."""
        p = setup.runs[0]

        def spring_energy(sample: Sample) -> Floats:
            springs = sample.values(self.elastic) * (1.0 + p.tangential_share)
            bound = self.elastic_bound(p, sample)
            return springs if np.isfinite(springs).all() else np.full(len(springs), bound)

        def worst(sample: Sample) -> int:
            return int(np.argmax(sample.values(self.gain) - spring_energy(sample)))

        share = f"tangential ones at most {p.tangential_share:.2g} times the normal ones"
        reason = f"energy of the bed's springs at rest, {share}"
        return self.check(
            setup,
            self.gain,
            lambda s: float(s.values(self.gain)[worst(s)]),
            tolerance=lambda s: Tolerance(float(spring_energy(s)[worst(s)]), reason=reason),
        )

    def check(
        self,
        setup: Setup[B],
        quantity: str,
        measure: Measured,
        expected: float | Measured = 0.0,
        tolerance: Tolerance | Measured | None = None,
        kind: Kind = Kind.ANALYTIC,
        **more: Any,
    ) -> Check:
        """Return a check whose value, expected value and tolerance may be functions of a sample."""

        def of_sample(item: Any) -> Any:
            return (lambda bench: item(self._decided(bench, setup))) if callable(item) else item

        unit = next((q.unit for q in self.quantities if q.name == quantity), "1")
        return Check(
            setup=setup.name, quantity=quantity, unit=unit, kind=kind,
            measure=of_sample(measure), expected=of_sample(expected),
            tolerance=of_sample(tolerance or Tolerance()), **more,
        )  # fmt: skip

    def _decided(self, bench: Bench, setup: Setup[B], law: StatedLaw | None = None) -> Sample:
        sample = self.sample(bench, setup, law)
        if not sample.rows:
            first = sample.undecided[0]
            raise Unsupported(f"{len(setup.runs)} of {len(setup.runs)} runs have no value; {first}")
        return sample

    # ---- engines against one another

    def comparisons(self, engines: Sequence[Engine]) -> Iterable[tuple[Engine, Check]]:
        """Return the comparisons of every two engines in every setup that both can run."""
        for setup in self.setups():
            p = setup.runs[0]
            able = [engine for engine in engines if not engine.refuses(self.job(p))]
            laws = {engine.name: stated_law(engine, self.law(p)) for engine in able}
            for first, second in combinations(able, 2):
                level = setup.level_in(first, second)
                for engine, check in self._compare(setup, first, second, laws):
                    yield engine, replace(check, level=level)

    def _compare(
        self, setup: Setup[B], first: Engine, second: Engine, laws: Mapping[str, StatedLaw]
    ) -> Iterator[tuple[Engine, Check]]:
        """Yield the comparisons of two engines, each under its own law and under one law."""
        one, other = laws[first.name], laws[second.name]
        sides = Side(first.name, first.title), Side(second.name, second.title)
        kind = Kind.CROSS_CODE if one == other else Kind.FINDING
        note = "" if one == other else f"{first.title}: {one.text}; {second.title}: {other.text}"
        for check in self._ratios(setup, *sides, f"over {second.title}", kind, note):
            yield first, check
        if one.rules == other.rules:
            return
        for runner, place, law in ((first, 1, other), (second, 0, one)):
            if not runner.refuses(self.job_under(setup.runs[0], law)):
                for check in self._under(setup, sides[1 - place], sides[place], law):
                    yield runner, check

    def _under(self, setup: Setup[B], runner: Side, other: Side, law: StatedLaw) -> Iterator[Check]:
        """Yield the comparisons of an engine under the law of another: with it, and with itself."""
        ruled, rules = runner._replace(law=law), f"the rules of {other.title}"
        kind = Kind.FINDING if law.lacks else Kind.CROSS_CODE
        note = f"{other.title} {law.lacks}" if law.lacks else ""
        yield from self._ratios(
            setup, ruled, other, f"under {rules}, over {other.title}", kind, note
        )
        effect = "effect of the rules in one code; its sign is not predicted"
        yield from self._ratios(setup, ruled, runner, rules, Kind.FINDING, effect)

    def _ratios(
        self, setup: Setup[B], first: Side, second: Side, check: str, kind: Kind, note: str
    ) -> Iterator[Check]:
        """Yield the ratio of means of each compared quantity, and Fisher's test of lost runs."""

        def samples(bench: Bench) -> tuple[Sample, Sample]:
            one, other = (
                self._decided(bench.others.get(side.name, bench), setup, side.law)
                for side in (first, second)
            )
            return one, other

        def ratio(bench: Bench, quantity: str) -> Value:
            pair = samples(bench)
            for sample, side in zip(pair, (first, second), strict=True):
                check_different(sample.rows, side.title)
            return ratio_of_means(*(sample.values(quantity) for sample in pair))

        def shares(bench: Bench) -> Value:
            one, other = (
                self.sample(bench.others.get(side.name, bench), setup, side.law)
                for side in (first, second)
            )
            return same_shares(*((len(s.rows), len(s.undecided)) for s in (one, other)))

        jobs = [self.job_under(p, first.law) for p in setup.runs]
        common: dict[str, Any] = {
            "setup": setup.name, "check": check, "kind": kind, "note": note, "jobs": jobs,
            "unit": "1", "expected": 1.0,
        }  # fmt: skip
        if setup.runs[0].LEAVING and setup.compared:
            yield Check(
                quantity="runs_without_value", measure=shares, tolerance=BY_CHANCE, **common
            )
        for name in setup.compared:
            yield Check(
                quantity=name,
                measure=lambda bench, name=name: ratio(bench, name),  # type: ignore[misc]
                tolerance=EQUIVALENT if kind is Kind.CROSS_CODE else Tolerance(),
                **common,
            )

    # ---- report

    def sections(self, benches: Mapping[str, Bench]) -> Sequence[Section]:
        """Return a section for each system, of its setup with most runs that was run."""
        sections = {}
        for setup in self.setups():
            samples = dict(self._samples_run(setup, benches))
            if samples:
                sections[setup.title] = bulk_section(
                    self.name, setup, self.text, samples, self.curves, self.quantities
                )
        return [*sections.values()]

    def _samples_run(
        self, setup: Setup[B], benches: Mapping[str, Bench]
    ) -> Iterator[tuple[str, Sample]]:
        """Yield the title and the sample of each engine that has run a setup, also under rules."""
        own = {name: bench for name, bench in benches.items() if name != OWN}
        laws = {
            f" under the rules of {bench.engine.title}": stated_law(
                bench.engine, self.law(setup.runs[0])
            )
            for bench in own.values()
        }
        for bench in own.values():
            for words, law in {"": None, **laws}.items():
                if not bench.has_run([self.job_under(p, law) for p in setup.runs]):
                    continue
                try:
                    sample = self.sample(bench, setup, law)
                except EngineError:
                    continue  # its rows have the error
                if sample.rows:
                    yield f"{bench.engine.title}{words}", sample


def seeds_of(parameters: B, count: int) -> tuple[B, ...]:
    """Return the parameters of runs from seeds 1 to a number."""
    return tuple(parameters.replace(seed=seed) for seed in range(1, count + 1))
