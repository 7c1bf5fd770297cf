"""Introduction and background of the source: equations (1) to (9), angle, shock, angle of rest."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from harness.cases.tower.impulse import impulse_angles
from harness.cases.tower.parameters import Tower
from harness.reproduction.samples import damped_contact, generator
from harness.reproduction.statements import Outcome, holds, statement
from harness.theory.contact import damping_ratio
from harness.theory.incline import after_next_shock, critical_angle, no_flight_bound, steady_energy

LONG = 2000  # shocks after which the energy has its limit
SAMPLES = 100
RESTITUTIONS = np.linspace(0.0, 1.0, 21)
PRINTED_ANGLE = 10.21  # [deg]
Floats = NDArray[np.float64]


@statement("eq-1", "Introduction, eq. (1)", "k' = k/n for n springs in series", unit="k")
def _springs_in_series() -> Outcome:
    n = np.arange(1, 21)
    found = [stiffness_of_springs(int(count)) for count in n]
    return Outcome(found, 1.0 / n, note="equilibrium of n massless springs, n = 1 to 20")


@statement(
    "limit", "Introduction, after eq. (1)",
    "the effect stays significant and vanishes only at infinite stiffness", 1e-4,
    reason="the limit is reached within 1e-4",
)  # fmt: skip
def _stiff_limit() -> Outcome:
    def ratio(stiffness: float, case: Tower | None = None) -> float:
        table = impulse_angles(
            heights=(10,), stiffnesses=(stiffness,), speeds=(2.0,), laws=("deformable",), case=case,
            solver="exact",
        )  # fmt: skip
        return float(table["impulse_ratio"][0])

    # without gravity the stiffness drops out: a base that is rigid from the start would give 1
    return Outcome(ratio(1e12), ratio(1e6, Tower(gravity=0.0)), note="alpha(10) at 1e12 N/m")


def stiffness_of_springs(springs: int) -> float:
    """Return the end-to-end stiffness [k] of equal springs in series, from their equilibrium."""
    balance = 2 * np.eye(springs) - np.eye(springs, k=1) - np.eye(springs, k=-1)
    balance[-1, -1] = 1.0
    force = np.zeros(springs)
    force[-1] = 1.0
    return float(1 / np.linalg.solve(balance, force)[-1])


# ---- energies of the incline [m g d]


def height(along: float, normal: float, angle_deg: float) -> float:
    """Return the height [d] of a point of the row's own frame once the row is tilted."""
    tilt = math.radians(angle_deg)
    return normal * math.cos(tilt) - along * math.sin(tilt)


def depth_of_well(angle_deg: float) -> float:
    """Return the height [d] of a crest over the well before it, from coordinates.

    Spheres stand at 0 and 1; the grain's centre is the tip of an equilateral triangle in the well,
    and one diameter above the second sphere on the crest.
    """
    crest = height(1.0, 0.0, angle_deg) + 1.0
    return crest - height(0.5, math.sqrt(3) / 2, angle_deg)


@statement("table-1-well", "Background, Table I", "C = m g r (1 - cos(pi/6 - theta))", unit="m g d")
def _well() -> Outcome:
    angles = generator().uniform(0.1, 29.9, SAMPLES)
    note = "r is the distance of the centres; the radius, as eq. (11) needs it, gives half of it"
    printed = 1 - np.cos(np.pi / 6 - np.radians(angles))
    return Outcome([depth_of_well(angle) for angle in angles], printed, note=note)


@statement("table-1-gain", "Background, Table I", "dE = m g r sin(theta)", unit="m g d")
def _gain() -> Outcome:
    angles = generator().uniform(0.1, 29.9, SAMPLES)
    found = [height(0.0, 0.0, angle) - height(1.0, 0.0, angle) for angle in angles]
    return Outcome(found, np.sin(np.radians(angles)), note="drop from sphere to sphere")


@statement(
    "constant-contact", "Background, text to Fig. 3",
    "the grain crosses without leaving the row, under less than the normal component of gravity",
)  # fmt: skip
def _constant_contact() -> Outcome:
    energy, tilt = steady_energy(PRINTED_ANGLE, 0.25), PRINTED_ANGLE
    from_vertical = np.radians(np.linspace(-(30 - tilt), 30 + tilt, 2001))
    fallen = math.cos(math.radians(30 - tilt)) - np.cos(from_vertical)
    share = 1 - 2 * (energy + fallen) / np.cos(from_vertical)
    note = (
        f"in steady motion the contact carries {share.min():.3f} to {share.max():.3f} of it; "
        f"contact lasts up to {no_flight_bound():.2f} deg"
    )
    return holds(share.min() > 0 and share.max() <= 1, note)


