"""Section Methods: three particles and more, equations (16) and (17), and what they do."""

from __future__ import annotations

import numpy as np

from harness.chain import boundaries, sweeps
from harness.observables.impulse import impulse_until
from harness.observables.windows import window_end
from harness.parameters.tower import Tower
from harness.reproduction import as_printed
from harness.reproduction.claims import Statement, bounded, claim, compare, untestable
from harness.reproduction.ledger.runs import free_collision, run
from harness.reproduction.ledger.samples import RADIUS, rows, touching_chains
from harness.reproduction.source import SOURCES
from harness.theory.free_chain import compliance, final_velocities


def statements() -> list[Statement]:
    """Return the rows of this part."""
    return [
        _not_unique(),
        *_deformations(),
        _partial(),
        *_closest_pair(),
        *_boundary_solution(),
        _recurrence(),
        _unique(),
        _incomplete(),
        _stored(),
        _softer(),
        _fixed_particle(),
    ]


def _not_unique() -> Statement:
    finals = [final_velocities(3, deformable=law) for law in (False, True)]
    conserved = [float(abs(v.sum() - 1)) + float(abs(v @ v - 1)) for v in finals]
    apart = float(np.abs(finals[0] - finals[1]).max())
    return claim(
        SOURCES["text-not-unique"],
        holds=apart > 1e-3 and max(conserved) < 1e-9,
        computed=f"three particles end with {listed(finals[0])} (overlap) and {listed(finals[1])} "
        "(deformable law) of the grain's speed, both with its momentum and energy",
    )


def _deformations() -> list[Statement]:
    three = free_collision(3)
    first, second, third = three.deformations.T
    scale = float(first.max())
    both = (three.profiles.forces > 0).all(axis=1) if three.profiles else np.zeros(0, bool)
    start = int(np.argmax(both))
    before = float(np.abs(first - second)[:start].max()) / scale
    more = bool((second[both] > first[both]).all())
    least = float(np.mean(third[both] < first[both]))
    early = bool((third[both] < first[both])[1:20].all())
    return [
        claim(
            SOURCES["text-asymmetric"],
            holds=before < 1e-9 and more,
            computed=f"difference before it joins (at {three.time_over_t0[start]:.3f} t0): "
            f"{bounded(before)} of the peak; second above first while all touch: {more}",
        ),
        claim(
            SOURCES["text-least-deformed"],
            holds=least == 1.0,
            corrected_holds=early,
            computed=f"true of {100 * least:.0f} % of the time in which all three touch: it is "
            "while the third is being caught up with, not once the grain rebounds",
        ),
    ]


def _partial() -> Statement:
    chains = touching_chains(particles=(3,))
    return compare(
        SOURCES["text-partial-equal"],
        printed=[chain.deformations[2] for chain in chains],
        found=[sweeps.compressions(chain.centres, 2 * RADIUS)[1] for chain in chains],
        computed=f"partial compressions of {len(chains)} random chains recovered from the centres",
    )


def _closest_pair() -> list[Statement]:
    """Return both rows of the claim that the closest two particles touch, anywhere in a row."""
    near, far = rows(closest=(0.9, 1.1)), rows(closest=(1.0001, 1.2))
    found = [
        [bool(row.compressions[np.argmin(row.distances)] > 0) for row in some]
        for some in (near, far)
    ]
    within = [
        touches for row, touches in zip(near, found[0], strict=True) if row.distances.min() < 1.0
    ]
    return [
        claim(
            SOURCES[key],
            holds=all(found[0]) and all(found[1]),
            corrected_holds=all(within) and bool(within),
            computed=f"of {len(within)} random rows whose closest pair is closer than d, "
            f"{sum(within)} have it in contact; of {len(far)} rows without such a pair, "
            f"{sum(found[1])}",
        )
        for key in ("text-closest-pair", "text-closest-proof")
    ]


def _boundary_solution() -> list[Statement]:
    """Return both rows of the formula for the first boundary of a chain."""
    chains = touching_chains()
    return [
        compare(
            SOURCES[key],
            printed=[as_printed.first_boundary(c.centres, RADIUS) for c in chains],
            found=[float(c.boundaries[0]) for c in chains],
            computed=f"{len(chains)} chains of 2 to 9 particles laid side by side from b_0; the "
            "formula is right for odd n and r_0/n too far right for even n",
            corrected=[boundaries.first_boundary(c.centres, RADIUS) for c in chains],
        )
        for key in ("eq-16", "eq-a7")
    ]


