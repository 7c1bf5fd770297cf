"""Bulk cases: the same system from many seeds, means over them, engines against one another.

Bulk is chaotic: motions of one seed part between codes, so that means over seeds are compared.
"""

from __future__ import annotations

import sys
from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING, ClassVar, TypeVar

import numpy as np

from harness.cases.bulk.equivalence import FEWEST, Sample, equivalence, interval
from harness.cases.bulk.restarts import longest_part
from harness.cases.bulk.rules import differing, law_of
from harness.cases.contract import Case, LevelName, Study, Words
from harness.comparison.verdicts import Check, Kind, Planned, Tolerance, failed_run, not_tested
from harness.comparison.verification import Findings
from harness.engines.contract import Engine, Output
from harness.engines.traits import Traits
from harness.errors import EngineError, EngineUndecidedError
from harness.parameters.base import Parameters
from harness.report.sections import Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from harness.cases.bulk.film import Cut
    from harness.report.film import Film

    Floats = NDArray[np.float64]

P = TypeVar("P", bound=Parameters)

MARGIN = Tolerance(
    "",
    0.0,
    0.05,
    "stated before any run: codes are equivalent where the 90 % interval of the ratio of their "
    "means is within 5 % of 1, two one-sided tests of 5 %",
)


@dataclass(frozen=True)
class Curve:
    """What a figure shows of each run: the name of its file, and its axes."""

    figure: str
    x: str
    y: str


@dataclass(frozen=True)
class Runs:
    """The runs of an engine: quantities of each seed, and its curves, each (x, y).

    ``undecided`` runs ended without the event that they wait for, and have no row. ``law`` says by
    which rules the engine follows the law.
    """

    engine: str
    rows: tuple[Mapping[str, float], ...]
    curves: tuple[tuple[tuple[Floats, Floats], ...], ...] = ()
    undecided: int = 0
    law: str = ""

    def sample(self, quantity: str) -> Sample:
        """Return the values of a quantity over the seeds."""
        return Sample(self.engine, tuple(row[quantity] for row in self.rows))

    def worst(self, quantity: str) -> float:
        """Return the largest value over the seeds; NaN where one is."""
        return float(np.max(self.sample(quantity).values))


