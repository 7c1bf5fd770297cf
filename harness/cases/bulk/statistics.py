"""Means over seeds, their intervals, and whether two of them are equivalent.

Two codes are equivalent where the 90 % interval of the ratio of their means is within a margin that
was stated before: two one-sided tests at 5 % each (Schuirmann, J. Pharmacokinet. Biopharm. 15, 657
(1987)). They are not where it is outside of the margin as a whole; else nothing is decided.
Intervals are Student's of a mean and Welch's of a ratio: percentiles of a bootstrap are too narrow
for few values, and would err in 10 % of all cases for 4 seeds in place of 5 %.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from harness.cases.base import Value
from harness.cases.bulk.mixing import Floats
from harness.errors import Unsupported
from harness.results.rows import Failure, Tolerance

FEWEST = 4  # seeds of an interval: fewer rest on the normal distribution alone
CONFIDENCE = 0.90  # of the interval of a ratio: two one-sided tests of 5 %
MARGIN = 0.05
EQUIVALENT = Tolerance(
    MARGIN,
    reason="stated before any run: codes are equivalent where the 90 % interval of the ratio of "
    "their means is within 5 % of 1, two one-sided tests of 5 %",
    whole_interval=True,
)
CHANCE = 0.01  # share of cases in which equal codes fail Fisher's test
BY_CHANCE = Tolerance(
    1.0 - CHANCE, reason="chance alone gives such a difference of shares in 1 % of cases"
)
CLOCKS = frozenset({"microseconds_per_particle_step"})  # differ between runs that are the same


def mean_interval(values: Floats, confidence: float = 0.95) -> tuple[float, float]:
    """Return Student's interval of a mean; of fewer than :data:`FEWEST` values NaN."""
    from scipy.stats import ttest_1samp

    if len(values) < FEWEST:
        return math.nan, math.nan
    if not np.ptp(values):
        return float(values[0]), float(values[0])
    interval = ttest_1samp(values, 0.0).confidence_interval(confidence)
    return float(interval.low), float(interval.high)


def ratio_of_means(first: Floats, second: Floats) -> Value:
    """Return the ratio of two means with the half width of its interval.

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
    low, high = test.confidence_interval(CONFIDENCE)
    return Value(ratio, float(0.5 * (high - low) / abs(below)), note)


def check_different(rows: Sequence[Mapping[str, float]], title: str) -> None:
    """Raise Unsupported where fewer than :data:`FEWEST` runs differ in more than their time.

    A code that ignores the seed has runs that are all the same, and no spread.
    """
    different = {tuple(v for name, v in row.items() if name not in CLOCKS) for row in rows}
    if len(different) < FEWEST:
        raise Unsupported(f"fewer than {FEWEST} different runs gave a value in {title}")


def same_shares(first: tuple[int, int], second: tuple[int, int]) -> Value:
    """Return Fisher's p [-] for equal shares of runs without a value, 1 for equal ones.

    ``first`` and ``second`` are the runs with and without. Means are over runs with a value: of
    engines that differ in how many have none, means decide nothing.
    """
    from scipy.stats import fisher_exact

    note = " and ".join(f"{without} of {of + without}" for of, without in (first, second))
    p = float(fisher_exact(np.array([first, second])).pvalue)
    return Value(p, note=f"without a value: {note}")
