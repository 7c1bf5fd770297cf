"""Bulk cases: a system from many seeds or places, means over them, engines against one another.

Bulk is chaotic: motions of one seed part between codes, so that means over seeds are compared.
Where a code follows the law by other rules than the main engine, the main engine runs the seeds
under these rules too: then the two are held against one another, and what the rules do is shown.
"""

from __future__ import annotations

import math
import re
import sys
from abc import abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np

from harness.cases.bulk.equivalence import (
    FEWEST,
    Sample,
    equivalence,
    interval,
    same_shares,
)
from harness.cases.bulk.materials import PACKED, Bed
from harness.cases.bulk.rules import Law, differing, law_of
from harness.cases.contract import LEVELS, Case, LevelName
from harness.cases.display import Display
from harness.cases.text import Words
from harness.cases.verification import Study, Verification
from harness.comparison.verdicts import (
    Check,
    Kind,
    Planned,
    Tolerance,
    failed_run,
    finding,
    not_tested,
)
from harness.comparison.verification import Findings
from harness.engines.contract import Engine, Job, Output
from harness.engines.cost import engine_seconds
from harness.engines.traits import Traits
from harness.errors import EngineError, EngineUndecidedError
from harness.report.sections import Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from harness.cases.bulk.film import Cut
    from harness.report.film import Film

    Floats = NDArray[np.float64]

P = TypeVar("P", bound=Bed)

MARGIN = Tolerance(
    "",
    0.0,
    0.05,
    "stated before any run: codes are equivalent where the 90 % interval of the ratio of their "
    "means is within 5 % of 1, two one-sided tests of 5 %",
)


@dataclass(frozen=True)
class Curve:
    """A curve of each run: the name of its figure, the labels of its axes, its columns in a table.

    Columns are in SI units and degrees; ``scale`` are those of the axes in them.
    """

    figure: str
    x: str
    y: str
    columns: tuple[str, str]
    scale: tuple[float, float] = (1.0, 1.0)


@dataclass(frozen=True)
class System:
    """What is verified: how its rows are called, and its parameters.

    ``trials`` are the parameters of its runs by what they are called, where these are not seeds.
    ``equivalent`` are the quantities that codes are held against one another in, where they are not
    those of the case; () for a system that is shown alone. Engines slower than :data:`QUICK` run it
    ``from_level`` on.
    """

    name: str
    parameters: Any
    trials: Mapping[str, Any] = field(default_factory=dict)
    equivalent: tuple[str, ...] | None = None
    from_level: LevelName = "default"


TIMES = frozenset({"microseconds_per_particle_step"})
"""Quantities by which runs differ that are the same."""


@dataclass(frozen=True)
class Runs:
    """The runs of an engine: quantities of each seed, and its curves, each (x, y).

    ``undecided`` runs ended without the event that they wait for, and have no row; ``why`` says it
    of the first. ``law`` says by which rules the engine follows the law, ``rules`` whose they are
    where they are not its own. ``main`` is the main engine under these rules where its own are
    others, or why it cannot be. ``system`` is the name of what is simulated, ``equivalent`` what
    codes are held against one another in.
    """

    engine: str
    rows: tuple[Mapping[str, float], ...]
    curves: tuple[tuple[tuple[Floats, Floats], ...], ...] = ()
    undecided: int = 0
    why: str = ""
    law: Law = field(default_factory=Law)
    rules: str = ""
    main: Runs | str | None = None
    system: str = ""
    equivalent: tuple[str, ...] = ()

    @property
    def title(self) -> str:
        """Return who ran, under whose rules."""
        return f"{self.engine} under the rules of {self.rules}" if self.rules else self.engine

    @property
    def different(self) -> int:
        """Return how many runs differ: of one that ignores its seed all rows are the same.

        But for the time that they took.
        """
        return len({tuple(v for n, v in row.items() if n not in TIMES) for row in self.rows})

    def sample(self, quantity: str) -> Sample:
        """Return the values of a quantity over the seeds."""
        return Sample(self.title, tuple(row[quantity] for row in self.rows))

    def worst(self, quantity: str) -> float:
        """Return the largest value over the seeds; NaN where one is."""
        return float(np.max(self.sample(quantity).values))


