"""Bulk cases: a system from many seeds, means over them, engines against one another.

Bulk is chaotic: motions of one seed part between codes, so that means over seeds are compared.
``beds`` has the parameters that the cases share, ``comparison`` the means and what is compared.
"""

from __future__ import annotations

import inspect
import math
from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Generic, NamedTuple, TypeVar

import numpy as np

from harness.cases.base import LEVELS, Case, Check, Level, Quantity
from harness.cases.bench import OWN, Bench
from harness.cases.bulk import comparison
from harness.cases.bulk.beds import Bed, BedOfOneKind, Floats
from harness.cases.bulk.comparison import ALLOWED, TIME, Sample, StatedLaw, mean_interval
from harness.engines.base import Engine, Job, Output, Template
from harness.engines.output import Table
from harness.errors import (
    EngineError,
    EngineLostAtomsError,
    EngineOutputError,
    EngineUndecidedError,
    Unsupported,
)
from harness.model.base import allowed_in, descriptions
from harness.report import content
from harness.results.rows import Kind, Tolerance

if TYPE_CHECKING:
    from matplotlib.figure import Figure

B = TypeVar("B", bound=Bed)
Line = tuple[Sequence[float] | Floats, Sequence[float] | Floats]  # x and z of its points [m]
Measured = Callable[[Sample], Any]

AT_REST = 0.01  # kinetic energy of a bed at rest over that of its process
SLOW = 3.0  # [us] of a step of ten particles: slower engines leave long setups to longer levels
SECONDS_PER_STEP = 4e-6  # of a particle in the slowest code, for time limits
LONGEST_GAP = 1.5  # [shortest interval between two rows] as some codes are a step late
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
COUNTS = ("remaining", "astray", "count")  # columns that may stay as they are
# bounds of physics: lowest, highest, reason
LOOSE = "grains at rest fill 0.55 at least (Onoda and Liniger 1990), beside walls less, and "
LOOSE += "pi/sqrt(18) at most; a lattice that never settled 0.3"
SOLID = 0.4, 0.74, LOOSE
REPOSE = 5.76, 90.0, "grains without any friction hold 5.76 deg (Peyneau and Roux 2008)"  # [deg]
ELASTIC = "elastic_ratio"  # energy of the bed's normal springs over the scale of energy gained
BED_STATE = (
    Quantity[Any]("bed_solid_fraction", "1", "of the bed at rest, up to its level surface", 0.5),
    Quantity[Any]("bed_coordination", "1", "contacts of a grain in the bed at rest", 5.0),
)
WALL_TIME = Quantity[Any](TIME, "us", "wall time of a particle and step, of a run among others")
MEANS = "Means over the runs, with intervals of 95 % (Student). Times are wall times of runs side "
MEANS += "by side: no comparison of speeds."


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
    runs = [parameters.replace(seed=seed) for seed in range(1, max(seeds.values()) + 1)]
    return [
        Setup(f"{system}, {n} seeds".removeprefix(", "), system, tuple(runs[:n]), level, compared)
        for level, n in seeds.items()
    ]


class Curve(NamedTuple):
    """A curve of each run: columns ``x`` and ``y`` in SI units and degrees, with their labels.

    ``scale`` are the units of the axes over those of the columns.
    """

    name: str
    title: str
    x: str
    x_label: str
    y: str
    y_label: str
    scale: tuple[float, float] = (1.0, 1.0)


class Plane(NamedTuple):
    """The plane of a film: its y [m], the walls in it, each radius [m] unless a run writes it."""

    y: float
    walls: Sequence[Line]
    radii: Floats | None = None


