"""Section Methods: rigidity, the two time scales, the shock of a base, equations (10) to (13)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

from harness.cases.tower.impulse_table import STIFFNESSES
from harness.parameters.tower import Tower
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, claim, compare
from harness.reproduction.ledger.contact import integrate
from harness.reproduction.ledger.runs import impulses
from harness.reproduction.ledger.samples import generator
from harness.reproduction.source import SOURCES
from harness.theory.critical_angle import critical_angle, no_flight_bound
from harness.theory.energy_map import steady_energy
from harness.theory.two_spheres import impulse_on_fixed

_MASS, _DIAMETER = 1.0, 1.0  # [kg], [m] of the source's towers
_GLASS_MODULUS, _GLASS_DENSITY, _PACKING = 70e9, 2500.0, 0.6  # [Pa], [kg/m3], [1] usual values
_RATIOS = np.linspace(0.3, 1.0, 15)
_REACHED = 0.54  # of tall towers, for the numbers in words


def statements(printed: Printed) -> Iterator[Statement]:
    """Yield the rows of this part."""
    yield from _rigidity(printed)
    yield from _stiffnesses(printed)
    yield from _crest(printed)
    yield from _contact(printed)
    yield from _shock()


def _rigidity(printed: Printed) -> Iterator[Statement]:
    metres = {"k": 1e5, "P": 9.81, "d": _DIAMETER}  # N/m, N/m2, m
    centimetres = {"k": 1e5 / 100, "P": 9.81 / 100**2, "d": _DIAMETER * 100}
    law = SOURCES["eq-10"]
    ratios = [law.printed(**unit) for unit in (metres, centimetres)]
    repaired = [law.corrected(**unit) for unit in (metres, centimetres)]
    yield claim(
        law,
        corrected_holds=math.isclose(*repaired, rel_tol=1e-12),
        ratios=ratios,
        repaired=repaired,
    )
    pressure = _GLASS_DENSITY * _PACKING * printed.gravity * printed.glass_depth
    yield compare(
        "text-glass-bead",
        printed=printed.glass_rigidity,
        found=(_GLASS_MODULUS / pressure) ** (2 / 3),
        modulus=_GLASS_MODULUS,
        pressure=pressure,
        density=_GLASS_DENSITY,
        packing=_PACKING,
    )
    yield compare(
        "text-orders-of-magnitude",
        printed=printed.orders_of_magnitude,
        found=float(np.log10(printed.rigidities[1] / printed.rigidities[0])),
        corrected=float(len(STIFFNESSES) - 1),  # steps of ten between its values
        printed_range=printed.rigidities,
    )


def _stiffnesses(printed: Printed) -> Iterator[Statement]:
    weight = _MASS * printed.gravity / _DIAMETER  # N/m, the pressure of a row of disks
    pairs = zip(printed.rigidities, printed.stiffnesses, strict=True)
    for name, (kappa, stiffness) in zip(("lowest", "highest"), pairs, strict=True):
        yield compare(f"text-stiffness-{name}", printed=kappa, found=stiffness / weight)
    median = float(np.median(STIFFNESSES))
    middle = median * (printed.rigidities[0] / printed.stiffnesses[0])
    yield compare(
        "text-median-rigidity", printed=printed.median_rigidity, found=middle, stiffness=median
    )


def rise_time(angle_deg: float) -> float:
    """Return the time [s] from well to crest in steady motion, by quadrature over the arc."""
    rise = math.radians(30 - angle_deg)
    energy = steady_energy(angle_deg, 0.25)

    def slowness(left: float) -> float:
        return 1 / math.sqrt(2 * (energy - math.cos(left) + math.cos(rise)))

    return float(quad(slowness, 0.0, rise)[0]) * math.sqrt(_DIAMETER / 9.81)


def _crest(printed: Printed) -> Iterator[Statement]:
    drop = 1 - math.sqrt(3) / 2  # [d] from crest to well of a level row, Pythagoras
    escape = math.sqrt(2 * printed.gravity * drop * 2.0)
    evaluated = escape / 8 / printed.gravity
    formula = SOURCES["eq-11"].printed
    yield compare("eq-11", found=evaluated, r=1.0, g=printed.gravity, escape=escape)
    needed = brentq(lambda r: formula(r=r, g=printed.gravity) - printed.crest_time, 1e-3, 1e6)
    yield compare("text-t-c", printed=printed.crest_time, found=evaluated, needed=needed)
    flight = no_flight_bound()
    fastest, slow = rise_time(flight), rise_time(critical_angle() + 1e-6)
    times: dict[str, Any] = {"fastest": fastest, "flight": flight, "slow": slow}
    yield claim("text-crest-time", printed=printed, **times)
    yield claim(
        "text-separation",
        printed=printed,
        formula=formula(r=1.0, g=printed.gravity),
        fastest=fastest,
        longest=max(row.window_s for row in impulses()),
    )


def _contact(printed: Printed) -> Iterator[Statement]:
    random = generator()
    k, m, gamma = random.uniform([50, 0.3, 0.5], [200, 1.0, 5.0], (50, 3)).T
    times = [integrate(*case).time for case in zip(k, m, gamma, strict=True)]
    yield compare("eq-12", found=times, k=k, m=m, gamma=gamma, factor=printed.damping_factor)
    stiffness = printed.stiffnesses[0]
    modes = np.linalg.eigvalsh(stiffness / _MASS * np.array([[1.0, -1.0], [-1.0, 1.0]]))
    yield compare("text-effective-mass", found=float(stiffness / modes[1]), m_1=_MASS, m_2=_MASS)
    yield compare(
        "text-t-n",
        printed=printed.contact_time,
        found=math.pi / math.sqrt(modes[1]),
        held=Tower(stiffness=stiffness, gravity=0.0).contact_time,
    )


def _shock() -> Iterator[Statement]:
    """Hold the shock to the velocity it is made of, and to what an impulse in vectors leaves."""
    speed, after = 1.0, 0.5
    yield compare(
        "eq-13-reference",
        printed=impulse_on_fixed(_MASS, 1e6, speed, 0.0),  # the two-particle run is elastic
        found=_MASS * speed,  # what stops the normal velocity at e_n = 0
    )
    lost, ends = SOURCES["eq-13"].printed, np.array([1.0, _REACHED])
    yield compare(
        "eq-13",
        found=(after * _RATIOS) ** 2,  # of the second line's velocity
        v_0=speed,
        v_s=after,
        alpha=_RATIOS,
        falls=[critical_angle(e) for e in lost(v_0=speed, v_s=after, alpha=ends)],
        rises=[critical_angle(e) for e in (after * ends) ** 2],
        reached=_REACHED,
    )
    normal, tangential = math.sqrt(3) / 2, 0.5

    def left(ratio: float) -> float:
        return (normal * (1 - ratio)) ** 2 + tangential**2

    yield compare(
        "eq-13-direction",
        found=[left(a) for a in _RATIOS],
        alpha=_RATIOS,
        left=left(_REACHED),
        stated=SOURCES["eq-13-direction"].printed(alpha=_REACHED),
        reached=_REACHED,
        angle=critical_angle(left(_REACHED)),
    )
