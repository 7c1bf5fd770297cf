"""Section Background: the energy from shock to shock, (2) to (6), its angle, the shock, to (9)."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, claim, compare
from harness.reproduction.ledger.samples import generator
from harness.reproduction.source import SOURCES
from harness.theory.critical_angle import critical_angle, no_flight_bound
from harness.theory.energy_map import after_next_shock, steady_energy

_SAMPLES = 100
_LONG = 2000  # shocks
_RESTITUTIONS = np.linspace(0.0, 1.0, 21)


def statements(printed: Printed) -> Iterator[Statement]:
    """Yield the rows of this part."""
    yield from _table(printed)
    yield from _sums()
    yield from _limits(printed)
    yield from _angle(printed)
    yield from _shock(printed)


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
    gain = SOURCES["table-1-gain"]
    angles = generator().uniform(0.1, 29.9, _SAMPLES)
    yield compare("table-1-well", found=[depth_of_well(a) for a in angles], theta=angles)
    yield compare(
        "table-1-gain",
        found=[height(0.0, 0.0, a) - height(1.0, 0.0, a) for a in angles],
        theta=angles,
    )
    starts = generator().uniform(0.06, 0.2, _SAMPLES)
    yield compare(
        "table-1-first-shock",
        found=[after_next_shock(e, 10.5, 0.25) for e in starts],
        E_0=starts,
        dE=gain.printed(theta=10.5),
        shock=0.25,
    )
    angle = printed.critical_angle_deg
    depth = SOURCES["table-1-well"].printed(theta=angle)
    # contact is weakest where the grain is fastest, just before the shock
    most = 0.5 * math.cos(math.radians(30 + angle)) - gain.printed(theta=angle)
    yield claim(
        "text-constant-contact",
        angle=angle,
        depth=depth,
        most=most,
        pressed=_extremes_of_contact(angle),
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
    n, start, gained, shock = np.array(cases).T
    yield compare("eq-2", found=direct, n=n, E_0=start, dE=gained, shock=shock)
    ratios = [(shock, n) for n, _, _, shock in cases]
    yield compare("eq-3", found=[sum(x**p for p in range(n + 1)) for x, n in ratios], x=shock, n=n)
    yield compare(
        "eq-3-index", found=[sum(x**p for p in range(n)) for x, n in ratios], x=shock, n=n
    )
    first = SOURCES["table-1-first-shock"].printed(E_0=start, dE=gained, shock=shock)
    yield compare("eq-4", found=direct, n=n, E_1=first, dE=gained, shock=shock)


def _limits(printed: Printed) -> Iterator[Statement]:
    def grows(shock: float) -> bool:
        late, later = iterated(_LONG, 0.1, 0.2, shock), iterated(2 * _LONG, 0.1, 0.2, shock)
        return later > 1.5 * late

    shocks = [printed.diverges_above + off for off in (0.01, 0.0, -0.01)]
    yield claim(
        "text-divergence",
        long=_LONG,
        shocks=shocks,
        grow=[grows(shock) for shock in shocks],
        end=iterated(_LONG, 0.0, 0.2, 0.25),
        limit=SOURCES["eq-5"].printed(dE=0.2, shock=0.25),
    )
    random = generator()
    gained, shock = random.uniform([0.05, 0.1], [1.0, 0.9], (_SAMPLES, 2)).T
    ends = [iterated(_LONG, 0.3, *case) for case in zip(gained, shock, strict=True)]
    yield compare("eq-5", found=ends, dE=gained, shock=shock, long=_LONG)


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
        margin = SOURCES["eq-6"].printed
        return float(brentq(lambda a: margin(theta=a, shock=0.25, divisor=divisor), 0.5, 29.5))

    printed_root, closed = root(printed.well_divisor), critical_angle()
    yield compare("eq-6", printed=printed_root, found=found, corrected=root(2.0), closed=closed)
    yield compare("text-critical-angle", printed=printed.critical_angle_deg, found=found)


def collide(velocity: NDArray[np.float64], restitution: float) -> NDArray[np.float64]:
    """Return the velocity after the grain meets the next sphere, in vectors.

    The new contact's normal stands 60 deg off the old one's; the normal part of
    the velocity is turned back and multiplied by ``restitution``.
    """
    normal = np.array([-1.0, 0.0])
    approach = float(velocity @ normal)
    return np.asarray(velocity - (1 + restitution) * approach * normal)


def _shock(printed: Printed) -> Iterator[Statement]:
    before = np.array([math.sqrt(3) / 2, -0.5])  # unit speed, 60 deg off the new tangent
    after = [collide(before, e) for e in _RESTITUTIONS]
    speeds = [float(np.hypot(*v)) for v in after]
    kept = [float(v @ v) / float(before @ before) for v in after]
    vector = float(np.sum((before - after[0]) ** 2))
    yield compare(
        "eq-7",
        found=kept,
        before=1.0,
        after=np.array(speeds),
        vector=vector,
        angle=critical_angle(vector),
    )
    yield compare("eq-8", found=speeds, before=1.0, e=_RESTITUTIONS)
    after_8 = SOURCES["eq-8"].printed(before=7.0, e=_RESTITUTIONS)
    yield compare(
        "text-substitution",
        printed=SOURCES["eq-9"].printed(e=_RESTITUTIONS),
        found=SOURCES["eq-7"].printed(before=7.0, after=after_8),
    )
    yield compare("eq-9", found=kept, e=_RESTITUTIONS)
    without_rebound = float(np.sum(collide(before, 0.0) ** 2))
    yield compare("text-shock", printed=printed.shock, found=without_rebound)
