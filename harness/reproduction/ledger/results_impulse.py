"""Section Results: impulses against height, and the critical angle that follows."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from harness.cases.tower.impulse_angles import angle_from_impulse_ratio
from harness.observables.impulse import impulse
from harness.observables.reference import PEYNEAU_ROUX
from harness.parameters.tower import Tower
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, claim, compare
from harness.reproduction.ledger.runs import ratios, run
from harness.reproduction.source import SOURCES

_FLAT = 0.01  # what counts as no change of alpha, a hundredth
_MEDIAN = (1e6, 2.0)


def statements(printed: Printed) -> list[Statement]:
    """Return the rows of this part."""
    return [
        _null_hypothesis(),
        _six_runs(printed),
        _decreases(),
        _plateau(printed),
        _little_effect(printed),
        *_angles(),
    ]


def _null_hypothesis() -> Statement:
    found = [impulse(run(Tower(height=1, stiffness=k, speed=v))) / v for k, v in ratios()]
    return claim(
        SOURCES["text-null"],
        holds=max(found) < 2.1 and min(found) >= 2.0,
        computed=f"J(1) of the six runs is {min(found):.4f} to {max(found):.4f} m v0: the rebound, "
        "2 m v0, and the weight during the contact",
    )


def _six_runs(printed: Printed) -> Statement:
    runs = ratios()
    speeds = sorted({speed for _, speed in runs})
    stiffnesses = sorted({stiffness for stiffness, _ in runs})
    heights = sorted({n for alpha in runs.values() for n in alpha})
    gammas = sorted(Tower(stiffness=k, speed=v).gamma for k, v in runs)
    same = (
        tuple(speeds) == printed.speeds
        and (stiffnesses[0], stiffnesses[-1]) == printed.stiffnesses
        and (heights[0], heights[-1]) == printed.heights
    )
    return claim(
        SOURCES["text-six-runs"],
        holds=same and len(runs) == 6,
        computed=f"{len(runs)} runs of {heights[0]} to {heights[-1]} contacts: "
        f"{', '.join(f'{k:.0e}' for k in stiffnesses)} N/m at "
        f"{', '.join(f'{v:g}' for v in speeds)} m/s, m g/(v0 sqrt(k m)) from {gammas[0]:.5f} to "
        f"{gammas[-1]:.5f}",
    )


def falls(alpha: Mapping[int, float]) -> bool:
    """Return whether alpha never rises with height by more than a hundredth."""
    return all(alpha[b] <= alpha[a] + _FLAT for a, b in pairwise(sorted(alpha)))


def _decreases() -> Statement:
    runs = ratios()
    kept = [case for case, alpha in runs.items() if falls(alpha)]
    worst = max(runs, key=lambda case: max(b - a for a, b in pairwise(runs[case].values())))
    row = ", ".join(f"{runs[worst][n]:.2f}" for n in range(1, 11))
    return claim(
        SOURCES["text-impulses-decrease"],
        holds=len(kept) == len(runs),
        computed=f"alpha falls in {len(kept)} of {len(runs)} runs; at {worst[0]:.0e} N/m and "
        f"{worst[1]:g} m/s it is {row} for n = 1 to 10",
    )


def longest_chains(height: int, duration: float = 3.0) -> tuple[int, int]:
    """Return the longest chain of the grain, and the longest anywhere, within ``duration`` [t0]."""
    case = Tower(height=height, stiffness=_MEDIAN[0], speed=_MEDIAN[1])
    one = run(case, duration)
    assert one.profiles is not None
    longest, length = 0, np.zeros(one.time.size, int)
    for touching in (one.profiles.forces > 0).T:
        length = np.where(touching, length + 1, 0)
        longest = max(longest, int(length.max()))
    return int(one.contacts.max()), longest


def _plateau(printed: Printed) -> Statement:
    heights = (2, 4, 6, 10, 14, 19, 30)
    grain = {n: longest_chains(n)[0] for n in heights}
    anywhere = {n: longest_chains(n)[1] for n in heights}
    later = {span: longest_chains(60, span)[1] for span in (3.0, 6.0, 12.0)}
    return claim(
        SOURCES["text-plateau"],
        holds=abs(grain[19] - printed.longest_chain) <= 1 and grain[30] == grain[19],
        computed="longest chain of the grain / anywhere in the tower within 3 t0: "
        + ", ".join(f"n = {n}: {grain[n]}/{anywhere[n]}" for n in heights)
        + f" (1e6 N/m, 2 m/s); the grain's levels off at {grain[30]}; the one anywhere grows with "
        "the time one looks, n = 60: "
        + ", ".join(f"{length} within {span:g} t0" for span, length in later.items()),
        correction=f"the chain of the grain levels off at {grain[30]} contacts; under the overlap "
        "law a touching tower is one chain from the start",
    )


def _little_effect(printed: Printed) -> Statement:
    runs = ratios()
    beyond = [
        max(alpha.values()) - min(alpha.values())
        for alpha in (
            {n: a for n, a in one.items() if n >= printed.longest_chain} for one in runs.values()
        )
    ]
    settled = {
        case: min(
            n
            for n in alpha
            if all(abs(alpha[m] - alpha[max(alpha)]) <= _FLAT for m in alpha if m >= n)
        )
        for case, alpha in runs.items()
    }
    return claim(
        SOURCES["text-little-effect"],
        holds=max(beyond) <= _FLAT,
        computed=f"alpha varies by {max(beyond):.1e} at most from n = {printed.longest_chain} to "
        f"{printed.heights[1]}; it is within {_FLAT:g} of its end from n = "
        + ", ".join(f"{n} ({k:.0e} N/m, {v:g} m/s)" for (k, v), n in settled.items())
        + " on",
    )


def _angles() -> list[Statement]:
    alpha = ratios()[_MEDIAN]
    first, last = [
        [angle_from_impulse_ratio(alpha[n], reading) for n in (1, 19)]
        for reading in ("lost", "kept")
    ]
    overlap = angle_from_impulse_ratio(ratios("overlap")[_MEDIAN][19])
    published = PEYNEAU_ROUX
    return [
        claim(
            SOURCES["text-angle-falls"],
            holds=first[1] < first[0] - 1 and falls(alpha),
            computed=f"theta_c at n = 1 and 19 is {first[0]:.2f} and {first[1]:.2f} deg by eq. "
            f"(13)'s shock; {last[0]:.2f} and {last[1]:.2f} deg by its velocity; overlap law "
            f"{overlap:.2f} deg at n = 19 (1e6 N/m, 2 m/s)",
        ),
        compare(
            SOURCES["text-tall-limit"],
            printed=first[1],
            found=published.value_deg,
            tolerance=published.uncertainty_deg,
            computed=f"{first[1]:.2f} deg against {published.value_deg} +- "
            f"{published.uncertainty_deg} deg, {published.what}",
        ),
    ]
