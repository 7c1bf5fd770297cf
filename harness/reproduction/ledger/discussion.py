"""Sections Discussion and Conclusion: energies of springs in series, equation (18), and angles."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from harness.cases.tower.impulse_angles import angle_from_impulse_ratio
from harness.parameters.tower import LAWS, Tower
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, claim, compare
from harness.reproduction.ledger.introduction import stiffness_of_springs
from harness.reproduction.ledger.results import longest_chains
from harness.reproduction.ledger.runs import MEDIAN, ratios, run
from harness.reproduction.ledger.samples import generator
from harness.reproduction.source import SOURCES
from harness.theory import energy_scaling
from harness.theory.free_chain import compliance

_HEIGHTS = range(1, 11)


def statements(printed: Printed) -> Iterator[Statement]:
    """Yield the rows of this part."""
    yield from _two_springs()
    yield from _many_springs(printed)
    yield from _scaling(printed)
    yield from _conclusion(printed)


def spring_energy(springs: int, stiffness: Any, force: Any) -> Any:
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
    k, c = random.uniform([10.0, 0.01], [1000.0, 0.5], (50, 2)).T
    yield compare("eq-series-force", found=np.full(50, 2.0 * stiffness_of_springs(2)), k=k, c=c)
    yield compare("eq-u-1", found=spring_energy(1, k, k * c), k=k, c=c)
    yield compare("eq-u-2", found=spring_energy(2, k, k * c), k=k, c=c)


def _many_springs(printed: Printed) -> Iterator[Statement]:
    springs = [spring_energy(n, 1.0, 1.0) for n in _HEIGHTS]
    particles = [row_energy(n, 1.0, 1.0) for n in _HEIGHTS]
    n = np.array(_HEIGHTS)
    yield compare("text-u-n", found=[u / springs[0] for u in springs], n=n)
    yield compare("text-u-n-particles", found=[u / particles[0] for u in particles], n=n)
    law, stiffness, first, last = SOURCES["eq-18"], 100.0, 0.2, _HEIGHTS[-1]
    found = [spring_energy(n, stiffness, stiffness * first) for n in _HEIGHTS]
    yield compare(
        law,
        found=found,
        n=n,
        k=stiffness,
        c_n=n * first,
        c_1=first,
        times=law.corrected(n=last, k=stiffness, c_1=last * first) / found[-1],
        last=last,
    )
    literal = law.printed(n=n, k=1.0, c_n=1.0 * n)
    exponent, of_literal, of_particles = (
        float(np.polyfit(np.log(n), 0.5 * np.log(energies), 1)[0])
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
    told: dict[str, Any] = {"heights": heights, "angles": angles}
    yield claim("text-energy-scaling", **told)
    impulses = [angle_from_impulse_ratio(ratios()[MEDIAN][n]) for n in (2, end)]
    yield compare(
        "text-energy-agrees", printed=angles[2], found=impulses[1], impulses=impulses, **told
    )


def _conclusion(printed: Printed) -> Iterator[Statement]:
    tallest = printed.heights[1]
    yield claim(
        "text-longest-chain",
        printed=printed,
        chains=longest_chains(tallest),
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
        "text-halved", printed=printed.halved, found=least["deformable"], overlap=least["overlap"]
    )