def _recurrence() -> Statement:
    chains = touching_chains()
    return compare(
        SOURCES["eq-17"],
        printed=[as_printed.next_boundary(c.centres[-1], c.boundaries[-2]) for c in chains],
        found=[float(c.boundaries[-1]) for c in chains],
        computed=f"last boundary of {len(chains)} random chains",
    )


def _unique() -> Statement:
    lowest = [float(np.linalg.eigvalsh(compliance(n, True))[0]) for n in range(1, 20)]
    some = rows()
    off = max(
        float(np.abs(sweeps.compressions(row.centres, 1.0) - row.compressions).max())
        for row in some
    )
    return claim(
        SOURCES["text-unique"],
        holds=min(lowest) > 0 and off < 1e-12,
        computed="the compressions solve a linear complementarity problem whose matrix "
        f"tridiag(1/2, 1, 1/2) is positive definite (smallest eigenvalue {min(lowest):.4f} at "
        f"19 contacts), hence one solution; sweeps and pivoting differ by {bounded(off)} m on "
        f"{len(some)} random rows",
    )


def listed(values: np.ndarray) -> str:
    """Return numbers for a text."""
    return ", ".join(f"{value:.4f}" for value in values)


def _incomplete() -> Statement:
    final = free_collision(3).final_velocity / 2.0
    reference = final_velocities(3, deformable=True)
    return claim(
        SOURCES["text-incomplete"],
        holds=final[0] < -1e-3 and bool(np.abs(final - reference).max() < 1e-9),
        computed=f"velocities over the grain's: {listed(final)}, by matrix exponentials "
        f"{listed(reference)}",
    )


def _stored() -> Statement:
    two, three = free_collision(2), free_collision(3)
    total = [float(one.deformations.sum(axis=1).max()) for one in (two, three)]
    stored = [float(one.elastic_energy.max() / one.kinetic_energy[0]) for one in (two, three)]
    return claim(
        SOURCES["text-stored"],
        holds=total[1] > total[0] and stored[1] > stored[0],
        computed=f"largest sum of deformations {1e3 * total[0]:.3f} and {1e3 * total[1]:.3f} mm at "
        f"1e6 N/m and 2 m/s ({100 * (total[1] / total[0] - 1):+.1f} %), largest energy "
        f"{stored[0]:.4f} and {stored[1]:.4f} of the grain's ({stored[1] / stored[0]:.2f} times, "
        "not twice as U_n = n U_1 would have it)",
    )


def _softer() -> Statement:
    softer = []
    for stiffness in (1e6, 1e6 / 2, 1e6 / 3):
        pair = Tower(stiffness=(1e6, stiffness), base="free", gravity=0.0)
        softer.append(float(run(pair, 1.5).final_velocity[0]) / pair.speed)
    rebound = float(final_velocities(3, deformable=True)[0])
    return claim(
        SOURCES["text-softer"],
        holds=abs(rebound) < 1e-3,
        computed="the grain keeps "
        + ", ".join(bounded(value) for value in softer)
        + f" of its speed after one free particle of k, k/2 and k/3, and {rebound:.4f} after two "
        "of k: stiffness does not enter the outcome of two bodies, a larger mass does",
    )


def _fixed_particle() -> Statement:
    def alphas(base_times: float) -> list[float]:
        found = []
        for height in (2, 10):
            k = (*(1e6,) * height, 1e6 * base_times)
            found.append(_impulse(height, k) / _impulse(1, (1e6, 1e6 * base_times)))
        return found

    soft, hard = alphas(1.0), alphas(1e6)
    return untestable(
        SOURCES["text-fixed-particle"],
        computed=f"alpha(2) and alpha(10) are {listed(np.array(soft))} with a fixed particle that "
        f"deforms and {listed(np.array(hard))} with one that does not (1e6 N/m, 2 m/s)",
    )


def _impulse(height: int, stiffness: tuple[float, ...]) -> float:
    whole = run(Tower(height=height, stiffness=stiffness))
    return impulse_until(whole, window_end(whole, "turnaround"))
