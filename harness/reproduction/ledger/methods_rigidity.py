"""Section Methods: rigidity and stiffness, equation (10)."""

from __future__ import annotations

import math

import numpy as np

from harness.cases.tower.impulse_table import STIFFNESSES
from harness.reproduction import as_printed
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, claim, compare
from harness.reproduction.source import SOURCES

_MASS, _DIAMETER = 1.0, 1.0  # [kg], [m] of the source's towers
_GLASS_MODULUS, _GLASS_DENSITY, _PACKING = 70e9, 2500.0, 0.6  # [Pa], [kg/m3], [1] usual values


def statements(printed: Printed) -> list[Statement]:
    """Return the rows of this part."""
    return [_rigidity(), _glass(printed), _orders(printed), *_stiffnesses(printed)]


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
