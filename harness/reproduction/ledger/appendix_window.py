"""Appendix B: the time over which the impulse is taken."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from harness.observables.windows import turnaround
from harness.parameters.tower import LAWS, Tower
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, claim, compare
from harness.reproduction.ledger.runs import (
    MEDIAN,
    contact_intervals,
    heights_with_structure_window,
    impulses,
    ratios,
    run,
)

_SPAN = 6.0  # [t0] over which returning contacts are looked for
_HEIGHTS = (1, 2, 3, 4, 9, 10, 19)

Intervals = dict[int, list[tuple[float, float]]]


def statements(printed: Printed) -> Iterator[Statement]:
    """Yield the rows of this part."""
    intervals = {n: contact_intervals(run(Tower(height=n), _SPAN)) for n in _HEIGHTS}
    yield from _packets(intervals, printed)
    yield from _windows(printed)
    yield from _largest_compression(intervals, printed)


def _packets(intervals: Intervals, printed: Printed) -> Iterator[Statement]:
    end = printed.first_packet
    late = {n: [one for one in found if one[0] >= end] for n, found in intervals.items()}
    last = {n: max(b for a, b in found if a < end) for n, found in intervals.items()}
    told = {n: [f"{a:.2f} to {b:.2f}" for a, b in found] for n, found in intervals.items()}
    numbers: dict[str, Any] = {
        "contacts": intervals, "told": told, "late": late, "last": last, "end": end, "span": _SPAN
    }  # fmt: skip
    for name in ("two-particles", "separated", "first-packet", "third-hump", "overlapping"):
        yield claim(f"text-{name}", **numbers)


def _windows(printed: Printed) -> Iterator[Statement]:
    low, high = (particles - 1 for particles in printed.structure_particles)
    found = {law: heights_with_structure_window(law) for law in LAWS}
    yield claim("text-structure-window", found=found, low=low, high=high)
    late: dict[tuple[float, float], list[int]] = {}
    for row in impulses():
        t0 = Tower(stiffness=row.stiffness, speed=row.speed).contact_time
        if row.window_s / 2 >= printed.search * (1 - 1e-9) * t0:
            late.setdefault((row.stiffness, row.speed), []).append(row.height)
    yield claim(
        "text-within-bound",
        printed=printed,
        towers=len(impulses()),
        late=late,
        told="; ".join(
            f"{k:.0e} N/m, {v:g} m/s: n = {min(late[k, v])} and above" for k, v in sorted(late)
        ),
    )
    yield claim("text-three-fails", alpha=ratios()[MEDIAN])


def _largest_compression(intervals: Intervals, printed: Printed) -> Iterator[Statement]:
    runs = {n: run(Tower(height=n)) for n in (1, 2, 3, 19)}
    chain = {n: turnaround(one) / one.tower.contact_time for n, one in runs.items()}
    left = {n: max(end for begin, end in intervals[n] if begin < 2 * chain[n]) for n in runs}
    told = [f"n = {n}: {2 * chain[n]:.2f} and {left[n]:.2f} t0" for n in runs]
    yield claim("text-half-period", chain=chain, left=left, told=told)
    caption, text = printed.window_figure
    yield compare(
        "text-window-figure",
        printed=float(caption),
        found=float(text),
        times=" and ".join(
            f"{chain[n - 1]:.3f} t0 for {n} particles" for n in dict.fromkeys((caption, text))
        ),
    )
    grain = {
        n: float(runs[n].time_over_t0[int(np.argmax(runs[n].deformations[:, 0]))])
        for n in (1, 2, 3)
    }
    yield claim("text-maximum-of-what", grain=grain, chain=chain)