class BulkCase(Case[B]):
    """A system of many grains, run from several seeds (parameter ``seed``).

    Its scripts have the case's name in each engine, and take the parameters as values. The
    docstring of a case is its summary, and below it its ``text``.
    """

    group = "bulk"
    has_figures = True
    parameters: ClassVar[type[Bed]]
    template: ClassVar[Template]
    text: ClassVar[str]
    series: ClassVar[tuple[str, ...]]  # columns of a run, a clock first
    curves: ClassVar[tuple[Curve, ...]]
    setups: ClassVar[Sequence[Setup[Any]]]  # what is verified
    gain: ClassVar[str]  # quantity: energy gained
    rest: ClassVar[str] = "bed_kinetic_ratio"  # quantity: energy of the bed before it is disturbed
    rest_scale: ClassVar[str]  # energy of which a bed at rest has 1 % at most

    def __init_subclass__(cls, **more: Any) -> None:
        """Make the template of the case from its parameters."""
        super().__init_subclass__(**more)
        cls.summary, _, text = inspect.cleandoc(cls.__doc__ or "").partition("\n\n")
        cls.text, kind = " ".join(text.split()), cls.parameters
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
    def _quantities(self, p: B, output: Output, table: Table) -> dict[str, float]:
        """Return the quantities of a run but for its wall time; ``table`` is its series.

        Raise EngineOutputError for another number of grains, EngineLostAtomsError for one beyond a
        wall, EngineUndecidedError for a process that did not end.
        """

    @abstractmethod
    def columns(self, p: B, table: Table) -> dict[str, Floats]:
        """Return the columns of :attr:`curves`, each (M,)."""

    @abstractmethod
    def _plane(self, p: B) -> Plane:
        """Return the plane of a film."""

    def _elastic_bound(self, p: B, sample: Sample) -> float:
        """Return a bound of :data:`ELASTIC` for engines that do not measure it."""
        return math.nan

    def _more_checks(self, setup: Setup[B]) -> Iterable[Check]:
        """Return the checks of an engine by itself beyond energy gained and bed at rest."""
        return ()

    # ---- runs

    def job(self, parameters: B, law: StatedLaw | None = None) -> Job:
        """Return the job of a run, perhaps under a law; raise RequestError for a bad bed."""
        values = parameters.values if law is None else law.values(parameters.values)
        seconds = SECONDS_PER_STEP * self.cost(parameters)
        return Job(self.template, values, sampled=True, seconds=seconds)

    def cost(self, parameters: B) -> float:
        """Return the steps of a run times its grains; half of those that leave count."""
        staying = 0.5 if parameters.LEAVING else 1
        steps = parameters.settle_steps + parameters.steps * staying
        return float(parameters.grains * steps)

    def measure(self, parameters: B, output: Output) -> Mapping[str, float]:
        """Return the quantities of a run.

        Raise EngineOutputError for a series that lacks rows and for other numbers of steps or
        grains, EngineLostAtomsError for a grain beyond a wall, EngineUndecidedError for a process
        that did not end.
        """
        p, table = parameters, output.table(self.series)
        output.check_numbers({"steps": p.settle_steps + p.steps})
        _check_rows(p, output, table)
        for name in self.series[1:]:
            if name not in COUNTS and not np.ptp(table[name], axis=0).any():
                raise EngineOutputError(f"{output.engine} left a series whose {name} never changes")
        moved = p.every * table["remaining"].sum() if p.LEAVING else p.grains * p.steps
        seconds = output.seconds / (p.grains * p.settle_steps + moved)
        return {**self._quantities(p, output, table), TIME: float(1e6 * seconds)}

    def profile(self, parameters: B, output: Output) -> Mapping[str, Sequence[float]]:
        """Return the curves over the abscissa of the first one."""
        x, columns = self.curves[0].x, self.columns(parameters, output.table(self.series))
        names = [x, *(curve.y for curve in self.curves if curve.x == x)]
        return {name: columns[name].tolist() for name in names}

    def film_job(self, parameters: B, frames: int) -> Job:
        """Return the job whose series is that of all particles."""
        job = self.job(parameters)
        values = {**job.values, "series_every": max(1, parameters.steps // (frames - 1))}
        if self._plane(parameters).radii is None:
            values["particles"] = 1
        return replace(job, values=values)

    def discs(self, parameters: B, output: Output) -> content.Discs:
        """Return the film of a cut through the middle."""
        step = output.table(("step",))["step"] - parameters.settle_steps
        time = step * parameters.step_size
        return plane_discs(self.title, output, time, *self._plane(parameters))

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
                curves.append(self.columns(p, outcome.table(self.series)))
        return Sample(tuple(rows), tuple(curves), tuple(undecided))

    # ---- an engine by itself, and against another one

    def checks(self, engine: Engine) -> Iterable[Check]:
        """Return the checks of an engine by itself."""
        for setup in self.setups:
            jobs, level = [self.job(p) for p in setup.runs], setup.level_in(engine)
            for check in (*self._bed_checks(setup), *self._more_checks(setup)):
                yield replace(check, level=level, jobs=jobs)

    def comparisons(self, engines: Sequence[Engine]) -> Iterable[tuple[Engine, Check]]:
        """Return the comparisons of every two engines in every setup that both can run."""
        return comparison.comparisons(self, engines)

    def _bed_checks(self, setup: Setup[B]) -> Iterator[Check]:
        """Yield that no seed gains more energy than its bed's springs hold, and that beds rest.

        A bed swings for a time that its law decides, in each code alike: where it still moves, the
        time to settle is too short, and no code is at fault.
        """
        p = setup.runs[0]

        springs = partial(self._springs, p)

        def worst(sample: Sample) -> int:
            return int(np.argmax(sample.values(self.gain) - springs(sample)))

        def motion(sample: Sample) -> float:
            values = sample.values(self.rest)
            if p.settle_steps and not values.all():
                raise EngineOutputError("a bed that has settled has no kinetic energy at all")
            value = float(values.max())
            if value > AT_REST:
                raise Unsupported(
                    f"the bed is not at rest: it has {value:.2%} of {self.rest_scale}, must have "
                    f"{AT_REST:.0%} at most; settle_time = {p.settle_time:g} s is too short"
                )
            return value

        stored = "energy of the bed's springs at rest, tangential ones at most "
        stored += f"{p.tangential_share:.2g} times the normal ones"
        yield self.check(
            setup, self.gain, lambda s: float(s.values(self.gain)[worst(s)]),
            tolerance=lambda s: Tolerance(float(springs(s)[worst(s)]), reason=stored),
        )  # fmt: skip
        moving = f"a bed that moves adds 1 % to {self.rest_scale} at most"
        yield self.check(setup, self.rest, motion, tolerance=Tolerance(AT_REST, reason=moving))
        if BED_STATE[0] in self.quantities:
            yield self.bound_check(setup, BED_STATE[0].name, *SOLID)

    def _springs(self, p: B, sample: Sample) -> Floats:
        """Return the most that springs hold at rest, over the scale of energy gained, (runs,)."""
        energies = sample.values(ELASTIC) * (1.0 + p.tangential_share)
        if np.isfinite(energies).all():
            return energies
        return np.full(len(energies), self._elastic_bound(p, sample))

    def bound_check(
        self, setup: Setup[B], quantity: str, low: float, high: float, reason: str
    ) -> Check:
        """Return the check that a quantity of each run is between two bounds of physics."""
        middle, half = 0.5 * (low + high), 0.5 * (high - low)

        def farthest(sample: Sample) -> float:
            values = sample.values(quantity)
            return float(values[np.abs(values - middle).argmax()])

        tolerance = Tolerance(half, reason=f"{low:g} to {high:g}: {reason}")
        return self.check(setup, quantity, farthest, middle, tolerance)

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

    # ---- report

    def sections(self, benches: Mapping[str, Bench]) -> Sequence[content.Section]:
        """Return a section for each system, of its setup with most runs that was run."""
        sections = {}
        for setup in self.setups:
            jobs = [self.job(p) for p in setup.runs]
            samples = {}
            for name, bench in benches.items():
                if name != OWN and bench.has_run(jobs):
                    with suppress(EngineError):  # its rows have it
                        samples[bench.engine.title] = self.sample(bench, setup)
            if samples := {title: sample for title, sample in samples.items() if sample.rows}:
                sections[setup.system] = self._section(setup, samples)
        return [*sections.values()]

    def _section(self, setup: Setup[B], samples: Mapping[str, Sample]) -> content.Section:
        """Return the section of a setup: means of each engine, and the curves of all runs."""
        import pandas as pd

        columns = {"quantity": [f"{q.name} ({q.unit})" for q in self.quantities]}
        for title, sample in samples.items():
            columns[title] = [_mean_text(sample.values(q.name)) for q in self.quantities]
        stem = "-".join((self.name, *setup.name.replace(",", "").split()))
        caption = f"A line for each run, {setup.name}."
        drawings = tuple(
            content.Drawing(f"{stem}-{c.name}", c.title, caption, partial(_curve, c, samples))
            for c in self.curves
        )
        title = f"{self.title}: {setup.system}" if setup.system else self.title
        table = content.Table("Means", pd.DataFrame(columns), MEANS)
        return content.Section(f"{title}, {setup.name}", self.text, (table,), drawings)


# ---- one run


def _check_rows(p: Bed, output: Output, table: Table) -> None:
    """Raise EngineOutputError where rows of a series are missing, or its clock is wrong."""
    stepped = "time_s" not in table
    times = p.step_size * (table["step"] - p.settle_steps) if stepped else table["time_s"]
    end = p.step_size * p.steps
    gaps = np.diff(times, prepend=min(0.0, times[0]), append=max(end, times[-1]))
    inner = gaps[1:-1]
    if not inner.size or gaps.max() > LONGEST_GAP * inner.min():
        start = [0.0, *times][int(gaps.argmax())]
        raise EngineOutputError(
            f"{output.engine} left a series that lacks rows: none for {gaps.max():.4g} s after "
            f"{start:.4g} s"
        )
    if abs(times[-1] - end) > 0.5 * inner.min():
        raise EngineOutputError(
            f"{output.engine} left a series whose clock is wrong: it ends at {times[-1]:.6g} s, "
            f"the run at {end:.6g} s"
        )


def check_grains(p: BedOfOneKind, output: Output, table: Table, beyond: str) -> None:
    """Raise EngineLostAtomsError for a grain that is ``beyond`` the walls.

    The output has the number within the walls as the bed is disturbed, the series the number
    beyond them later.
    """
    within = output.number("grains")
    times = [0.0] if within < p.grains else table["time_s"][table["astray"] != 0.0]
    if len(times):
        raise EngineLostAtomsError(
            f"{output.engine}: a grain is {beyond} at {times[0]:.3g} s: the walls leave a hole, "
            f"step_size = {p.step_size:g} s is too long or youngs_modulus = "
            f"{p.youngs_modulus:g} Pa too small"
        )
    output.check_numbers({"grains": p.grains})


def energy_rise(output: Output, table: Table) -> float:
    """Return the largest rise [J] of kinetic and potential energy above what it was before."""
    later = table["kinetic_J"] + table["potential_J"]
    energy = np.concatenate([[output.number("released_J")], later])
    return float((energy - np.minimum.accumulate(energy)).max())


# ---- texts, figures and films


def _mean_text(values: Floats) -> str:
    if np.isnan(values).any():
        return "not measured"
    low, high = mean_interval(values)
    text = f"{values.mean():.4g}"
    return text if math.isnan(low) else f"{text} ({low:.4g} to {high:.4g})"


def _curve(curve: Curve, samples: Mapping[str, Sample]) -> Figure:
    """Return a curve of every run, each engine in its colour."""
    from harness.report.figures import COLOURS, panels

    figure = panels(1, 1, 7.0, 2.8)
    (axes,) = figure.axes
    across, up = curve.scale
    for colour, (title, sample) in zip(COLOURS, samples.items(), strict=False):
        for run, columns in enumerate(sample.curves):
            line = across * columns[curve.x], up * columns[curve.y]
            axes.plot(*line, color=colour, lw=0.9, alpha=0.7, label=None if run else title)
    axes.set(xlabel=curve.x_label, ylabel=curve.y_label)
    axes.legend()
    return figure


def plane_discs(
    title: str, output: Output, time: Floats, y: float, lines: Sequence[Line],
    radius: Floats | None = None,
) -> content.Discs:  # fmt: skip
    """Return the discs in which the plane at ``y`` [m] cuts all particles, from time 0 [s] on.

    ``lines`` are walls, each x and z of its points [m]; ``radius`` (N,) [m] unless the output has
    it. Colours are heights at the start of the film.
    """
    table = output.table(("step", "x_m", "y_m", "z_m"))
    after = time >= 0.0
    x, off, z = (table[f"{axis}_m"][after] for axis in "xyz")
    radius = table["radius_m"][0] if radius is None else radius
    cut = np.sqrt(np.maximum(radius**2 - (off - y) ** 2, 0.0))
    points = [np.array(line, dtype=float).T for line in lines]
    walls = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in points])
    return content.Discs(title, time[after], x, z, cut, lines=walls,
                         value=np.broadcast_to(z[0], x.shape),
                         value_label="height at the start (m)")  # fmt: skip
