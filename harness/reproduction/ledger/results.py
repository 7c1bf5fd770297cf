"""Section Results: contacts and forces on the grain in time, impulses and angles over height."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise

import numpy as np

from harness.cases.tower.impulse_angles import angle_from_impulse_ratio
from harness.observables.impulse import impulse
from harness.observables.reference import PEYNEAU_ROUX
from harness.parameters.tower import Tower
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, claim, compare
from harness.reproduction.ledger.runs import MEDIAN, contact_intervals, ratios, run
from harness.theory.two_spheres import contact_time_on_fixed

_FLAT = 0.01  # what counts as no change of alpha, a hundredth


def statements(printed: Printed) -> Iterator[Statement]:
    """Yield the rows of this part."""
    one = run(Tower(height=1))
    yield compare(
        "text-unit-of-time",
        printed=contact_time_on_fixed(1.0, 1e6, 2.0, 9.81),
        found=contact_intervals(one)[0][1] * one.tower.contact_time,
    )
    yield _collapse()
    yield from _three_particles(printed)
    yield from _runs(printed)
    yield from _lengths(printed)
    yield from _angles()


def _collapse() -> Statement:
    grid = np.linspace(0.0, 3.0, 601)
    off = {}
    for height in (2, 9):
        curves = []
        for stiffness in (1e5, 1e6, 1e7):
            one = run(Tower(height=height, stiffness=stiffness))
            force = np.interp(grid, one.time_over_t0, one.grain_force)
            curves.append(force / run(Tower(height=1, stiffness=stiffness)).grain_force.max())
        off[height] = [float(np.abs(b - a).max()) for a, b in pairwise(curves)]
    return claim(
        "text-collapse",
        holds=max(max(values) for values in off.values()) < 0.1,
        off="; ".join(
            f"{height + 1} particles: force curves of 1e5 and 1e6 N/m at most {soft:.3f}, of "
            f"1e6 and 1e7 N/m {stiff:.3f} of the two-particle peak apart"
            for height, (soft, stiff) in off.items()
        ),
    )


def _three_particles(printed: Printed) -> Iterator[Statement]:
    three = run(Tower(height=2))
    early = (three.time_over_t0 > 0.01) & (three.time_over_t0 < 0.4)
    assert three.profiles is not None
    opened = bool((three.profiles.forces[early, 1] == 0).all())
    still = float(np.abs(three.profiles.displacements[early, 2]).max()) == 0
    alone = bool((three.contacts[early] == 1).all())
    yield claim("text-parts", holds=opened and alone and still)
    first, second = contact_intervals(three)[:2]
    joins = float(three.time_over_t0[np.argmax(three.contacts == 2)])
    yield compare("text-joins", printed=printed.joins, found=joins)
    yield compare("text-returns", printed=printed.returns, found=second[0])
    yield compare("text-leaves", printed=printed.leaves, found=second[1])
    after = np.searchsorted(three.time_over_t0, second[0], side="right") + 1
    length = int(three.contacts[after])
    yield claim(
        "text-alone",
        holds=second[0] > first[1] and length == 2,
        begins=first[1],
        ends=second[0],
        length=length,
    )
    once = np.diff(three.time, prepend=-1.0) > 0  # a change of contacts is sampled twice
    force, contacts = three.grain_force[once], three.contacts[once]
    rate = np.gradient(force, three.time[once])
    changes = np.flatnonzero(np.diff(contacts) != 0)
    inside = changes[(changes > 3) & (changes < force.size - 5)]
    kinks = [abs(float(rate[i + 4] - rate[i - 3])) / float(np.abs(rate).max()) for i in inside]
    yield claim(
        "text-aligned",
        holds=bool(kinks) and min(kinks) > 0.1,
        least=min(kinks),
        most=max(kinks),
        changes=len(kinks),
    )


def falls(alpha: Mapping[int, float]) -> bool:
    """Return whether alpha never rises with height by more than a hundredth."""
    return all(alpha[b] <= alpha[a] + _FLAT for a, b in pairwise(sorted(alpha)))


def _runs(printed: Printed) -> Iterator[Statement]:
    runs = ratios()
    first = [impulse(run(Tower(height=1, stiffness=k, speed=v))) / v for k, v in runs]
    yield claim(
        "text-null", holds=max(first) < 2.1 and min(first) >= 2.0, least=min(first), most=max(first)
    )
    stiffnesses, speeds = (tuple(sorted(set(values))) for values in zip(*runs, strict=True))
    heights = sorted({n for alpha in runs.values() for n in alpha})
    gammas = sorted(Tower(stiffness=k, speed=v).gamma for k, v in runs)
    same = (
        speeds == printed.speeds
        and (stiffnesses[0], stiffnesses[-1]) == printed.stiffnesses
        and (heights[0], heights[-1]) == printed.heights
    )
    yield claim(
        "text-six-runs",
        holds=same and len(runs) == 6,
        runs=len(runs),
        heights=(heights[0], heights[-1]),
        stiffnesses=stiffnesses,
        speeds=speeds,
        gammas=(gammas[0], gammas[-1]),
    )
    kept = [case for case, alpha in runs.items() if falls(alpha)]
    worst = max(runs, key=lambda case: max(b - a for a, b in pairwise(runs[case].values())))
    yield claim(
        "text-impulses-decrease",
        holds=len(kept) == len(runs),
        falling=len(kept),
        runs=len(runs),
        worst=worst,
        alpha=[runs[worst][n] for n in range(1, 11)],
    )


def longest_chains(height: int, duration: float = 3.0) -> tuple[int, int]:
    """Return the longest chain of the grain, and the longest anywhere, within ``duration`` [t0]."""
    one = run(Tower(height=height, stiffness=MEDIAN[0], speed=MEDIAN[1]), duration)
    assert one.profiles is not None
    longest, length = 0, np.zeros(one.time.size, int)
    for touching in (one.profiles.forces > 0).T:
        length = np.where(touching, length + 1, 0)
        longest = max(longest, int(length.max()))
    return int(one.contacts.max()), longest


def _lengths(printed: Printed) -> Iterator[Statement]:
    chains = {n: longest_chains(n) for n in (2, 4, 6, 10, 14, 19, 30)}
    end = chains[30][0]
    later = {span: longest_chains(60, span)[1] for span in (3.0, 6.0, 12.0)}
    yield claim(
        "text-plateau",
        holds=abs(chains[19][0] - printed.longest_chain) <= 1 and end == chains[19][0],
        chains=[f"n = {n}: {grain}/{anywhere}" for n, (grain, anywhere) in chains.items()],
        end=end,
        later=[f"{length} within {span:g} t0" for span, length in later.items()],
    )
    runs = ratios()
    tall = [[a for n, a in one.items() if n >= printed.longest_chain] for one in runs.values()]
    varies = max(max(alpha) - min(alpha) for alpha in tall)
    settled = {
        case: 1 + max((n for n in alpha if abs(alpha[n] - alpha[max(alpha)]) > _FLAT), default=0)
        for case, alpha in runs.items()
    }
    yield claim(
        "text-little-effect",
        holds=varies <= _FLAT,
        varies=varies,
        begin=printed.longest_chain,
        end=printed.heights[1],
        flat=_FLAT,
        settled=[f"{n} ({k:.0e} N/m, {v:g} m/s)" for (k, v), n in settled.items()],
    )


def _angles() -> Iterator[Statement]:
    alpha = ratios()[MEDIAN]
    lost, kept = (
        [angle_from_impulse_ratio(alpha[n], reading) for n in (1, 19)]
        for reading in ("lost", "kept")
    )
    yield claim(
        "text-angle-falls",
        holds=lost[1] < lost[0] - 1 and falls(alpha),
        lost=lost,
        kept=kept,
        overlap=angle_from_impulse_ratio(ratios("overlap")[MEDIAN][19]),
    )
    yield compare(
        "text-tall-limit",
        printed=lost[1],
        found=PEYNEAU_ROUX.value_deg,
        tolerance=PEYNEAU_ROUX.uncertainty_deg,
        published=PEYNEAU_ROUX,
    )
