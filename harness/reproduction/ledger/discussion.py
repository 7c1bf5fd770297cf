"""Sections Discussion and Conclusion: energies of springs in series, equation (18), and angles."""

from __future__ import annotations

import math

import numpy as np

from harness.cases.tower.impulse_angles import angle_from_impulse_ratio
from harness.parameters.tower import LAWS, Tower
from harness.reproduction import as_printed
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, claim, compare
from harness.reproduction.ledger.introduction import stiffness_of_springs
from harness.reproduction.ledger.results_impulse import longest_chains
from harness.reproduction.ledger.runs import ratios, run
from harness.reproduction.ledger.samples import generator
from harness.reproduction.source import SOURCES
from harness.theory import energy_scaling
from harness.theory.free_chain import compliance

_HEIGHTS = np.arange(1, 11)


def statements(printed: Printed) -> list[Statement]:
    """Return the rows of this part."""
    return [
        *_energies(printed),
        *_scaling(printed),
        _longest(printed),
        _differences(printed),
        _halved(printed),
    ]


def _scaling(printed: Printed) -> list[Statement]:
    end = printed.longest_chain
    angles = [
        angle_from_impulse_ratio(energy_scaling.impulse_ratio(n)) for n in (1, 2, end, 2 * end)
    ]
    alpha = ratios()[1e6, 2.0]
    impulses = [angle_from_impulse_ratio(alpha[n]) for n in (2, end)]
    return [
        claim(
            SOURCES["text-energy-scaling"],
            holds=angles[0] > angles[1] > angles[2] > angles[3] + 0.5,
            computed="theta_c at n = 1, 2, "
            f"{end}, {2 * end}: " + ", ".join(f"{a:.2f}" for a in angles) + " deg",
        ),
        compare(
            SOURCES["text-energy-agrees"],
            printed=angles[2],
            found=impulses[1],
            computed=f"theta_c at n = 2 and {end}: {angles[1]:.2f} and {angles[2]:.2f} deg by "
            f"1/sqrt(n), {impulses[0]:.2f} and {impulses[1]:.2f} deg by the impulses (1e6 N/m, "
            "2 m/s): alike in that both fall, in nothing else",
        ),
    ]


def _longest(printed: Printed) -> Statement:
    tallest = printed.heights[1]
    grain, anywhere = longest_chains(tallest)
    return claim(
        SOURCES["text-longest-chain"],
        holds=max(grain, anywhere) <= printed.longest_chain,
        computed=f"{tallest + 1} particles, 3 t0: {grain} contacts in the chain of the grain, at "
        f"most {anywhere} anywhere (1e6 N/m, 2 m/s); under the overlap law "
        f"{int(run(Tower(height=tallest, law='overlap')).contacts.max())}, from the start",
    )


def _differences(printed: Printed) -> Statement:
    softest = 1 / printed.rigidities[1]  # dx/d under a force of P d^2
    found = 100 * softest * (10 - 1)
    struck = run(Tower(height=1, stiffness=1e7))
    peak = 100 * float(struck.grain_force.max()) / 1e7
    return compare(
        SOURCES["text-differences"],
        printed=printed.difference_percent,
        found=found,
        tolerance=printed.difference_percent,
        computed=f"from the confining force to ten times it a diameter changes by {found:.1e} % at "
        f"k/(P d) = 1e6; in the run at 2 m/s particles deform by {peak:.3f} %",
        correction=f"less than {found:.0e} % of the diameter",
    )


def _halved(printed: Printed) -> Statement:
    least = {law: min(min(a.values()) for a in ratios(law).values()) for law in LAWS}
    return compare(
        SOURCES["text-halved"],
        printed=printed.halved,
        found=least["deformable"],
        computed=f"smallest alpha of the six runs {least['deformable']:.4f} (deformable), "
        f"{least['overlap']:.4f} (overlap law)",
    )


def _energies(printed: Printed) -> list[Statement]:
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
            computed="n contacts of the deformable law under one force, n = 1 to 10: the particles "
            "in between are pressed from both sides and shorten twice as much",
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
