"""Section Background: the energy from shock to shock, equations (2) to (6), and its angle."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq

from harness.reproduction import as_printed
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, claim, compare
from harness.reproduction.ledger.samples import generator
from harness.reproduction.source import SOURCES
from harness.theory.critical_angle import critical_angle, no_flight_bound
from harness.theory.energy_map import after_next_shock, steady_energy

_SAMPLES = 100
_LONG = 2000  # shocks


def statements(printed: Printed) -> list[Statement]:
    """Return the rows of this part."""
    return [
        *_table(),
        _start(printed),
        *_sums(),
        _divergence(printed),
        _limit(),
        *_angle(printed),
    ]


def iterated(shocks: int, start: float, gained: float, shock: float) -> float:
    """Return E_n by n steps of E[j+1] = (E[j] + dE) shock."""
    energy = start
    for _ in range(shocks):
        energy = (energy + gained) * shock
    return energy


def _table() -> list[Statement]:
    angles = generator().uniform(0.1, 29.9, _SAMPLES)
    depth = [depth_of_well(a) for a in angles]
    drop = [height(0.0, 0.0, a) - height(1.0, 0.0, a) for a in angles]
    starts = generator().uniform(0.06, 0.2, _SAMPLES)
    return [
        compare(
            SOURCES["table-1-well"],
            printed=[as_printed.well(a) for a in angles],
            found=depth,
            computed=f"heights of well and next crest from turned coordinates at {_SAMPLES} angles "
            "between 0 and 30 deg: the same if r is the distance of the centres, d; with r the "
            "radius, as equation (11) needs it, both C and dE are half of what they are",
        ),
        compare(
            SOURCES["table-1-gain"],
            printed=[as_printed.gain(a) for a in angles],
            found=drop,
            computed="drop from one sphere of the row to the next, r the distance of the centres",
        ),
        compare(
            SOURCES["table-1-first-shock"],
            printed=[as_printed.energy_after_first(e, as_printed.gain(10.5), 0.25) for e in starts],
            found=[after_next_shock(e, 10.5, 0.25) for e in starts],
            computed="the energy map of the incline at 10.5 deg and shock 1/4",
        ),
    ]


def _start(printed: Printed) -> Statement:
    angle = printed.critical_angle_deg
    depth, gained = as_printed.well(angle), as_printed.gain(angle)
    # contact is weakest where the grain is fastest, just before the shock
    most = 0.5 * math.cos(math.radians(30 + angle)) - gained
    pressed = _weakest_and_strongest_contact(angle)
    return claim(
        SOURCES["text-constant-contact"],
        holds=depth < most and pressed[0] > 0 and pressed[1] <= 1,
        computed=f"at {angle:g} deg E_0 may lie between {depth:.4f} and {most:.4f} m g d; in "
        f"steady motion the contact carries {pressed[0]:.3f} to {pressed[1]:.3f} of the normal "
        f"component; steady motion keeps contact up to {no_flight_bound():.2f} deg",
    )


def _weakest_and_strongest_contact(angle_deg: float) -> tuple[float, float]:
    """Return the contact force over the normal component of gravity, extremes of a cycle."""
    energy = steady_energy(angle_deg, 0.25)
    from_vertical = np.radians(np.linspace(-(30 - angle_deg), 30 + angle_deg, 2001))
    fallen = math.cos(math.radians(30 - angle_deg)) - np.cos(from_vertical)
    part = 1 - 2 * (energy + fallen) / np.cos(from_vertical)
    return float(part.min()), float(part.max())


def _sums() -> list[Statement]:
    random = generator()
    cases = [
        (int(random.integers(3, 12)), *random.uniform([0.05, 0.05, 0.1], [1.0, 1.0, 0.9]))
        for _ in range(_SAMPLES)
    ]
    direct = [iterated(*case) for case in cases]
    ratios = [(shock, n) for n, _, _, shock in cases]
    return [
        compare(
            SOURCES["eq-2"],
            printed=[as_printed.energy_series(*case) for case in cases],
            found=direct,
            computed="n steps of E_(j+1) = shock (E_j + dE) at "
            f"{_SAMPLES} random n, E_0, dE and shocks",
            corrected=[e * s**n + g * s * sum(s**p for p in range(n)) for n, e, g, s in cases],
        ),
        compare(
            SOURCES["eq-3"],
            printed=[as_printed.geometric_sum(x, n) for x, n in ratios],
            found=[sum(x**p for p in range(n + 1)) for x, n in ratios],
            computed="the sum taken term by term",
        ),
        compare(
            SOURCES["eq-3-index"],
            printed=[as_printed.geometric_sum(x, n) for x, n in ratios],
            found=[sum(x**p for p in range(n)) for x, n in ratios],
            computed="the bracket has n terms, the S_n of eq. (3) has n + 1",
            corrected=[as_printed.geometric_sum(x, n - 1) for x, n in ratios],
        ),
        compare(
            SOURCES["eq-4"],
            printed=[
                as_printed.energy_closed(n, as_printed.energy_after_first(e, g, s), g, s)
                for n, e, g, s in cases
            ],
            found=direct,
            computed="n steps of the map; the index slip of eqs. (2) and (3) is not carried over",
        ),
    ]


def _divergence(printed: Printed) -> Statement:
    def grows(shock: float) -> bool:
        late, later = iterated(_LONG, 0.1, 0.2, shock), iterated(2 * _LONG, 0.1, 0.2, shock)
        return later > 1.5 * late

    border = printed.diverges_above
    below, at, above = grows(border - 0.01), grows(border), grows(border + 0.01)
    at_rest = iterated(_LONG, 0.0, 0.2, 0.25), as_printed.limiting_energy(0.2, 0.25)
    return claim(
        SOURCES["text-divergence"],
        holds=above and not at and not below,
        corrected_holds=above and at and not below,
        computed=f"twice {_LONG} shocks raise E_n by half or more at shock {border + 0.01:g}: "
        f"{above}, at {border:g}: {at}, at {border - 0.01:g}: {below}; at shock 1/4 a grain at "
        f"rest gains more than it loses at first and still ends at {at_rest[0]:.4f} m g d "
        f"(E*: {at_rest[1]:.4f})",
    )


def _limit() -> Statement:
    random = generator()
    cases = [tuple(random.uniform([0.05, 0.1], [1.0, 0.9])) for _ in range(_SAMPLES)]
    return compare(
        SOURCES["eq-5"],
        printed=[as_printed.limiting_energy(*case) for case in cases],
        found=[iterated(_LONG, 0.3, *case) for case in cases],
        computed=f"the map iterated {_LONG} times",
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


def _angle(printed: Printed) -> list[Statement]:
    found = fate_angle(0.25)

    def root(divisor: float) -> float:
        def margin(angle: float) -> float:
            return as_printed.steady_state_margin(angle, 0.25, divisor)

        return float(brentq(margin, 0.5, 29.5))

    as_it_stands = root(printed.well_divisor)
    return [
        compare(
            SOURCES["eq-6"],
            printed=as_it_stands,
            found=found,
            computed=f"root of the last line as printed {as_it_stands:.4f} deg; bisecting the fate "
            f"of the energy map gives {found:.4f} deg, the closed form {critical_angle():.4f} deg",
            corrected=root(2.0),
        ),
        compare(
            SOURCES["text-critical-angle"],
            printed=printed.critical_angle_deg,
            found=found,
            computed=f"bisection of the fate of the energy map at shock 1/4: {found:.4f} deg",
        ),
    ]
