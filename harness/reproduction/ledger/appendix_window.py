"""Appendix B: the time over which the impulse is taken."""

from __future__ import annotations

import math

import numpy as np

from harness.observables.windows import turnaround
from harness.parameters.tower import LAWS, Tower
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, claim, compare
from harness.reproduction.ledger.runs import contact_intervals, impulses, ratios, run, windows
from harness.reproduction.source import SOURCES

_SPAN = 6.0  # [t0] over which returning contacts are looked for


def statements(printed: Printed) -> list[Statement]:
    """Return the rows of this part."""
    intervals = {n: contact_intervals(run(Tower(height=n), _SPAN)) for n in (1, 2, 3, 4, 9, 10, 19)}
    return [
        *_packets(intervals, printed),
        _structure(printed),
        _within_bound(printed),
        _half_period(intervals),
        _three_particles(),
        _number_of_particles(printed),
        _maximum_of_what(),
    ]


def _list(intervals: list[tuple[float, float]]) -> str:
    return ", ".join(f"{begin:.2f} to {end:.2f}" for begin, end in intervals)


def _packets(intervals: dict[int, list[tuple[float, float]]], printed: Printed) -> list[Statement]:
    end = printed.first_packet
    late = {n: [one for one in found if one[0] >= end] for n, found in intervals.items()}
    last = {n: max(b for a, b in found if a < end) for n, found in intervals.items()}
    return [
        claim(
            SOURCES["text-two-particles"],
            holds=len(intervals[1]) == 1,
            computed=f"one contact, {_list(intervals[1])} t0 (1e6 N/m, 2 m/s, {_SPAN:g} t0)",
        ),
        claim(
            SOURCES["text-separated"],
            holds=all(not late[n] or late[n][0][0] > last[n] + 1 for n in (10, 19)),
            computed=f"contacts of the grain with 11 particles: {_list(intervals[10])} t0; with "
            f"20: {_list(intervals[19])} t0; {len(late[10]) + len(late[19])} of them begin after "
            f"{end:g} t0, of {_SPAN:g} t0 watched: the grain is thrown back before the chain "
            "answers",
        ),
        claim(
            SOURCES["text-first-packet"],
            holds=last[19] <= end and abs(last[19] - last[9]) < 0.01,
            computed=f"the grain's last contact ends at {last[19]:.3f} t0 with 20 and at "
            f"{last[9]:.3f} t0 with 10 particles",
        ),
        claim(
            SOURCES["text-third-hump"],
            holds=len(intervals[3]) == 3,
            computed=f"contacts of the grain: {_list(intervals[3])} t0",
        ),
        claim(
            SOURCES["text-overlapping"],
            holds=len(intervals[2]) == 2 and last[2] > last[19] + 0.1,
            computed=f"two contacts, {_list(intervals[2])} t0; the second lasts "
            f"{last[2] - last[19]:.2f} t0 longer than in a tall tower, where the base does not "
            "answer",
        ),
    ]


def _structure(printed: Printed) -> Statement:
    low, high = (particles - 1 for particles in printed.structure_particles)
    heights = tuple(range(1, 9))
    found = {
        law: [
            n
            for n, row in windows(law, "structure", heights).items()
            if math.isfinite(row.window_s)
        ]
        for law in LAWS
    }
    wanted = list(range(low, high + 1))
    return claim(
        SOURCES["text-structure-window"],
        holds=set(wanted) <= set(found["deformable"]),
        computed="the grain's chain holds all n contacts and then one or none, after t0 and within "
        "3 t0, for n = "
        + "; n = ".join(f"{', '.join(map(str, found[law]))} ({law} law)" for law in found)
        + f" of 1 to {heights[-1]} (1e6 N/m, 2 m/s): a whole chain does not form beyond that",
    )


def _within_bound(printed: Printed) -> Statement:
    late = [
        row
        for row in impulses()
        if row.window_s / 2 >= printed.search * (1 - 1e-9) * _contact_time(row.stiffness, row.speed)
    ]
    where = {(row.stiffness, row.speed) for row in late}
    told = "; ".join(
        f"{k:.0e} N/m, {v:g} m/s: n = "
        f"{min(r.height for r in late if (r.stiffness, r.speed) == (k, v))} and above"
        for k, v in sorted(where)
    )
    return claim(
        SOURCES["text-within-bound"],
        holds=not late,
        computed=f"in {len(impulses()) - len(late)} of {len(impulses())} towers; the others still "
        f"sink at {printed.search:g} t0, where the search ends ({told})",
    )


def _contact_time(stiffness: float, speed: float) -> float:
    return Tower(stiffness=stiffness, speed=speed).contact_time


def _half_period(intervals: dict[int, list[tuple[float, float]]]) -> Statement:
    doubled, left = {}, {}
    for n in (1, 2, 3, 19):
        one = run(Tower(height=n))
        doubled[n] = 2 * turnaround(one) / one.tower.contact_time
        left[n] = max(end for begin, end in intervals[n] if begin < doubled[n])
    return claim(
        SOURCES["text-half-period"],
        holds=all(abs(doubled[n] - left[n]) < 0.1 for n in doubled),
        computed="twice that time against when the grain's last contact ends: "
        + ", ".join(f"n = {n}: {doubled[n]:.2f} and {left[n]:.2f} t0" for n in doubled),
    )


def _three_particles() -> Statement:
    alpha = ratios()[1e6, 2.0]
    tall = alpha[19]
    return claim(
        SOURCES["text-three-fails"],
        holds=alpha[2] - tall > 0.3 and alpha[4] - tall < 0.01,
        computed=f"alpha = {alpha[2]:.3f} with three particles, {alpha[3]:.3f} with four, "
        f"{alpha[4]:.3f} with five, {tall:.3f} with twenty (1e6 N/m, 2 m/s): four fail as well",
    )


def _number_of_particles(printed: Printed) -> Statement:
    caption, text = printed.window_figure
    times = {}
    for particles in (caption, text):
        one = run(Tower(height=particles - 1))
        times[particles] = turnaround(one) / one.tower.contact_time
    return compare(
        SOURCES["text-window-figure"],
        printed=float(caption),
        found=float(text),
        computed="largest compression at "
        + " and ".join(f"{t:.3f} t0 for {n} particles" for n, t in times.items())
        + ": the window cannot tell which is drawn from the text alone",
    )


def _maximum_of_what() -> Statement:
    told = {}
    for n in (1, 2, 3):
        one = run(Tower(height=n))
        grain = float(one.time_over_t0[int(np.argmax(one.deformations[:, 0]))])
        told[n] = grain, turnaround(one) / one.tower.contact_time
    return claim(
        SOURCES["text-maximum-of-what"],
        holds=all(abs(a - b) < 0.05 for a, b in told.values()),
        computed="grain and chain at "
        + ", ".join(f"{a:.3f} and {b:.3f} t0 (n = {n})" for n, (a, b) in told.items())
        + "; the chain's is used here",
    )
