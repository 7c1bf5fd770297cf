"""Section Methods: rigidity and stiffness, equation (10)."""

from __future__ import annotations

import math

import numpy as np

from harness.cases.tower.impulse_table import STIFFNESSES
from harness.reproduction import as_printed
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import (
    Source,
    Statement,
    claim,
    compare,
    untestable,
)
from harness.reproduction.ledger.widths import last_digit

_MASS, _DIAMETER = 1.0, 1.0  # [kg], [m] of the source's towers
_GLASS_MODULUS, _GLASS_DENSITY, _PACKING = 70e9, 2500.0, 0.6  # [Pa], [kg/m3], [1] usual values


def statements(printed: Printed) -> list[Statement]:
    """Return the rows in the order of the text."""
    return [
        _rigidity(),
        untestable(
            Source(
                "text-coordination",
                "Methods, after eq. (10)",
                "above a rigidity of 10,000 coordination hardly changes and deformations are "
                "small beside gaps",
            ),
            "a result of others on packings; no packings are made here",
        ),
        _glass(printed),
        _orders(printed),
        *_stiffnesses(printed),
    ]


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
        Source("eq-10", "Methods, eq. (10)", "kappa = k/P is a number without dimension"),
        holds=math.isclose(printed, other, rel_tol=1e-12),
        corrected_holds=math.isclose(repaired, repaired_other, rel_tol=1e-12),
        computed=f"1e5 N/m over 9.81 N/m2 is {printed:.5g} in metres and {other:.5g} in "
        f"centimetres: a length; k/(P d) is {repaired:.5g} and {repaired_other:.5g}",
        correction="kappa = k/(P d); as printed for disks only, whose P is a force per length",
        evidence=("tests/verbs/reproduction/ledger/test_methods.py",),
        why="a number without dimension is the same in every unit of length",
    )


def _glass(printed: Printed) -> Statement:
    pressure = _GLASS_DENSITY * _PACKING * printed.gravity * printed.glass_depth
    found = (_GLASS_MODULUS / pressure) ** (2 / 3)
    return compare(
        Source(
            "text-glass-bead",
            "Methods, after eq. (10)",
            "a glass bead under 50 cm of beads has a rigidity of 40,000",
        ),
        printed=printed.glass_rigidity,
        found=found,
        width=last_digit(1e4, "1"),
        computed=f"Hertz contact, (E/P)^(2/3) with E = {_GLASS_MODULUS / 1e9:g} GPa and "
        f"P = {pressure / 1e3:.2f} kPa ({_GLASS_DENSITY:g} kg/m3, packing {_PACKING:g}): "
        f"{found:.0f}; a linear k/P has no value for it",
        evidence=("tests/verbs/reproduction/ledger/test_perturbed.py",),
    )


def _orders(printed: Printed) -> Statement:
    low, high = printed.rigidities
    spanned = math.log10(high / low)
    return compare(
        Source(
            "text-orders-of-magnitude",
            "Methods, after eq. (10); Results, before Fig. 10",
            "rigidities of 1e4 to 1e6 span three orders of magnitude",
        ),
        printed=printed.orders_of_magnitude,
        found=spanned,
        width=last_digit(1.0, "decades"),
        computed=f"log10({high:g}/{low:g}) = {spanned:g}",
        corrected=float(len(STIFFNESSES) - 1),  # steps of ten between its values
        correction="three values, two orders of magnitude",
        evidence=("tests/verbs/reproduction/ledger/test_perturbed.py",),
    )


def _stiffnesses(printed: Printed) -> list[Statement]:
    weight = _MASS * printed.gravity / _DIAMETER  # N/m, the pressure of a row of disks
    found = [k / weight for k in printed.stiffnesses]
    of_stiffness = printed.rigidities[0] / printed.stiffnesses[0]
    middle = float(np.median(STIFFNESSES)) * of_stiffness
    return [
        compare(
            Source(
                f"text-stiffness-{name}",
                "Methods, after eq. (10)",
                f"rigidity {kappa:g} is a stiffness of {k:g} N/m at 9.81 m/s2",
            ),
            printed=kappa,
            found=value,
            width=last_digit(kappa, "1"),
            computed=f"k d/(m g) of 1 kg and 1 m: {value:.0f}, "
            f"{100 * (value / kappa - 1):.1f} % above; other grains have another",
            evidence=("tests/parameters/test_tower.py",),
        )
        for name, kappa, k, value in zip(
            ("lowest", "highest"), printed.rigidities, printed.stiffnesses, found, strict=True
        )
    ] + [
        compare(
            Source(
                "text-median-rigidity", "Methods, before Fig. 6", "100,000 is the median rigidity"
            ),
            printed=printed.median_rigidity,
            found=middle,
            width=last_digit(1e5, "1"),
            computed=f"median of the three used: {middle:g}, that is {middle / of_stiffness:g} N/m",
            evidence=("tests/verbs/reproduction/ledger/test_perturbed.py",),
        )
    ]
