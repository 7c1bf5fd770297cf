"""Means over seeds, their intervals, and whether two of them are equivalent.

Bulk is chaotic: motions of one bed part between codes, means over beds need not. Two codes are
equivalent where the 90 % interval of the ratio of their means is within a margin that was stated
before: two one-sided tests at 5 % each (Schuirmann, J. Pharmacokinet. Biopharm. 15, 657 (1987)).
They are not where it is outside of the margin as a whole; else nothing is decided.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from harness.comparison.verdicts import (
    Check,
    Kind,
    Tolerance,
    Triage,
    Verdict,
    judge,
    not_tested,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

FEWEST = 4
"""Seeds of which an interval is computed: the bootstrap of fewer has too few samples to draw."""

RESAMPLES = 9999

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
    """Return the bootstrap interval of a mean, or of the ratio of the means of two samples.

    Bias-corrected and accelerated (Efron 1987) for a mean, percentiles for a ratio; the same
    numbers for the same samples.
    """
    import numpy as np
    from scipy.stats import bootstrap

    def statistic(*data: NDArray[np.float64], axis: int = -1) -> NDArray[np.float64]:
        first, *second = (np.asarray(np.mean(values, axis=axis)) for values in data)
        return np.divide(first, second[0]) if second else first

    if all(len(set(values)) == 1 for values in samples):
        value = float(statistic(*(np.asarray(values) for values in samples)))
        return value, value
    bounds = bootstrap(
        samples,
        statistic,
        n_resamples=RESAMPLES,
        confidence_level=confidence,
        method="BCa" if len(samples) == 1 else "percentile",
        rng=np.random.default_rng(1),
    ).confidence_interval
    return float(bounds.low), float(bounds.high)


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
        f"{first.mean:.6g} over {len(first.values)} seeds in {first.engine}, "
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