def iterated(shocks: int, start: float, gained: float, shock: float) -> float:
    """Return E_n [m g d] by n steps of E[j+1] = (E[j] + dE) shock."""
    energy = start
    for _ in range(shocks):
        energy = (energy + gained) * shock
    return energy


@cache
def _sums() -> tuple[tuple[Floats, Floats, Floats, Floats], Floats]:
    """Return n, E_0, dE and shock of random cases, and E_n by the map."""
    random = generator()
    cases = [
        (int(random.integers(3, 12)), *random.uniform([0.05, 0.05, 0.1], [1.0, 1.0, 0.9]))
        for _ in range(SAMPLES)
    ]
    n, start, gained, shock = np.array(cases).T
    return (n, start, gained, shock), np.array([iterated(*case) for case in cases])


@statement(
    "eq-2", "Background, eq. (2)",
    "E_n = E_0 shock^n + dE shock (shock^(n-1) + shock^(n-1) + ... + 1)", unit="m g d",
    correction="the second term is shock^(n-2): every power from n - 1 to 0 once",
)  # fmt: skip
def _energy_sum() -> Outcome:
    (n, start, gained, shock), found = _sums()
    bracket = 2 * shock ** (n - 1) + (1 - shock ** (n - 2)) / (1 - shock)
    right = (1 - shock**n) / (1 - shock)
    return Outcome(
        found,
        start * shock**n + gained * shock * bracket,
        start * shock**n + gained * shock * right,
        f"n steps of the map at {SAMPLES} random n, E_0, dE and shocks",
    )


@statement("eq-3", "Background, eq. (3)", "1 + x + ... + x^n = (1 - x^(n+1))/(1 - x)")
def _geometric_sum() -> Outcome:
    (n, _, _, x), _ = _sums()
    found = [sum(ratio**p for p in range(int(last) + 1)) for ratio, last in zip(x, n, strict=True)]
    return Outcome(found, (1 - x ** (n + 1)) / (1 - x), note="term by term")


@statement(
    "eq-3-index", "Background, eqs. (2) and (3)", "the bracket of eq. (2) is the S_n of eq. (3)",
    correction="it is S_(n-1), (1 - shock^n)/(1 - shock): it has n terms",
)  # fmt: skip
def _index_of_sum() -> Outcome:
    (n, _, _, x), _ = _sums()
    found = [sum(ratio**p for p in range(int(last))) for ratio, last in zip(x, n, strict=True)]
    return Outcome(found, (1 - x ** (n + 1)) / (1 - x), (1 - x**n) / (1 - x))


@statement(
    "eq-4", "Background, eq. (4)",
    "E_n = E_1 shock^(n-1) + dE shock (1 - shock^(n-1))/(1 - shock)", unit="m g d",
)  # fmt: skip
def _energy_after_n() -> Outcome:
    (n, start, gained, shock), found = _sums()
    first, rest = (start + gained) * shock, (1 - shock ** (n - 1)) / (1 - shock)
    return Outcome(found, first * shock ** (n - 1) + gained * shock * rest)


@statement(
    "divergence", "Background, after eq. (4)",
    "E_n goes to infinity if the shock is above 1; else it approaches a constant",
    correction="from shock 1 on, there by dE each shock",
)  # fmt: skip
def _divergence() -> Outcome:
    def grows(shock: float) -> bool:
        return iterated(2 * LONG, 0.1, 0.2, shock) > 1.5 * iterated(LONG, 0.1, 0.2, shock)

    above, at, below = (grows(shock) for shock in (1.01, 1.0, 0.99))
    note = f"E_n grows at shock 1.01: {above}, 1: {at}, 0.99: {below}"
    return holds(above and not at and not below, note, corrected=above and at and not below)


@statement("eq-5", "Background, eq. (5)", "lim E_n = dE shock/(1 - shock)", 1e-11, "m g d",
           reason="round-off of 2000 shocks")  # fmt: skip
def _limit_of_energy() -> Outcome:
    gained, shock = generator().uniform([0.05, 0.1], [1.0, 0.9], (SAMPLES, 2)).T
    found = [iterated(LONG, 0.3, *case) for case in zip(gained, shock, strict=True)]
    return Outcome(found, gained * shock / (1 - shock))


# ---- critical angle and shock


@cache
def fate_angle(shock: float = 0.25) -> float:
    """Return the smallest angle [deg] at which motion lasts, to 1e-6 deg, by the energy map."""

    def lasts(angle: float) -> bool:
        depth = depth_of_well(angle)
        energy = 2 * depth
        for _ in range(LONG):
            if energy < depth:
                return False
            energy = after_next_shock(energy, angle, shock)
        return True

    low, high = 0.0, 30.0
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if lasts(middle) else (middle, high)
    return 0.5 * (low + high)


