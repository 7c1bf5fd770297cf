"""Section Discussion: energies of springs and particles in series, equation (18)."""

from __future__ import annotations

import math

import numpy as np

from harness.reproduction import as_printed
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, compare
from harness.reproduction.ledger.introduction import stiffness_of_springs
from harness.reproduction.ledger.samples import generator
from harness.reproduction.source import SOURCES
from harness.theory.free_chain import compliance

_HEIGHTS = np.arange(1, 11)


def statements(printed: Printed) -> list[Statement]:
    """Return the rows of this part."""
    return [
        *_two_springs(),
        compare(
            SOURCES["text-u-n"],
            printed=_HEIGHTS,
            found=[spring_energy(int(n), 1.0, 1.0) / spring_energy(1, 1.0, 1.0) for n in _HEIGHTS],
            computed="equal springs in series under one force, n = 1 to 10",
        ),
        compare(
            SOURCES["text-u-n-particles"],
            printed=_HEIGHTS,
            found=[row_energy(int(n), 1.0, 1.0) / row_energy(1, 1.0, 1.0) for n in _HEIGHTS],
            computed="n contacts of the deformable law under one force, n = 1 to 10: the particles in "
            "between are pressed from both sides and shorten twice as much",
            corrected=2.0 * _HEIGHTS - 1,
        ),
        _kinetic_energy(),
        _exponent(printed),
    ]


def spring_energy(springs: int, stiffness: float, force: float) -> float:
    """Return what equal springs in series store under a force, by solving their equilibrium."""
    return 0.5 * force**2 / (stiffness * stiffness_of_springs(springs))


def row_energy(contacts: int, stiffness: float, force: float) -> float:
    """Return what a row of the source's particles stores when ``force`` [N] runs through it [J].

    Half the force times the overlaps that its law asks for.
    """
    forces = np.full(contacts, force)
    return float(0.5 * forces @ compliance(contacts, deformable=True) @ forces / stiffness)


def _two_springs() -> list[Statement]:
    random = generator()
    cases = [tuple(random.uniform([10.0, 0.01], [1000.0, 0.5])) for _ in range(50)]
    return [
        compare(
            SOURCES["eq-series-force"],
            printed=[k / 2 * (2 * c) / (k * c) for k, c in cases],
            found=[stiffness_of_springs(2) * 2.0 for _ in cases],
            computed="two springs solved: half the stiffness, twice the compression",
        ),
        compare(
            SOURCES["eq-u-1"],
            printed=[0.5 * k * c**2 for k, c in cases],
            found=[spring_energy(1, k, k * c) for k, c in cases],
            computed="work of the force on one spring",
        ),
        compare(
            SOURCES["eq-u-2"],
            printed=[as_printed.energy_of_two_without_stiffness(c) for _, c in cases],
            found=[spring_energy(2, k, k * c) for k, c in cases],
            computed="two springs under the same force store 2 U_1; the step before has lost k "
            "and is an area",
            corrected=[0.25 * 4 * k * c**2 for k, c in cases],
        ),
    ]


def _kinetic_energy() -> Statement:
    stiffness, first = 100.0, 0.2
    compressions = [int(n) * first for n in _HEIGHTS]  # c_n, of the whole row
    with_square = [
        int(n) * 0.5 * stiffness * c**2 for n, c in zip(_HEIGHTS, compressions, strict=True)
    ]
    found = [spring_energy(int(n), stiffness, stiffness * first) for n in _HEIGHTS]
    return compare(
        SOURCES["eq-18"],
        printed=[
            as_printed.kinetic_energy_of_springs(stiffness, int(n), c)
            for n, c in zip(_HEIGHTS, compressions, strict=True)
        ],
        found=found,
        computed="energy of n springs under one force; the square is missing, and with it c_n = "
        f"n c_1 would still give {with_square[-1] / found[-1]:.0f} times too much at n = "
        f"{_HEIGHTS[-1]}",
        corrected=[int(n) * 0.5 * stiffness * first**2 for n in _HEIGHTS],
    )


def _exponent(printed: Printed) -> Statement:
    heights = np.log(_HEIGHTS)
    speeds = [0.5 * math.log(spring_energy(int(n), 1.0, 1.0)) for n in _HEIGHTS]
    literal = [
        0.5 * math.log(as_printed.kinetic_energy_of_springs(1.0, int(n), float(n)))
        for n in _HEIGHTS
    ]
    own = [0.5 * math.log(row_energy(int(n), 1.0, 1.0)) for n in _HEIGHTS]
    found, as_it_stands, particles = (
        float(np.polyfit(heights, values, 1)[0]) for values in (speeds, literal, own)
    )
    return compare(
        SOURCES["text-sqrt-n"],
        printed=printed.speed_exponent,
        found=found,
        computed=f"slope of log v over log n for springs under one force: {found:.4f}; eq. (18) as "
        f"printed gives {as_it_stands:.2f}, the source's own particles {particles:.2f} from "
        "n = 1 to 10",
    )