class BulkCase(Case[P]):
    """A system of many grains, run from several seeds (parameter ``seed``)."""

    group = "bulk"
    seeds: ClassVar[Mapping[LevelName, int]]
    """Runs of a level."""
    judged: ClassVar[tuple[str, ...]]
    """Checks of an engine, in the order of :meth:`judge`."""
    equivalent: ClassVar[tuple[str, ...]]
    """Quantities that codes are held against one another in; the others are shown."""
    drawn: ClassVar[tuple[Curve, ...]]

    @abstractmethod
    def judge(self, names: Sequence[str], runs: Runs, p: P) -> list[Check]:
        """Return the rows of an engine, by the names of :attr:`judged`; the worst seed decides."""

    @abstractmethod
    def curves(self, p: P, output: Output) -> Sequence[tuple[Floats, Floats]]:
        """Return x and y of each of :attr:`drawn`, in its units."""

    def part_seconds(self, parameters: P, rules: Traits) -> float:
        """Return the expected time between two restart files [s], of the whole run without any."""
        return self.seconds(parameters, rules) * longest_part(self.job(parameters).values)

    @abstractmethod
    def cut(self, p: P) -> Cut:
        """Return what a film shows of a run."""

    def radii(self, p: P) -> Floats | None:
        """Return the radius of each particle (N,) [m]; None where the film's run writes them."""
        return None

    def film(self, engine: Engine, parameters: P | None = None, frames: int = 120) -> Film:
        """Return the film of one run after its release, opening or first turn."""
        from harness.cases.bulk.film import PARTICLES, bulk_film

        p = parameters or self.default
        job, radii = self.job(p), self.radii(p)
        values = dict(job.values)
        values["series_every"] = max(1, int(values["steps"]) // (frames - 1))
        if radii is None:
            values[PARTICLES] = 1
        words = (self.summary.partition(":")[0], f"{self.summary} A cut through the middle.")
        begins = float(values["settle_steps"])
        return bulk_film(engine, replace(job, values=values), radii, begins, self.cut(p), words)

    def names(self, engine: Engine) -> list[str]:
        """Return the names of the rows of an engine."""
        return [f"{self.name}: {engine.name}: {check}" for check in self.judged]

    def planned(self, level: LevelName, engine: Engine) -> Sequence[Planned]:
        """Return the checks of an engine; the comparison of engines names its own."""
        return [Planned(name) for name in self.names(engine)]

    def verify(self, engine: Engine, study: Study) -> Findings:
        """Run the seeds of a level and judge them; one without its event has no row."""
        findings = Findings(self.name, engine.name)
        p = self.default
        trials = [p.replace(seed=seed) for seed in range(1, self.seeds[study.level] + 1)]
        names = self.names(engine)
        if reason := engine.refuses(self.job(trials[0])) or too_slow(engine, study.level):
            findings.checks += [not_tested(name, Kind.ANALYTIC, reason) for name in names]
            return findings
        rows, curves, undecided = [], [], []
        for seed, (trial, output) in enumerate(
            zip(trials, engine.run([self.job(trial) for trial in trials]), strict=True), 1
        ):
            try:
                if isinstance(output, EngineError):
                    raise output
                rows.append(self.measured(trial, output, engine.traits).values)
                curves.append(tuple(self.curves(trial, output)))
            except EngineUndecidedError as error:
                undecided.append(f"seed {seed}: {error}")
            except EngineError as error:
                name = f"{self.name}: {engine.name}: seed {seed}"
                findings.checks.append(failed_run(name, Kind.ANALYTIC, error))
        if not rows:
            if undecided:
                why = f"{len(undecided)} of {len(trials)} seeds have no value; {undecided[0]}"
                findings.checks += [not_tested(n, Kind.ANALYTIC, why) for n in names]
            return findings
        findings.evidence = Runs(
            engine.title, tuple(rows), tuple(curves), len(undecided), law_of(engine.traits)
        )
        findings.checks += self.judge(names, findings.evidence, p)
        return findings

    def across(self, beside: Mapping[str, Findings]) -> Sequence[Check]:
        """Hold every two engines against one another by their means over the seeds."""
        return list(self.compared([f.evidence for f in beside.values() if f.evidence is not None]))

    def compared(self, engines: Sequence[Runs]) -> Iterator[Check]:
        """Yield the rows that hold every two engines against one another."""
        for one, other in combinations(engines, 2):
            for quantity in self.equivalent:
                name = f"{self.name}: {one.engine} against {other.engine}: {quantity}"
                first, second = one.sample(quantity), other.sample(quantity)
                if min(len(first.values), len(second.values)) < FEWEST:
                    few = f"fewer than {FEWEST} seeds gave a value"
                    yield not_tested(name, Kind.CROSS_CODE, few)
                else:
                    check = equivalence(name, first, second, MARGIN)
                    yield differing(check, one.engine, one.law, other.engine, other.law)

    def sections(
        self,
        main: Findings | None,
        own: Findings,
        beside: Mapping[str, Findings],
    ) -> Sequence[Section]:
        """Return the curves of all runs and the means over the seeds."""
        every = [f.evidence for f in (main, *beside.values()) if f is not None and f.evidence]
        found = list({one.engine: one for one in every}.values())
        if not found:
            return ()
        words = Words(str(sys.modules[type(self).__module__].__file__))
        table = words.table("Means", list(self._means(found)))
        table = replace(table, head=("quantity", *(one.engine for one in found)))
        seeds = len(found[0].rows)
        drawings = tuple(
            words.drawing(
                curve.figure,
                lambda place=place, curve=curve: draw(found, place, curve),  # type: ignore[misc]
                seeds=seeds,
            )
            for place, curve in enumerate(self.drawn)
        )
        return (words.section(self.name, tables=(table,), drawings=drawings),)

    def _means(self, engines: Sequence[Runs]) -> Iterator[tuple[str, ...]]:
        """Yield the rows of the table: a quantity, its mean and interval in each engine."""
        for quantity in self.quantities:
            cells = []
            for one in engines:
                if any(quantity.name not in row for row in one.rows):
                    cells.append("not measured")
                    continue
                sample = one.sample(quantity.name)
                text = f"{sample.mean:.4g}"
                if len(sample.values) >= FEWEST:
                    low, high = interval(sample.values, confidence=0.95)
                    text += f" ({low:.4g} to {high:.4g})"
                cells.append(text)
            unit = quantity.unit if quantity.unit != "1" else "-"
            yield f"{quantity.name} ({unit})", *cells


QUICK = 3.0
"""[us] for a step of ten particles: slower engines are not run at level quick."""


def too_slow(engine: Engine, level: LevelName) -> str:
    """Return why an engine is not run at a level, or nothing where it is."""
    cost = engine.traits.microseconds_per_step
    if level != "quick" or cost <= QUICK:
        return ""
    return (
        f"it takes {cost:g} us for a step of ten particles, beyond the {QUICK:g} us of level "
        "quick, which is to end within minutes; level default runs it"
    )


def draw(engines: Sequence[Runs], place: int, curve: Curve) -> Figure:
    """Draw a curve of every seed, a colour for each engine."""
    from matplotlib.figure import Figure

    from harness.report.style import COLOURS

    figure = Figure(figsize=(7.0, 3.6), layout="constrained")
    axes = figure.subplots()
    for number, one in enumerate(engines):
        for seed, curves in enumerate(one.curves):
            x, y = curves[place]
            label = one.engine if seed == 0 else None
            axes.plot(x, y, color=COLOURS[number], lw=0.9, alpha=0.7, label=label)
    axes.set(xlabel=curve.x, ylabel=curve.y)
    axes.legend(title="code; a line for each seed")
    return figure