class BulkCase(Case[P]):
    """A system of many grains, run from several seeds (parameter ``seed``)."""

    group = "bulk"
    verified_by = "harness.cases.bulk.seeds:BulkVerification"
    shown_by = "harness.cases.bulk.seeds:BulkDisplay"
    seeds: ClassVar[Mapping[LevelName, int]]
    """Runs of a level."""
    judged: ClassVar[tuple[str, ...]]
    """Checks of an engine, in the order of :meth:`judge`."""
    equivalent: ClassVar[tuple[str, ...]]
    """Quantities that codes are held against one another in; the others are shown."""
    drawn: ClassVar[tuple[Curve, ...]]
    empties: ClassVar[bool] = False
    """Whether grains leave once the bed is disturbed, half of them on the mean."""

    @abstractmethod
    def judge(self, names: Sequence[str], runs: Runs, p: P) -> list[Check]:
        """Return the rows of an engine, by the names of :attr:`judged`; the worst seed decides."""

    @abstractmethod
    def curves(self, p: P, output: Output) -> Sequence[tuple[Floats, Floats]]:
        """Return x and y of each of :attr:`drawn`, in the units of its columns."""

    def profile(self, parameters: P, output: Output) -> Mapping[str, Sequence[float]]:
        """Return the curves over the x of the first one, as columns."""
        x = self.drawn[0].columns[0]
        columns: dict[str, Sequence[float]] = {}
        for curve, line in zip(self.drawn, self.curves(parameters, output), strict=True):
            if curve.columns[0] == x:
                columns |= dict(zip(curve.columns, (axis.tolist() for axis in line), strict=True))
        return columns

    def systems(self, level: LevelName) -> Sequence[System]:
        """Return what is verified at a level: the default, under the name of the case."""
        return (System(self.name, self.default),)

    def law(self, traits: Traits, parameters: P) -> Law:
        """Return by which rules an engine follows the law."""
        return law_of(traits)

    def seconds(self, parameters: P, rules: Traits | None, solver: str = "") -> float:
        """Return what a run is expected to take [s], good to a factor of three."""
        if rules is None:
            return 0.0
        disturbed = parameters.steps // 2 if self.empties else parameters.steps
        steps = parameters.settle_steps + disturbed
        return PACKED * engine_seconds(steps, parameters.grains, rules)

    @abstractmethod
    def cut(self, p: P) -> Cut:
        """Return what a film shows of a run."""

    def radii(self, p: P) -> Floats | None:
        """Return the radius of each particle (N,) [m]; None where the film's run writes them."""
        return None


