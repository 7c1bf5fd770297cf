"""Section Methods: three particles and more, equations (16) and (17), and what they do."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from harness.chain import boundaries, sweeps
from harness.observables.impulse import impulse
from harness.parameters.tower import Tower
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, claim, compare, untestable
from harness.reproduction.ledger.runs import free_collision, run
from harness.reproduction.ledger.samples import RADIUS, off_from_sweeps, rows, touching_chains
from harness.reproduction.source import SOURCES
from harness.theory.free_chain import compliance, final_velocities


def statements(_: Printed) -> Iterator[Statement]:
    """Yield the rows of this part."""
    yield from _three_particles()
    yield from _deformations()
    yield from _chains()
    yield from _closest_pair()
    yield from _stiffness()


def _three_particles() -> Iterator[Statement]:
    ends = [final_velocities(3, deformable=law) for law in (False, True)]
    yield claim("text-not-unique", ends=ends)
    found = free_collision(3).final_velocity / 2.0
    yield claim("text-incomplete", found=found, expected=ends[1])
    both = free_collision(2), free_collision(3)
    yield claim(
        "text-stored",
        total=[float(one.deformations.sum(axis=1).max()) for one in both],
        stored=[float(one.elastic_energy.max() / one.kinetic_energy[0]) for one in both],
    )


def _deformations() -> Iterator[Statement]:
    three = free_collision(3)
    first, second, third = three.deformations.T
    both = (three.profiles.forces > 0).all(axis=1) if three.profiles else np.zeros(0, bool)
    start = int(np.argmax(both))
    yield claim(
        "text-asymmetric",
        joins=three.time_over_t0[start],
        before=float(np.abs(first - second)[:start].max() / first.max()),
        more=bool((second[both] > first[both]).all()),
    )
    yield claim("text-least-deformed", least=third[both] < first[both])


def _chains() -> Iterator[Statement]:
    triples = touching_chains(particles=(3,))
    yield compare(
        "text-partial-equal",
        printed=[chain.deformations[2] for chain in triples],
        found=[sweeps.compressions(chain.centres, 2 * RADIUS)[1] for chain in triples],
    )
    chains = touching_chains()
    for key in ("eq-16", "eq-a7"):
        yield compare(
            key,
            printed=[SOURCES[key].printed(**c.symbols) for c in chains],
            found=[float(c.boundaries[0]) for c in chains],
            corrected=[boundaries.first_boundary(c.centres, RADIUS) for c in chains],
        )
    yield compare(
        "eq-17",
        found=[float(c.boundaries[-1]) for c in chains],
        x=np.array([c.centres[-1] for c in chains]),
        b=np.array([c.boundaries[-2] for c in chains]),
    )
    lowest = min(float(np.linalg.eigvalsh(compliance(n, True))[0]) for n in range(1, 20))
    yield claim("text-unique", lowest=lowest, off=off_from_sweeps(rows()), rows=len(rows()))


def _closest_pair() -> Iterator[Statement]:
    """Try whether the closest two particles touch, anywhere in a row: a claim and its proof."""
    near, far = rows(closest=(0.9, 1.1)), rows(closest=(1.0001, 1.2))
    touch = {row: bool(row.compressions[np.argmin(row.distances)] > 0) for row in (*near, *far)}
    for key in ("text-closest-pair", "text-closest-proof"):
        yield claim(
            key,
            near=[touch[row] for row in near],
            within=[touch[row] for row in near if row.distances.min() < 1.0],
            far=[touch[row] for row in far],
        )


def _stiffness() -> Iterator[Statement]:
    softer = []
    for stiffness in (1e6, 1e6 / 2, 1e6 / 3):
        pair = Tower(stiffness=(1e6, stiffness), base="free", gravity=0.0)
        softer.append(float(run(pair, 1.5).final_velocity[0]) / pair.speed)
    rebound = float(final_velocities(3, deformable=True)[0])
    yield claim("text-softer", softer=softer, rebound=rebound)

    def alphas(base_times: float) -> list[float]:
        """Return alpha(2) and alpha(10) above a base so many times as stiff."""
        one, two, ten = (
            impulse(run(Tower(height=n, stiffness=(*(1e6,) * n, 1e6 * base_times))))
            for n in (1, 2, 10)
        )
        return [two / one, ten / one]

    yield untestable("text-fixed-particle", soft=alphas(1.0), hard=alphas(1e6))
