"""Means over seeds, their intervals, and whether two of them are equivalent.

Bulk is chaotic: motions of one bed part between codes, means over beds need not. Two codes are
equivalent where the 90 % interval of the ratio of their means is within a margin that was stated
before: two one-sided tests at 5 % each (Schuirmann, J. Pharmacokinet. Biopharm. 15, 657 (1987)).
They are not where it is outside of the margin as a whole; else nothing is decided.

Intervals are Student's of a mean and Welch's of a ratio. Percentiles of a bootstrap are narrower
for few values: a test that is meant to err in 5 % of all cases would in 6.5 % for 12 seeds, 10 %
for 4.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from harness.comparison.verdicts import (
    Check,
    Kind,
    Tolerance,
    Triage,
    Verdict,
    judge,
    not_tested,
)

FEWEST = 4
"""Seeds of which an interval is computed: of fewer it rests on the normal distribution alone."""

CONFIDENCE = 0.90
"""Of the interval of a ratio: two one-sided tests of 5 %."""


@dataclass(frozen=True)
class Sample:
    """A quantity of the runs of one engine, a value for each seed that gave one."""

    engine: str
    values: tuple[float, ...]

    @property
    def mean(self) -> float:
        """Return the mean over the seeds."""
        return sum(self.values) / len(self.values)


def interval(*samples: Sequence[float], confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Return the interval of a mean, or of the ratio of the means of two samples.

    The ratio r of means a and b is off by (a - r b)/b, to first order in what b is off: the
    interval is Welch's (Biometrika 34, 28 (1947)) of the difference of a and r b, over b.
    """
    import numpy as np
    from scipy.stats import t

    first, *second = (np.asarray(values, dtype=float) for values in samples)
    below = float(second[0].mean()) if second else 1.0
    middle = float(first.mean()) / below
    parts = [(first, 1.0), *((values, middle) for values in second)]
    variances = np.array([(scale / below) ** 2 * np.var(v, ddof=1) / v.size for v, scale in parts])
    if not variances.any():
        return middle, middle
    freedom = variances.sum() ** 2 / sum(variances**2 / [values.size - 1 for values, _ in parts])
    half = float(t.ppf(0.5 * (1.0 + confidence), freedom) * np.sqrt(variances.sum()))
    return middle - half, middle + half


CHANCE = 0.01
"""Of a difference of two shares of runs without a value that is held to be none."""

BY_CHANCE = Tolerance(
    "", 1.0 - CHANCE, 0.0, f"chance alone gives shares as far apart in {CHANCE:.0%} of all cases"
)


def same_shares(name: str, first: tuple[int, int], second: tuple[int, int]) -> Check:
    """Return whether two engines have as many runs without a value: its value is Fisher's p.

    ``first`` and ``second`` are the runs with and without a value. Means are of runs with one: of
    engines that differ in how many have none, means say nothing.
    """
    import numpy as np
    from scipy.stats import fisher_exact

    note = " and ".join(f"{without} of {of + without}" for of, without in (first, second))
    p = float(fisher_exact(np.array([first, second])).pvalue)
    return judge(name, Kind.CROSS_CODE, p, 1.0, BY_CHANCE, note=f"without a value: {note}")


def equivalence(name: str, first: Sample, second: Sample, margin: Tolerance) -> Check:
    """Return whether the ratio of the means of two engines is one within a margin.

    Not tested, as undecided, where the interval is too wide for a verdict, and where both means
    are 0. Values that are not finite, or 0 in one engine alone, fail.
    """
    if second.mean == 0.0 and (any(second.values) or not any(first.values)):
        why = f"the mean of {second.engine} is 0: there is no ratio of means"
        return not_tested(name, Kind.CROSS_CODE, why)
    if second.mean == 0.0 or not all(map(math.isfinite, (*first.values, *second.values))):
        ratio = math.nan if second.mean else math.inf
        note = f"{first.mean:.6g} in {first.engine}, {second.mean:.6g} in {second.engine}"
        return judge(name, Kind.CROSS_CODE, ratio, 1.0, margin, uncertainty=math.nan, note=note)
    ratio = first.mean / second.mean
    low, high = interval(first.values, second.values)
    note = (
        f"{first.mean:.6g} over {len(first.values)} runs in {first.engine}, "
        f"{second.mean:.6g} over {len(second.values)} in {second.engine}; "
        f"90 % interval of the ratio {low:.4f} to {high:.4f}"
    )
    half = max(ratio - low, high - ratio)
    row = judge(name, Kind.CROSS_CODE, ratio, 1.0, margin, uncertainty=half, note=note)
    width = margin.width(1.0)
    within = low >= 1.0 - width and high <= 1.0 + width
    outside = high < 1.0 - width or low > 1.0 + width
    if within or outside:
        return row
    why = f"{note}; undecided: the interval is partly beyond the margin of {width:g}"
    return replace(row, verdict=Verdict.NOT_TESTED, triage=Triage.NOT_TESTED, note=why)