class BulkVerification(Verification):
    """Runs the seeds of a level, judges the worst, and compares engines by their means."""

    case: BulkCase[Any]

    def names(self, engine: Engine, system: System) -> list[str]:
        """Return the names of the rows of an engine."""
        return [f"{system.name}: {engine.name}: {check}" for check in self.case.judged]

    def planned(self, level: LevelName, engine: Engine) -> Sequence[Planned]:
        """Return the checks of an engine; the comparison of engines names its own."""
        systems = self.case.systems(level)
        return [Planned(name) for system in systems for name in self.names(engine, system)]

    def run(self, engine: Engine, study: Study) -> Findings:
        """Run the systems of a level and judge them; a run without its event has no row.

        The main engine, which runs before others, also runs under others' rules. Its rows are there
        when it is held against others: then only its runs are returned.
        """
        main: Engine | None = study.once(
            (self.case.name, "main"), lambda: engine if study.role == "main" else None
        )
        done = study.once(
            (self.case.name, engine.name), lambda: self._verified(engine, study, main)
        )
        if main is None or main.name != engine.name or study.role == "main":
            return done
        return Findings(self.case.name, engine.name, evidence=done.evidence)

    def _verified(self, engine: Engine, study: Study, main: Engine | None) -> Findings:
        """Return the rows of an engine, with its runs of each system as evidence."""
        checks, evidence = [], []
        for system in self.case.systems(study.level):
            rows, runs = self._over_seeds(engine, study, main, system)
            checks += rows
            evidence += [runs] if runs.rows or runs.undecided else []
        return Findings(self.case.name, engine.name, checks, evidence=tuple(evidence))

    def _over_seeds(
        self, engine: Engine, study: Study, main: Engine | None, system: System
    ) -> tuple[list[Check], Runs]:
        """Return the rows of a system, and its runs; without any where none gave a value."""
        law = self.case.law(engine.traits, system.parameters)
        own = system.equivalent
        equivalent = self.case.equivalent if own is None else own
        runs = Runs(engine.title, (), law=law, system=system.name, equivalent=equivalent)
        trials = self.trials(study.level, system)
        names = self.names(engine, system)
        refused = engine.refuses(self.case.job(system.parameters))
        if reason := refused or too_slow(engine, study.level, system):
            return [not_tested(name, Kind.ANALYTIC, reason) for name in names], runs
        runs, checks = self._runs(engine, runs, trials)
        if not runs.rows:
            if runs.undecided:
                why = f"{runs.undecided} of {len(trials)} runs have no value; {runs.why}"
                checks += [not_tested(n, Kind.ANALYTIC, why) for n in names]
            return checks, runs
        checks += self.case.judge(names, runs, system.parameters)
        words = main and self.case.law(main.traits, system.parameters).words
        if law.values and main is not None and words != law.words:
            under, failed = study.once(
                (system.name, law.words), lambda: self._under(main, runs, trials)
            )
            # of engines of one law the first has the rows of failed runs
            study.once((system.name, law.words, "failed"), lambda: checks.extend(failed))
            runs = replace(runs, main=under)
        return checks, runs

    def trials(self, level: LevelName, system: System) -> Mapping[str, Any]:
        """Return the parameters of each run of a level."""
        if system.trials:
            return system.trials
        seeds = range(1, self.case.seeds[level] + 1)
        return {f"seed {seed}": system.parameters.replace(seed=seed) for seed in seeds}

    def _under(
        self, main: Engine, other: Runs, trials: Mapping[str, Any]
    ) -> tuple[Runs | str, list[Check]]:
        """Return the runs of the main engine under another's rules, or why it cannot state them."""
        law = other.law
        if reason := main.refuses(self._job(next(iter(trials.values())), law)):
            return f"{main.title} cannot state the rules of {other.engine}: {reason}", []
        near = replace(law, words="as near to them as its script states") if law.inexact else law
        ruled = replace(other, engine=main.title, rows=(), curves=(), law=near, rules=other.engine)
        runs, failed = self._runs(main, ruled, trials)
        return runs if runs.rows else "no run gave a value", failed

    def _job(self, trial: Any, law: Law | None) -> Job:
        job = self.case.job(trial)
        return replace(job, values=law.stated(job.values)) if law else job

    def _runs(
        self, engine: Engine, runs: Runs, trials: Mapping[str, Any]
    ) -> tuple[Runs, list[Check]]:
        """Return runs with rows and curves, and the checks of those that failed.

        A few at a time, so that an engine that keeps its runs goes on where it was stopped.
        """
        law = runs.law if runs.rules else None
        rows, curves, undecided, failed = [], [], [], []
        few = max(engine.workers, 1)
        outputs: list[Output | EngineError] = []
        jobs = [
            replace(self._job(trial, law), seconds=self.case.seconds(trial, engine.traits))
            for trial in trials.values()
        ]
        for first in range(0, len(jobs), few):
            outputs += engine.run(jobs[first : first + few])
        for (name, trial), output in zip(trials.items(), outputs, strict=True):
            try:
                if isinstance(output, EngineError):
                    raise output
                rows.append(self.case.measured(trial, output, engine.traits).values)
                curves.append(tuple(self.case.curves(trial, output)))
            except EngineUndecidedError as error:
                undecided.append(f"{name}: {error}")
            except EngineError as error:
                engine_title = runs.title if runs.rules else engine.name
                row = f"{runs.system}: {engine_title}: {name}"
                failed.append(failed_run(row, Kind.ANALYTIC, error))
        runs = replace(runs, rows=tuple(rows), curves=tuple(curves))
        return replace(runs, undecided=len(undecided), why="".join(undecided[:1])), failed

    def compare(self, engines: Mapping[str, Findings]) -> Sequence[Check]:
        """Hold every two engines against one another by their means over the seeds."""
        return [row for runs in by_system(engines.values()).values() for row in self.compared(runs)]

    def compared(self, engines: Sequence[Runs]) -> Iterator[Check]:
        """Yield the rows that hold every two engines against one another.

        All of one system. Then those of the main engine under the rules of each engine that has
        others: against that engine, and against itself, which is what the rules do, a finding.
        """
        for first, second in combinations(engines, 2):
            yield from self._pair(first, second)
        seen: set[str] = set()
        for runs in engines:
            if isinstance(runs.main, str):
                for quantity in runs.equivalent:
                    name = f"{runs.system}: the rules of {runs.engine}: {quantity}"
                    yield not_tested(name, Kind.CROSS_CODE, runs.main)
            elif runs.main is not None:
                yield from self._pair(runs.main, runs)
                own_rules = [other for other in engines if other.engine == runs.main.engine]
                if runs.main.title not in seen:
                    for other in own_rules:
                        yield from map(effect, self._pair(runs.main, other))
                seen.add(runs.main.title)

    def _pair(self, first: Runs, second: Runs) -> Iterator[Check]:
        """Yield the rows that hold two engines against one another."""
        counts = [(len(runs.rows), runs.undecided) for runs in (first, second)]
        if first.undecided or second.undecided:
            name = f"{first.system}: {first.title} against {second.title}: runs without a value"
            check = same_shares(name, *counts)
            yield differing(check, first.title, first.law, second.title, second.law)
        for quantity in first.equivalent:
            name = f"{first.system}: {first.title} against {second.title}: {quantity}"
            samples = first.sample(quantity), second.sample(quantity)
            few = min((first, second), key=lambda runs: runs.different)
            if few.different < FEWEST:
                why = f"fewer than {FEWEST} runs gave a value of their own in {few.title}"
                yield not_tested(name, Kind.CROSS_CODE, why)
            else:
                check = equivalence(name, *samples, MARGIN)
                yield differing(check, first.title, first.law, second.title, second.law)


