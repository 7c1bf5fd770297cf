"""Section Background: the energy from shock to shock, equations (2) to (6), and its angle."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from scipy.optimize import brentq

from harness.reproduction import as_printed
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, claim, compare
from harness.reproduction.ledger.samples import generator
from harness.theory.critical_angle import critical_angle, no_flight_bound
from harness.theory.energy_map import after_next_shock, steady_energy

_SAMPLES = 100
_LONG = 2000  # shocks


def statements(printed: Printed) -> Iterator[Statement]:
    """Yield the rows of this part."""
    yield from _table(printed)
    yield from _sums()
    yield from _limits(printed)
    yield from _angle(printed)


def iterated(shocks: int, start: float, gained: float, shock: float) -> float:
    """Return E_n by n steps of E[j+1] = (E[j] + dE) shock."""
    energy = start
    for _ in range(shocks):
        energy = (energy + gained) * shock
    return energy


def height(along: float, normal: float, angle_deg: float) -> float:
    """Return the height [d] of a point of the row's own frame once the row is tilted."""
    tilt = math.radians(angle_deg)
    return normal * math.cos(tilt) - along * math.sin(tilt)


def depth_of_well(angle_deg: float) -> float:
    """Return how far a crest stands above the well before it [d], from coordinates.

    Spheres at 0 and 1; the grain's centre is the tip of an equilateral triangle in the
    well and one diameter above the second sphere on the crest.
    """
    crest = height(1.0, 0.0, angle_deg) + 1.0
    return crest - height(0.5, math.sqrt(3) / 2, angle_deg)


def _table(printed: Printed) -> Iterator[Statement]:
    angles = generator().uniform(0.1, 29.9, _SAMPLES)
    yield compare(
        "table-1-well",
        printed=[as_printed.well(a) for a in angles],
        found=[depth_of_well(a) for a in angles],
    )
    yield compare(
        "table-1-gain",
        printed=[as_printed.gain(a) for a in angles],
        found=[height(0.0, 0.0, a) - height(1.0, 0.0, a) for a in angles],
    )
    starts = generator().uniform(0.06, 0.2, _SAMPLES)
    yield compare(
        "table-1-first-shock",
        printed=[as_printed.energy_after_first(e, as_printed.gain(10.5), 0.25) for e in starts],
        found=[after_next_shock(e, 10.5, 0.25) for e in starts],
    )
    angle = printed.critical_angle_deg
    depth = as_printed.well(angle)
    # contact is weakest where the grain is fastest, just before the shock
    most = 0.5 * math.cos(math.radians(30 + angle)) - as_printed.gain(angle)
    weakest, strongest = _extremes_of_contact(angle)
    yield claim(
        "text-constant-contact",
        holds=depth < most and weakest > 0 and strongest <= 1,
        angle=angle,
        depth=depth,
        most=most,
        pressed=(weakest, strongest),
        flight=no_flight_bound(),
    )


def _extremes_of_contact(angle_deg: float) -> tuple[float, float]:
    """Return the contact force over the normal component of gravity, extremes of a cycle."""
    energy = steady_energy(angle_deg, 0.25)
    from_vertical = np.radians(np.linspace(-(30 - angle_deg), 30 + angle_deg, 2001))
    fallen = math.cos(math.radians(30 - angle_deg)) - np.cos(from_vertical)
    part = 1 - 2 * (energy + fallen) / np.cos(from_vertical)
    return float(part.min()), float(part.max())


def _sums() -> Iterator[Statement]:
    random = generator()
    cases = [
        (int(random.integers(3, 12)), *random.uniform([0.05, 0.05, 0.1], [1.0, 1.0, 0.9]))
        for _ in range(_SAMPLES)
    ]
    direct = [iterated(*case) for case in cases]
    ratios = [(shock, n) for n, _, _, shock in cases]
    yield compare(
        "eq-2",
        printed=[as_printed.energy_series(*case) for case in cases],
        found=direct,
        corrected=[e * s**n + g * s * sum(s**p for p in range(n)) for n, e, g, s in cases],
    )
    sums = [as_printed.geometric_sum(x, n) for x, n in ratios]
    yield compare("eq-3", printed=sums, found=[sum(x**p for p in range(n + 1)) for x, n in ratios])
    yield compare(
        "eq-3-index",
        printed=sums,
        found=[sum(x**p for p in range(n)) for x, n in ratios],
        corrected=[as_printed.geometric_sum(x, n - 1) for x, n in ratios],
    )
    yield compare(
        "eq-4",
        printed=[
            as_printed.energy_closed(n, as_printed.energy_after_first(e, g, s), g, s)
            for n, e, g, s in cases
        ],
        found=direct,
    )


def _limits(printed: Printed) -> Iterator[Statement]:
    def grows(shock: float) -> bool:
        late, later = iterated(_LONG, 0.1, 0.2, shock), iterated(2 * _LONG, 0.1, 0.2, shock)
        return later > 1.5 * late

    shocks = [printed.diverges_above + off for off in (0.01, 0.0, -0.01)]
    above, at, below = (grows(shock) for shock in shocks)
    yield claim(
        "text-divergence",
        holds=above and not at and not below,
        corrected_holds=above and at and not below,
        long=_LONG,
        shocks=shocks,
        grow=(above, at, below),
        end=iterated(_LONG, 0.0, 0.2, 0.25),
        limit=as_printed.limiting_energy(0.2, 0.25),
    )
    random = generator()
    cases = [tuple(random.uniform([0.05, 0.1], [1.0, 0.9])) for _ in range(_SAMPLES)]
    yield compare(
        "eq-5",
        printed=[as_printed.limiting_energy(*case) for case in cases],
        found=[iterated(_LONG, 0.3, *case) for case in cases],
        long=_LONG,
    )


def fate(angle_deg: float, shock: float) -> bool:
    """Return whether a grain that starts with twice the well's depth still moves in the end."""
    depth = depth_of_well(angle_deg)
    energy = 2 * depth
    for _ in range(_LONG):
        if energy < depth:
            return False
        energy = after_next_shock(energy, angle_deg, shock)
    return True


def fate_angle(shock: float) -> float:
    """Return the smallest angle [deg] at which motion lasts, by bisection of the fate."""
    low, high = 0.0, 30.0
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if fate(middle, shock) else (middle, high)
    return 0.5 * (low + high)


def _angle(printed: Printed) -> Iterator[Statement]:
    found = fate_angle(0.25)

    def root(divisor: float) -> float:
        return float(brentq(lambda a: as_printed.steady_state_margin(a, 0.25, divisor), 0.5, 29.5))

    yield compare(
        "eq-6",
        printed=root(printed.well_divisor),
        found=found,
        corrected=root(2.0),
        closed=critical_angle(),
    )
    yield compare("text-critical-angle", printed=printed.critical_angle_deg, found=found)
