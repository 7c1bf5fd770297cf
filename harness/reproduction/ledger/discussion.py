"""Sections Discussion and Conclusion: energies of springs in series, equation (18), and angles."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from harness.cases.tower.impulse_angles import angle_from_impulse_ratio
from harness.parameters.tower import LAWS, Tower
from harness.reproduction import as_printed
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, claim, compare
from harness.reproduction.ledger.introduction import stiffness_of_springs
from harness.reproduction.ledger.results import longest_chains
from harness.reproduction.ledger.runs import MEDIAN, ratios, run
from harness.reproduction.ledger.samples import generator
from harness.theory import energy_scaling
from harness.theory.free_chain import compliance

_HEIGHTS = range(1, 11)


def statements(printed: Printed) -> Iterator[Statement]:
    """Yield the rows of this part."""
    yield from _two_springs()
    yield from _many_springs(printed)
    yield from _scaling(printed)
    yield from _conclusion(printed)


def spring_energy(springs: int, stiffness: float, force: float) -> float:
    """Return what equal springs in series store under a force, by solving their equilibrium."""
    return 0.5 * force**2 / (stiffness * stiffness_of_springs(springs))


def row_energy(contacts: int, stiffness: float, force: float) -> float:
    """Return what a row of the source's particles stores when ``force`` [N] runs through it [J].

    Half the force times the overlaps that its law asks for.
    """
    forces = np.full(contacts, force)
    return float(0.5 * forces @ compliance(contacts, deformable=True) @ forces / stiffness)


def _two_springs() -> Iterator[Statement]:
    random = generator()
    cases = [tuple(random.uniform([10.0, 0.01], [1000.0, 0.5])) for _ in range(50)]
    yield compare(
        "eq-series-force",
        printed=[k / 2 * (2 * c) / (k * c) for k, c in cases],
        found=[stiffness_of_springs(2) * 2.0 for _ in cases],
    )
    yield compare(
        "eq-u-1",
        printed=[0.5 * k * c**2 for k, c in cases],
        found=[spring_energy(1, k, k * c) for k, c in cases],
    )
    yield compare(
        "eq-u-2",
        printed=[as_printed.energy_of_two_without_stiffness(c) for _, c in cases],
        found=[spring_energy(2, k, k * c) for k, c in cases],
        corrected=[0.25 * 4 * k * c**2 for k, c in cases],
    )


def _many_springs(printed: Printed) -> Iterator[Statement]:
    springs = [spring_energy(n, 1.0, 1.0) for n in _HEIGHTS]
    particles = [row_energy(n, 1.0, 1.0) for n in _HEIGHTS]
    yield compare("text-u-n", printed=_HEIGHTS, found=[u / springs[0] for u in springs])
    yield compare(
        "text-u-n-particles",
        printed=_HEIGHTS,
        found=[u / particles[0] for u in particles],
        corrected=[2.0 * n - 1 for n in _HEIGHTS],
    )
    stiffness, first, last = 100.0, 0.2, _HEIGHTS[-1]
    found = [spring_energy(n, stiffness, stiffness * first) for n in _HEIGHTS]
    yield compare(
        "eq-18",
        printed=[as_printed.kinetic_energy_of_springs(stiffness, n, n * first) for n in _HEIGHTS],
        found=found,
        corrected=[n * 0.5 * stiffness * first**2 for n in _HEIGHTS],
        times=last * 0.5 * stiffness * (last * first) ** 2 / found[-1],
        last=last,
    )
    literal = [as_printed.kinetic_energy_of_springs(1.0, n, float(n)) for n in _HEIGHTS]
    exponent, of_literal, of_particles = (
        float(np.polyfit(np.log(_HEIGHTS), [0.5 * math.log(u) for u in energies], 1)[0])
        for energies in (springs, literal, particles)
    )
    yield compare(
        "text-sqrt-n",
        printed=printed.speed_exponent,
        found=exponent,
        literal=of_literal,
        particles=of_particles,
    )


def _scaling(printed: Printed) -> Iterator[Statement]:
    end = printed.longest_chain
    heights = (1, 2, end, 2 * end)
    angles = [angle_from_impulse_ratio(energy_scaling.impulse_ratio(n)) for n in heights]
    yield claim(
        "text-energy-scaling",
        holds=angles[0] > angles[1] > angles[2] > angles[3] + 0.5,
        heights=heights,
        angles=angles,
    )
    impulses = [angle_from_impulse_ratio(ratios()[MEDIAN][n]) for n in (2, end)]
    yield compare(
        "text-energy-agrees",
        printed=angles[2],
        found=impulses[1],
        end=end,
        angles=angles,
        impulses=impulses,
    )


def _conclusion(printed: Printed) -> Iterator[Statement]:
    tallest = printed.heights[1]
    grain, anywhere = longest_chains(tallest)
    yield claim(
        "text-longest-chain",
        holds=max(grain, anywhere) <= printed.longest_chain,
        particles=tallest + 1,
        grain=grain,
        anywhere=anywhere,
        overlap=int(run(Tower(height=tallest, law="overlap")).contacts.max()),
    )
    struck = run(Tower(height=1, stiffness=1e7))
    yield compare(
        "text-differences",
        printed=printed.difference_percent,
        found=100 * (1 / printed.rigidities[1]) * (10 - 1),  # dx/d is P d/k under a force of P d^2
        tolerance=printed.difference_percent,
        peak=100 * float(struck.grain_force.max()) / 1e7,
    )
    least = {law: min(min(a.values()) for a in ratios(law).values()) for law in LAWS}
    yield compare(
        "text-halved",
        printed=printed.halved,
        found=least["deformable"],
        overlap=least["overlap"],
    )
