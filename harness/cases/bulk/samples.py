"""What runs of a setup leave: series and their checks, means over seeds, equivalence of two codes.

Two codes are equivalent where the 90 % interval of the ratio of their means is within a margin that
was stated before: two one-sided tests at 5 % each (Schuirmann, J. Pharmacokinet. Biopharm. 15, 657
(1987)). They are not where it is outside of the margin as a whole; else nothing is decided.
Intervals are Student's of a mean and Welch's of a ratio: percentiles of a bootstrap are too narrow
for few values, and would err in 10 % of all cases for 4 seeds in place of 5 %.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from harness.cases.base import Value
from harness.cases.bulk.beds import Bed, BedOfOneKind, Floats
from harness.engines.output import Output, Table
from harness.errors import EngineLostAtomsError, EngineOutputError, Unsupported
from harness.results.rows import Failure, Tolerance

LONGEST_GAP = 1.5  # [shortest interval between two rows] as some codes are a step late
TIME = "microseconds_per_particle_step"  # differs between runs that are the same
FEWEST = 4  # seeds of an interval: fewer rest on the normal distribution alone
EQUIVALENT = Tolerance(
    0.05,
    reason="stated before any run: codes are equivalent where the 90 % interval of the ratio of "
    "their means is within 5 % of 1, two one-sided tests of 5 %",
    whole_interval=True,
)
BY_CHANCE = Tolerance(
    0.99, reason="chance alone gives such a difference of shares in 1 % of cases"
)  # of Fisher's p, from 1


# ---- one run


def read_series(p: Bed, output: Output, columns: Sequence[str], **expected: int) -> Table:
    """Return the series of a run; the first column is ``time_s`` or ``step``.

    Raise EngineOutputError where rows are missing, and where ``expected`` results or the number of
    steps differ from those of the parameters.
    """
    output.check_numbers({**expected, "steps": p.settle_steps + p.steps})
    table = output.table(columns)
    steps = columns[0] == "step"
    times = table["step"] - p.settle_steps if steps else table["time_s"]
    end = p.steps * (1.0 if steps else p.step_size)
    gaps = np.diff(times, prepend=min(0.0, times[0]), append=max(end, times[-1]))
    inner = gaps[1:-1]
    if not inner.size or gaps.max() > LONGEST_GAP * inner.min():
        start = [0.0, *times][int(gaps.argmax())]
        raise EngineOutputError(
            f"{output.engine} left a series that lacks rows: none for {gaps.max():.4g} after "
            f"{start:.4g}"
        )
    return table


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
    if within > p.grains:
        raise EngineOutputError(f"{output.engine} began with {within:.0f} grains of {p.grains}")


def energy_rise(output: Output, table: Table) -> float:
    """Return the largest rise [J] of kinetic and potential energy above what it was before."""
    later = table["kinetic_J"] + table["potential_J"]
    energy = np.concatenate([[output.number("released_J")], later])
    return float((energy - np.minimum.accumulate(energy)).max())


def time_per_step(p: Bed, output: Output, table: Table) -> dict[str, float]:
    """Return the wall time of a particle and step [us], of those that remain."""
    moved = p.every * table["remaining"].sum() if "remaining" in table else p.grains * p.steps
    return {TIME: float(1e6 * output.seconds / (p.grains * p.settle_steps + moved))}


# ---- runs of a setup


class Sample(NamedTuple):
    """The runs of a setup in an engine: quantities of each run with a value, and its curves.

    ``undecided`` are the reasons of runs that ended without the event that they wait for.
    """

    rows: tuple[Mapping[str, float], ...]
    curves: tuple[Mapping[str, Floats], ...]
    undecided: tuple[str, ...]

    def decided(self) -> Sample:
        """Return the sample; raise Unsupported where no run has a value."""
        if not self.rows:
            runs = len(self.undecided)
            raise Unsupported(f"{runs} of {runs} runs have no value; {self.undecided[0]}")
        return self

    def values(self, quantity: str) -> Floats:
        """Return the values of a quantity over the runs, (runs,); NaN where it is not measured."""
        return np.array([row.get(quantity, math.nan) for row in self.rows])

    def mean(self, quantity: str) -> float:
        """Return the mean over the runs."""
        return float(self.values(quantity).mean())

    def mean_value(self, quantity: str, note: str = "") -> Value:
        """Return the mean with the half width of its 95 % interval, of few runs without one."""
        low, high = mean_interval(self.values(quantity))
        half = 0.0 if math.isnan(low) else 0.5 * (high - low)
        return Value(self.mean(quantity), half, note)

    def check_spread(self, title: str) -> None:
        """Raise Unsupported where fewer than :data:`FEWEST` runs differ in more than their time.

        A code that ignores the seed has runs that are all the same, and no spread.
        """
        different = {tuple(v for name, v in row.items() if name != TIME) for row in self.rows}
        if len(different) < FEWEST:
            raise Unsupported(f"fewer than {FEWEST} different runs gave a value in {title}")


def mean_interval(values: Floats) -> tuple[float, float]:
    """Return Student's 95 % interval of a mean; of fewer than :data:`FEWEST` values NaN."""
    from scipy.stats import ttest_1samp

    if len(values) < FEWEST:
        return math.nan, math.nan
    if not np.ptp(values):
        return float(values[0]), float(values[0])
    interval = ttest_1samp(values, 0.0).confidence_interval(0.95)
    return float(interval.low), float(interval.high)


def ratio_of_means(first: Floats, second: Floats) -> Value:
    """Return the ratio of two means with the half width of its 90 % interval.

    The ratio r of means a and b is off by (a - r b)/b, to first order in the error of b: the
    interval is Welch's (Biometrika 34, 28 (1947)) of the difference of a and r b, over b. Raise
    Unsupported where both means are 0; a mean that is not finite, or 0 in the second engine alone,
    is a failure.
    """
    from scipy.stats import ttest_ind

    above, below = float(first.mean()), float(second.mean())
    if below == 0.0 and (second.any() or not first.any()):
        raise Unsupported("the mean of the second engine is 0: there is no ratio of means")
    note = f"means {above:.6g} over {len(first)} runs and {below:.6g} over {len(second)}"
    if below == 0.0 or not math.isfinite(above + below):
        return Value(math.nan, math.nan, note, Failure.NOT_A_NUMBER)
    ratio = above / below
    if not np.ptp(first) and not np.ptp(second):
        return Value(ratio, 0.0, note)
    test = ttest_ind(first, ratio * second, equal_var=False)
    low, high = test.confidence_interval(0.90)
    return Value(ratio, float(0.5 * (high - low) / abs(below)), note)


def same_shares(first: Sample, second: Sample) -> Value:
    """Return Fisher's p [-] for equal shares of runs without a value, 1 for equal ones.

    Means are over runs with a value: of engines that differ in how many have none, means decide
    nothing.
    """
    from scipy.stats import fisher_exact

    counts = np.array([(len(sample.rows), len(sample.undecided)) for sample in (first, second)])
    note = " and ".join(f"{without} of {of + without}" for of, without in counts)
    return Value(float(fisher_exact(counts).pvalue), note=f"without a value: {note}")
