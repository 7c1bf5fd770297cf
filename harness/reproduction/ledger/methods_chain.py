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
    finals = [final_velocities(3, deformable=law) for law in (False, True)]
    conserved = [float(abs(v.sum() - 1)) + float(abs(v @ v - 1)) for v in finals]
    apart = float(np.abs(finals[0] - finals[1]).max())
    yield claim("text-not-unique", holds=apart > 1e-3 and max(conserved) < 1e-9, ends=finals)
    found = free_collision(3).final_velocity / 2.0
    yield claim(
        "text-incomplete",
        holds=found[0] < -1e-3 and bool(np.abs(found - finals[1]).max() < 1e-9),
        found=found,
        expected=finals[1],
    )
    both = free_collision(2), free_collision(3)
    total = [1e3 * float(one.deformations.sum(axis=1).max()) for one in both]
    stored = [float(one.elastic_energy.max() / one.kinetic_energy[0]) for one in both]
    yield claim(
        "text-stored",
        holds=total[1] > total[0] and stored[1] > stored[0],
        total=total,
        grows=100 * (total[1] / total[0] - 1),
        stored=stored,
        times=stored[1] / stored[0],
    )


def _deformations() -> Iterator[Statement]:
    three = free_collision(3)
    first, second, third = three.deformations.T
    both = (three.profiles.forces > 0).all(axis=1) if three.profiles else np.zeros(0, bool)
    start = int(np.argmax(both))
    before = float(np.abs(first - second)[:start].max() / first.max())
    more = bool((second[both] > first[both]).all())
    yield claim(
        "text-asymmetric",
        holds=before < 1e-9 and more,
        joins=three.time_over_t0[start],
        before=before,
        more=more,
    )
    least = third[both] < first[both]
    part = float(np.mean(least))
    yield claim(
        "text-least-deformed",
        holds=part == 1.0,
        corrected_holds=bool(least[1:20].all()),
        part=100 * part,
    )


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
        x=[float(c.centres[-1]) for c in chains],
        b=[float(c.boundaries[-2]) for c in chains],
    )
    lowest = min(float(np.linalg.eigvalsh(compliance(n, True))[0]) for n in range(1, 20))
    off = off_from_sweeps(rows())
    yield claim(
        "text-unique", holds=lowest > 0 and off < 1e-12, lowest=lowest, off=off, rows=len(rows())
    )


def _closest_pair() -> Iterator[Statement]:
    """Try whether the closest two particles touch, anywhere in a row: a claim and its proof."""
    near, far = (
        [
            (row.distances.min(), bool(row.compressions[np.argmin(row.distances)] > 0))
            for row in some
        ]
        for some in (rows(closest=(0.9, 1.1)), rows(closest=(1.0001, 1.2)))
    )
    within = [touches for distance, touches in near if distance < 1.0]
    beyond = [touches for _, touches in far]
    for key in ("text-closest-pair", "text-closest-proof"):
        yield claim(
            key,
            holds=all(touches for _, touches in near) and all(beyond),
            corrected_holds=all(within) and bool(within),
            within=len(within),
            touching=sum(within),
            beyond=len(beyond),
            of_them=sum(beyond),
        )


def _stiffness() -> Iterator[Statement]:
    softer = []
    for stiffness in (1e6, 1e6 / 2, 1e6 / 3):
        pair = Tower(stiffness=(1e6, stiffness), base="free", gravity=0.0)
        softer.append(float(run(pair, 1.5).final_velocity[0]) / pair.speed)
    rebound = float(final_velocities(3, deformable=True)[0])
    yield claim("text-softer", holds=abs(rebound) < 1e-3, softer=softer, rebound=rebound)

    def alphas(base_times: float) -> list[float]:
        """Return alpha(2) and alpha(10) above a base so many times as stiff."""
        one, two, ten = (
            impulse(run(Tower(height=n, stiffness=(*(1e6,) * n, 1e6 * base_times))))
            for n in (1, 2, 10)
        )
        return [two / one, ten / one]

    yield untestable("text-fixed-particle", soft=alphas(1.0), hard=alphas(1e6))