@statement(
    "eq-6", "Background, eq. (6)",
    "shock/(1 - shock) >= 2 sin^2(pi/12 - theta/4)/sin(theta)", 1e-5, "deg",
    reason="the fate of the energy map is bisected to 1e-6 deg",
    correction="theta/2: 1 - cos(a) = 2 sin^2(a/2) with a = pi/6 - theta",
)  # fmt: skip
def _steady_condition() -> Outcome:
    def root(divisor: float) -> float:
        def margin(angle: float) -> float:
            tilt = math.radians(angle)
            return 1 / 3 - 2 * math.sin(math.pi / 12 - tilt / divisor) ** 2 / math.sin(tilt)

        return float(brentq(margin, 0.5, 29.5))

    return Outcome(fate_angle(), root(4.0), root(2.0), f"closed form {critical_angle():.4f} deg")


@statement("critical-angle", "Background, after eq. (9)", "theta_c = 10.21 deg", 0.005, "deg",
           reason="half of the last digit")  # fmt: skip
def _critical_angle() -> Outcome:
    return Outcome(fate_angle(), PRINTED_ANGLE, note="bisection of the fate of the energy map")


def collide(velocity: Floats, restitution: float) -> Floats:
    """Return the velocity after a collision whose normal is 60 deg off the old contact's."""
    normal = np.array([-1.0, 0.0])
    return np.asarray(velocity - (1 + restitution) * float(velocity @ normal) * normal)


BEFORE = np.array([math.sqrt(3) / 2, -0.5])  # unit speed, 60 deg off the new tangent


def kept_energy(restitution: float) -> float:
    """Return the energy after over the energy before a collision, in vectors."""
    return float(np.sum(collide(BEFORE, restitution) ** 2))


@statement(
    "eq-7", "Background, eq. (7)",
    "shock = |(v' - v)/v'|^2 is the kinetic energy after over that before the shock",
    correction="shock = (v/v')^2; the two agree at e_n = 0 alone",
)  # fmt: skip
def _shock_of_speeds() -> Outcome:
    after = np.array([np.hypot(*collide(BEFORE, e)) for e in RESTITUTIONS])
    return Outcome([kept_energy(e) for e in RESTITUTIONS], (1 - after) ** 2, after**2)


@statement("eq-8", "Background, eq. (8)", "v = sqrt((v'/2)^2 + (e_n v' sqrt(3)/2)^2)", unit="v'")
def _speed_after() -> Outcome:
    found = [float(np.hypot(*collide(BEFORE, e))) for e in RESTITUTIONS]
    return Outcome(found, np.sqrt(0.25 + (RESTITUTIONS * math.sqrt(3) / 2) ** 2))


@statement(
    "eq-9", "Background, eq. (9)", "shock = (1 - sqrt(1/4 + 3/4 e_n^2))^2",
    correction="shock = 1/4 + 3/4 e_n^2; the formula gives 0 where nothing is lost, at e_n = 1",
)  # fmt: skip
def _shock_of_restitution() -> Outcome:
    kept = 0.25 + 0.75 * RESTITUTIONS**2
    return Outcome([kept_energy(e) for e in RESTITUTIONS], (1 - np.sqrt(kept)) ** 2, kept)


@statement(
    "restitution", "Background, on the MFiX runs", "normal restitution is nearly zero (1e-20)",
    1e-4, reason="the energy kept is 1/4 + 3/4 e^2: below 1e-4, e moves it by 1e-8",
    correction="the effective mass against a fixed sphere is m, not the m/2 of MFiX",
)  # fmt: skip
def _restitution_in_mfix() -> Outcome:
    zeta = damping_ratio(1e-20)
    found = damped_contact(1.0, 1.0, 2 * zeta * math.sqrt(0.5)).restitution
    note = f"damping ratio {zeta * math.sqrt(0.5):.4f} in place of {zeta:.4f}"
    return Outcome(found, 1e-20, note=note)


@statement("rest-angle", "Background, last paragraphs",
           "at rest the grain starts above 30 deg only: hysteresis", 0.5, "deg",
           reason="half of the last digit")  # fmt: skip
def _angle_of_rest() -> Outcome:
    def upper_contact(angle: float) -> float:
        directions, tilt = np.radians([60.0, 120.0]), math.radians(angle)
        normals = np.array([np.cos(directions), np.sin(directions)])
        return float(np.linalg.solve(normals, [-math.sin(tilt), math.cos(tilt)])[0])

    found = float(brentq(upper_contact, 0.0, 60.0))
    return Outcome(found, 30.0, note="equilibrium: the contact uphill is without force there")
