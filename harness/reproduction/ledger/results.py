"""Results, discussion, conclusion of the source: impulses, angles over height, equation (18)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from harness.cases.tower.impulse import angle_from_impulse_ratio
from harness.observables.reference import PEYNEAU_ROUX
from harness.observables.tower import impulse
from harness.parameters.tower import LAWS, Tower
from harness.reproduction.claims import SOURCES, Printed, Statement, claim, compare
from harness.reproduction.ledger.background import stiffness_of_springs
from harness.reproduction.ledger.samples import MEDIAN, contact_intervals, generator, ratios, run
from harness.theory import incline
from harness.theory.chain import compliance, contact_time_on_fixed

_FLAT = 0.01  # what counts as no change of alpha, a hundredth


def results_statements(printed: Printed) -> Iterator[Statement]:
    """Yield the rows of this part."""
    single = run(Tower(height=1))
    yield compare(
        "text-unit-of-time",
        printed=contact_time_on_fixed(1.0, 1e6, 2.0, 9.81),
        found=contact_intervals(single)[0][1] * single.tower.contact_time,
    )
    yield _collapse()
    yield from _three_particles(printed)
    yield from _runs(printed)
    yield from _lengths(printed)
    yield from _angles()


def _collapse() -> Statement:
    grid = np.linspace(0.0, 3.0, 601)
    off = {}
    for height in (2, 9):
        curves = []
        for stiffness in (1e5, 1e6, 1e7):
            tower_run = run(Tower(height=height, stiffness=stiffness))
            force = np.interp(grid, tower_run.time_over_t0, tower_run.grain_force)
            curves.append(force / run(Tower(height=1, stiffness=stiffness)).grain_force.max())
        off[height + 1] = [float(np.abs(b - a).max()) for a, b in pairwise(curves)]
    return claim("text-collapse", off=off)


def _three_particles(printed: Printed) -> Iterator[Statement]:
    three = run(Tower(height=2))
    early = (three.time_over_t0 > 0.01) & (three.time_over_t0 < 0.4)
    displacements, _, forces = (values[early] for values in three.known_profiles)
    contacts = three.contacts[early]
    yield claim("text-parts", forces=forces, contacts=contacts, displacements=displacements)
    first, second = contact_intervals(three)[:2]
    joins = float(three.time_over_t0[np.argmax(three.contacts == 2)])
    yield compare("text-joins", printed=printed.joins, found=joins)
    yield compare("text-returns", printed=printed.returns, found=second[0])
    yield compare("text-leaves", printed=printed.leaves, found=second[1])
    after = np.searchsorted(three.time_over_t0, second[0], side="right") + 1
    length = int(three.contacts[after])
    yield claim("text-alone", first=first, second=second, length=length)
    once = np.diff(three.time, prepend=-1.0) > 0  # a change of contacts is sampled twice
    force, contacts = three.grain_force[once], three.contacts[once]
    rate = np.gradient(force, three.time[once])
    changes = np.flatnonzero(np.diff(contacts) != 0)
    inside = changes[(changes > 3) & (changes < force.size - 5)]
    kinks = [abs(float(rate[i + 4] - rate[i - 3])) / float(np.abs(rate).max()) for i in inside]
    yield claim("text-aligned", kinks=kinks)


def falls(alpha: Mapping[int, float]) -> bool:
    """Return whether alpha never rises with height by more than a hundredth."""
    return all(alpha[b] <= alpha[a] + _FLAT for a, b in pairwise(sorted(alpha)))


def _runs(printed: Printed) -> Iterator[Statement]:
    runs = ratios()
    first = [impulse(run(Tower(height=1, stiffness=k, speed=v))) / v for k, v in runs]
    yield claim("text-null", first=first)
    stiffnesses, speeds = (tuple(sorted(set(values))) for values in zip(*runs, strict=True))
    yield claim(
        "text-six-runs",
        printed=printed,
        runs=runs,
        heights={n for alpha in runs.values() for n in alpha},
        stiffnesses=stiffnesses,
        speeds=speeds,
        gammas=[Tower(stiffness=k, speed=v).gamma for k, v in runs],
    )
    worst = max(runs, key=lambda case: max(b - a for a, b in pairwise(runs[case].values())))
    yield claim(
        "text-impulses-decrease",
        falling=[falls(alpha) for alpha in runs.values()],
        worst=worst,
        alpha=list(runs[worst].values()),
    )


def longest_chains(height: int, duration: float = 3.0) -> tuple[int, int]:
    """Return the longest chain of the grain, and the longest anywhere, within ``duration`` [t0]."""
    tower_run = run(Tower(height=height, stiffness=MEDIAN[0], speed=MEDIAN[1]), duration)
    longest, length = 0, np.zeros(tower_run.time.size, int)
    for touching in (tower_run.known_profiles.forces > 0).T:
        length = np.where(touching, length + 1, 0)
        longest = max(longest, int(length.max()))
    return int(tower_run.contacts.max()), longest


def _lengths(printed: Printed) -> Iterator[Statement]:
    chains = {n: longest_chains(n) for n in (2, 4, 6, 10, 14, 19, 30)}
    later = {span: longest_chains(60, span)[1] for span in (3.0, 6.0, 12.0)}
    yield claim(
        "text-plateau",
        printed=printed,
        chains=chains,
        listing=[f"n = {n}: {grain}/{anywhere}" for n, (grain, anywhere) in chains.items()],
        later=[f"{length} within {span:g} t0" for span, length in later.items()],
    )
    runs = ratios()
    tall = [[a for n, a in alpha.items() if n >= printed.longest_chain] for alpha in runs.values()]
    varies = max(max(alpha) - min(alpha) for alpha in tall)
    settled = {
        case: 1 + max((n for n in alpha if abs(alpha[n] - alpha[max(alpha)]) > _FLAT), default=0)
        for case, alpha in runs.items()
    }
    yield claim(
        "text-little-effect",
        printed=printed,
        varies=varies,
        flat=_FLAT,
        settled=[f"{n} ({k:.0e} N/m, {v:g} m/s)" for (k, v), n in settled.items()],
    )


def _angles() -> Iterator[Statement]:
    alpha = ratios()[MEDIAN]
    lost, kept = (
        [angle_from_impulse_ratio(alpha[n], reading) for n in (1, 19)]
        for reading in ("lost", "kept")
    )
    yield claim(
        "text-angle-falls",
        falls=falls(alpha),
        lost=lost,
        kept=kept,
        overlap=angle_from_impulse_ratio(ratios("overlap")[MEDIAN][19]),
    )
    yield compare(
        "text-tall-limit",
        printed=lost[1],
        found=PEYNEAU_ROUX.value,
        tolerance=PEYNEAU_ROUX.uncertainty,
        published=PEYNEAU_ROUX,
    )


_HEIGHTS = range(1, 11)


def discussion_statements(printed: Printed) -> Iterator[Statement]:
    """Yield the rows of this part."""
    yield from _two_springs()
    yield from _many_springs(printed)
    yield from _scaling(printed)
    yield from _conclusion(printed)


def spring_energy(springs: int, stiffness: Any, force: Any) -> Any:
    """Return what equal springs in series store under a force, by solving their equilibrium."""
    return 0.5 * force**2 / (stiffness * stiffness_of_springs(springs))


def row_energy(contacts: int) -> float:
    """Return what a row of the source's particles stores [J] at k = 1 N/m under a force of 1 N.

    Half the force times the overlaps that its law asks for.
    """
    forces = np.ones(contacts)
    return float(0.5 * forces @ compliance(contacts, deformable=True) @ forces)


def _two_springs() -> Iterator[Statement]:
    random = generator()
    k, c = random.uniform([10.0, 0.01], [1000.0, 0.5], (50, 2)).T
    yield compare("eq-series-force", found=np.full(50, 2.0 * stiffness_of_springs(2)), k=k, c=c)
    yield compare("eq-u-1", found=spring_energy(1, k, k * c), k=k, c=c)
    yield compare("eq-u-2", found=spring_energy(2, k, k * c), k=k, c=c)


def _many_springs(printed: Printed) -> Iterator[Statement]:
    springs = [spring_energy(n, 1.0, 1.0) for n in _HEIGHTS]
    particles = [row_energy(n) for n in _HEIGHTS]
    n = np.array(_HEIGHTS)
    yield compare("text-u-n", found=[u / springs[0] for u in springs], n=n)
    yield compare("text-u-n-particles", found=[u / particles[0] for u in particles], n=n)
    law, stiffness, first, last = SOURCES["eq-18"], 100.0, 0.2, _HEIGHTS[-1]
    energies = [spring_energy(n, stiffness, stiffness * first) for n in _HEIGHTS]
    yield compare(
        law,
        found=energies,
        n=n,
        k=stiffness,
        c_n=n * first,
        c_1=first,
        times=law.corrected(n=last, k=stiffness, c_1=last * first) / energies[-1],
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
    angles = [angle_from_impulse_ratio(incline.impulse_ratio(n)) for n in heights]
    scaling: dict[str, Any] = {"heights": heights, "angles": angles}
    yield claim("text-energy-scaling", **scaling)
    impulses = [angle_from_impulse_ratio(ratios()[MEDIAN][n]) for n in (2, end)]
    yield compare(
        "text-energy-agrees", printed=angles[2], found=impulses[1], impulses=impulses, **scaling
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
