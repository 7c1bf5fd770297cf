"""Section Methods: rigidity and the two time scales, equations (10) to (12)."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

from harness.cases.tower.impulse_table import STIFFNESSES
from harness.parameters.tower import Tower
from harness.reproduction import as_printed
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, claim, compare
from harness.reproduction.ledger.contact import integrate
from harness.reproduction.ledger.runs import impulses
from harness.reproduction.ledger.samples import generator
from harness.reproduction.source import SOURCES
from harness.theory.critical_angle import critical_angle, no_flight_bound
from harness.theory.energy_map import steady_energy

_MASS, _DIAMETER = 1.0, 1.0  # [kg], [m] of the source's towers
_GLASS_MODULUS, _GLASS_DENSITY, _PACKING = 70e9, 2500.0, 0.6  # [Pa], [kg/m3], [1] usual values


def statements(printed: Printed) -> list[Statement]:
    """Return the rows of this part."""
    return [
        _rigidity(),
        _glass(printed),
        _orders(printed),
        *_stiffnesses(printed),
        *_crest(printed),
        _collision(printed),
        *_contact_time(printed),
        _separation(printed),
    ]


def rise_time(angle_deg: float) -> float:
    """Return the time [s] from well to crest in steady motion, by quadrature over the arc."""
    rise = math.radians(30 - angle_deg)
    energy = steady_energy(angle_deg, 0.25)

    def slowness(left: float) -> float:
        return 1 / math.sqrt(2 * (energy - math.cos(left) + math.cos(rise)))

    return float(quad(slowness, 0.0, rise)[0]) * math.sqrt(_DIAMETER / 9.81)


def _crest(printed: Printed) -> list[Statement]:
    drop = 1 - math.sqrt(3) / 2  # [d] from crest to well of a level row, Pythagoras
    escape = math.sqrt(2 * printed.gravity * drop * 2.0)
    evaluated = escape / 8 / printed.gravity
    needed = brentq(
        lambda r: as_printed.crest_time(r, printed.gravity) - printed.crest_time, 1e-3, 1e6
    )
    fastest, slow = rise_time(no_flight_bound()), rise_time(critical_angle() + 1e-6)
    return [
        compare(
            SOURCES["eq-11"],
            printed=as_printed.crest_time(1.0, printed.gravity),
            found=evaluated,
            computed=f"escape from the well of a level row of radius 1 m takes {escape:.4f} m/s "
            f"(geometry); an eighth of it over g is {evaluated:.4f} s; r is the radius here and "
            "the distance of centres in Table I; the source gives no reason for the factor 1/4",
        ),
        compare(
            SOURCES["text-t-c"],
            printed=printed.crest_time,
            found=evaluated,
            computed=f"{evaluated:.4f} s for r = 1 m; 0.41 s needs r = {needed:.0f} m",
            correction=f"t_c = {evaluated:.3f} s by the formula",
        ),
        claim(
            SOURCES["text-crest-time"],
            holds=fastest <= printed.crest_time <= slow,
            computed=f"steady motion over spheres of 1 m, integrated: {fastest:.3f} s at "
            f"{no_flight_bound():.2f} deg, {slow:.2f} s 1e-6 deg above theta_c, "
            "without bound at theta_c: the number is of the right size though its formula is not",
        ),
    ]


def _collision(printed: Printed) -> Statement:
    random = generator()
    cases = [tuple(random.uniform([50, 0.3, 0.5], [200, 1.0, 5.0])) for _ in range(50)]
    return compare(
        SOURCES["eq-12"],
        printed=[as_printed.collision_time(k, m, g, printed.damping_factor) for k, m, g in cases],
        found=[integrate(k, m, g).time for k, m, g in cases],
        computed="m_eff x'' + gamma x' + k x = 0 integrated until x is 0 again, 50 random cases",
        corrected=[as_printed.collision_time(k, m, g, 0.25) for k, m, g in cases],
    )


def _contact_time(printed: Printed) -> list[Statement]:
    stiffness = printed.stiffnesses[0]
    modes = np.linalg.eigvalsh(stiffness / _MASS * np.array([[1.0, -1.0], [-1.0, 1.0]]))
    found = math.pi / math.sqrt(modes[1])
    held = Tower(stiffness=stiffness, gravity=0.0).contact_time
    effective = stiffness / modes[1]
    return [
        compare(
            SOURCES["text-effective-mass"],
            printed=_MASS * _MASS / (_MASS + _MASS),
            found=float(effective),
            computed=f"stiffness over squared frequency of two free particles: {effective:.4f} kg; "
            "against the fixed particles of this model it is m, not m/2",
        ),
        compare(
            SOURCES["text-t-n"],
            printed=printed.contact_time,
            found=found,
            computed=f"half a period of two free particles of 1 kg: {found:.5f} s; of a grain on a "
            f"fixed one, which is the case at hand, {held:.5f} s",
        ),
    ]


def _separation(printed: Printed) -> Statement:
    by_formula = as_printed.crest_time(1.0, printed.gravity) / printed.contact_time
    fastest = rise_time(no_flight_bound())
    longest = max(row.window_s for row in impulses())
    return claim(
        SOURCES["text-separation"],
        holds=fastest > 10 * printed.contact_time,
        computed=f"the two numbers printed are {printed.crest_time / printed.contact_time:.0f} "
        f"apart, by the formula {by_formula:.1f}; the fastest rise, {fastest:.3f} s, is "
        f"{fastest / printed.contact_time:.0f} contacts long, but only {fastest / longest:.1f} of "
        f"the longest window over which an impulse is taken ({longest:.4f} s, Appendix B)",
    )


def _rigidity() -> Statement:
    stiffness, pressure = 1e5, 9.81  # SI
    per_centimetre = 1 / 100
    # N/m to N/cm, N/m2 to N/cm2
    other = as_printed.rigidity(stiffness * per_centimetre, pressure * per_centimetre**2)
    repaired = stiffness / (pressure * _DIAMETER)
    repaired_other = (stiffness * per_centimetre) / (
        pressure * per_centimetre**2 * (_DIAMETER * 100)
    )
    printed = as_printed.rigidity(stiffness, pressure)
    return claim(
        SOURCES["eq-10"],
        holds=math.isclose(printed, other, rel_tol=1e-12),
        corrected_holds=math.isclose(repaired, repaired_other, rel_tol=1e-12),
        computed=f"1e5 N/m over 9.81 N/m2 is {printed:.5g} in metres and {other:.5g} in "
        f"centimetres: a length; k/(P d) is {repaired:.5g} and {repaired_other:.5g}",
    )


def _glass(printed: Printed) -> Statement:
    pressure = _GLASS_DENSITY * _PACKING * printed.gravity * printed.glass_depth
    found = (_GLASS_MODULUS / pressure) ** (2 / 3)
    return compare(
        SOURCES["text-glass-bead"],
        printed=printed.glass_rigidity,
        found=found,
        computed=f"Hertz contact, (E/P)^(2/3) with E = {_GLASS_MODULUS / 1e9:g} GPa and "
        f"P = {pressure / 1e3:.2f} kPa ({_GLASS_DENSITY:g} kg/m3, packing {_PACKING:g}): "
        f"{found:.0f}; a linear k/P has no value for it",
    )


def _orders(printed: Printed) -> Statement:
    low, high = printed.rigidities
    spanned = math.log10(high / low)
    return compare(
        SOURCES["text-orders-of-magnitude"],
        printed=printed.orders_of_magnitude,
        found=spanned,
        computed=f"log10({high:g}/{low:g}) = {spanned:g}",
        corrected=float(len(STIFFNESSES) - 1),  # steps of ten between its values
    )


def _stiffnesses(printed: Printed) -> list[Statement]:
    weight = _MASS * printed.gravity / _DIAMETER  # N/m, the pressure of a row of disks
    found = [k / weight for k in printed.stiffnesses]
    of_stiffness = printed.rigidities[0] / printed.stiffnesses[0]
    middle = float(np.median(STIFFNESSES)) * of_stiffness
    return [
        compare(
            SOURCES[f"text-stiffness-{name}"],
            printed=kappa,
            found=value,
            computed=f"k d/(m g) of 1 kg and 1 m: {value:.0f}, "
            f"{100 * (value / kappa - 1):.1f} % above; other grains have another",
        )
        for name, kappa, value in zip(("lowest", "highest"), printed.rigidities, found, strict=True)
    ] + [
        compare(
            SOURCES["text-median-rigidity"],
            printed=printed.median_rigidity,
            found=middle,
            computed=f"median of the three used: {middle:g}, that is {middle / of_stiffness:g} N/m",
        )
    ]