class BulkDisplay(Display):
    """Shows the curves of all runs and the means over the seeds."""

    case: BulkCase[Any]

    def film_jobs(self, parameters: Any, frames: int) -> Sequence[Job]:
        """Return the job whose series is that of all particles."""
        from harness.cases.bulk.film import PARTICLES  # slow to load

        job = self.case.job(parameters)
        values = dict(job.values)
        values["series_every"] = max(1, int(values["steps"]) // (frames - 1))
        if self.case.radii(parameters) is None:
            values[PARTICLES] = 1
        return (replace(job, values=values),)

    def film(self, engine: Engine, parameters: Any, frames: int) -> Film:
        """Return the film of one run after its release, opening or first turn."""
        from harness.cases.bulk.film import bulk_film

        (job,) = self.film_jobs(parameters, frames)
        job = replace(job, seconds=self.case.seconds(parameters, engine.traits))
        title = self.case.summary.partition(":")[0]
        begins = float(job.values["settle_steps"])
        radii, cut = self.case.radii(parameters), self.case.cut(parameters)
        return bulk_film(engine, job, radii, begins, cut, title)

    def sections(
        self, main: Findings | None, solvers: Findings, engines: Mapping[str, Findings]
    ) -> Sequence[Section]:
        """Return a section for each system: the curves of all runs and the means over the seeds."""
        systems = by_system(f for f in (main, *engines.values()) if f is not None)
        return [
            self._section(name, with_values)
            for name, runs in systems.items()
            if (with_values := list({ran.engine: ran for ran in runs if ran.rows}.values()))
        ]

    def _section(self, system: str, engines: Sequence[Runs]) -> Section:
        """Return the section of a system: its words are under its name."""
        ruled = [ran.main for ran in engines if isinstance(ran.main, Runs)]
        under = list({ran.title: ran for ran in ruled}.values())
        words = Words(str(sys.modules[type(self.case).__module__].__file__))
        table = words.table("Means", list(self._means([*engines, *under])))
        table = replace(table, head=("quantity", *(ran.title for ran in (*engines, *under))))
        values = {"seeds": len(engines[0].rows), "system": re.sub(r"\W+", "-", system)}
        drawings = tuple(
            words.drawing(
                curve.figure,
                lambda place=place, curve=curve: draw(engines, place, curve),  # type: ignore[misc]
                **values,
            )
            for place, curve in enumerate(self.case.drawn)
        )
        return words.section(system, tables=(table,), drawings=drawings)

    def _means(self, engines: Sequence[Runs]) -> Iterator[tuple[str, ...]]:
        """Yield the rows of the table: a quantity, its mean and interval in each engine."""
        for quantity in self.case.quantities:
            cells = []
            for ran in engines:
                if any(quantity.name not in row for row in ran.rows):
                    cells.append("not measured")
                    continue
                sample = ran.sample(quantity.name)
                text = f"{sample.mean:.4g}"
                if len(sample.values) >= FEWEST:
                    low, high = interval(sample.values, confidence=0.95)
                    text += f" ({low:.4g} to {high:.4g})"
                cells.append(text)
            unit = quantity.unit if quantity.unit != "1" else "-"
            yield f"{quantity.name} ({unit})", *cells


def by_system(every: Iterable[Findings]) -> dict[str, list[Runs]]:
    """Return the runs of findings by the system that is simulated."""
    systems: dict[str, list[Runs]] = {}
    for findings in every:
        for runs in findings.evidence or ():
            systems.setdefault(runs.system, []).append(runs)
    return systems


QUICK = 3.0
"""[us] for a step of ten particles: slower engines run a system from a level on."""


def too_slow(engine: Engine, level: LevelName, system: System) -> str:
    """Return why an engine does not run a system at a level, or nothing where it does."""
    cost = engine.traits.microseconds_per_step
    if cost <= QUICK or LEVELS.index(level) >= LEVELS.index(system.from_level):
        return ""
    return (
        f"it takes {cost:g} us for a step of ten particles, beyond the {QUICK:g} us of level "
        f"{level}, which is to end within {'minutes' if level == 'quick' else 'hours'}; level "
        f"{system.from_level} runs it"
    )


def effect(check: Check) -> Check:
    """Return the comparison of an engine with itself under other rules: what they do, a finding."""
    if not math.isfinite(check.value):
        return check
    note = check.note.partition("; undecided")[0]
    note = f"what the rules do, in one code: {note}; its sign is not predicted"
    return finding(check.name, check.value, 1.0, "", note, uncertainty=check.uncertainty)


def draw(engines: Sequence[Runs], place: int, curve: Curve) -> Figure:
    """Draw a curve of every seed, and how far the mean of each engine is from that of all.

    With its standard error; a colour for each engine. A single engine has no difference.
    """
    from matplotlib.figure import Figure

    from harness.report.style import COLOURS

    panels = (2, 1) if len(engines) > 1 else (1,)
    figure = Figure(figsize=(7.0, 5.0 if len(panels) > 1 else 3.6), layout="constrained")
    (above,), *rest = figure.subplots(len(panels), sharex=True, height_ratios=panels, squeeze=False)
    across, up = curve.scale
    lines = [[(across * x, up * y) for x, y in (c[place] for c in r.curves)] for r in engines]
    ends = [(t[0], t[-1]) for of_engine in lines for t, _ in of_engine]
    x = np.linspace(max(first for first, _ in ends), min(last for _, last in ends), 200)
    every = [np.array([np.interp(x, *line) for line in of_engine]) for of_engine in lines]
    middle = np.concatenate(every).mean(axis=0)
    for runs, of_engine, values, colour in zip(engines, lines, every, COLOURS, strict=False):
        for seed, line in enumerate(of_engine):
            label = runs.engine if seed == 0 else None
            above.plot(*line, color=colour, lw=0.9, alpha=0.7, label=label)
        mean = values.mean(axis=0) - middle
        for (below,) in rest:
            below.plot(x, mean, color=colour, lw=1.2)
            if len(values) > 1:
                error = values.std(axis=0, ddof=1) / math.sqrt(len(values))
                below.fill_between(x, mean - error, mean + error, color=colour, alpha=0.25, lw=0.0)
    above.set(ylabel=curve.y)
    above.legend(title="code; a line for each run")
    for (below,) in rest:
        seeds = max(len(values) for values in every) > 1
        words = "mean of a code less that of all, with its standard error"
        words = words if seeds else "a code less the mean of all"
        below.set_title(words, fontsize=9)
        below.set(ylabel="difference")
    figure.axes[-1].set(xlabel=curve.x)
    return figure
