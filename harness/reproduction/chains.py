"""Methods, equations (14) to (17), and Appendix A: pairs, rows and touching chains of particles."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.optimize import brentq

from harness.reproduction import Floats, Statement, generator
from harness.reproduction.incline import OURS
from harness.solvers.chain import compressions_by_sweeps, contact_forces, first_boundary
from harness.theory.chain import compliance, series_stiffness, static_forces

RADIUS = 0.5  # [m] of all particles here
THREE = "Methods, before eq. (16)"
BOUNDARIES = "Appendix A, boundaries within a chain"


@dataclass(frozen=True, eq=False)
class Particles:
    """N particles of diameter 1 m in a row, with the partial compressions of their contacts.

    ``boundaries`` (N+1,) [m] are those that a touching chain was laid out from; a row has none.
    """

    centres: Floats  # (N,) [m]
    compressions: Floats  # (N-1,) [m] 0 where open
    boundaries: Floats

    @property
    def deformations(self) -> Floats:
        """Return how much each diameter is shortened (N,) [m], by the boundaries of a chain."""
        if self.boundaries.size:
            return np.asarray(2 * RADIUS - np.diff(self.boundaries))
        return np.convolve(self.compressions, [1, 1])

    @property
    def distances(self) -> Floats:
        """Return the distances of neighbouring centres (N-1,) [m]."""
        return np.diff(self.centres)


def touching_chains(count: int = 200, particles: Sequence[int] = range(2, 10)) -> list[Particles]:
    """Return touching chains, each of one of the given numbers of particles.

    They are laid out from a random first boundary: each particle is as wide as its two partial
    compressions leave it, and its centre is its middle.
    """
    random, chains = generator(), []
    for _ in range(count):
        n = int(random.choice(particles))
        compressions = random.uniform(0.001, 0.1, n - 1)
        widths = 1.0 - np.convolve(compressions, [1, 1])
        edges = random.uniform(-1, 1) + np.concatenate(([0.0], np.cumsum(widths)))
        chains.append(Particles(0.5 * (edges[1:] + edges[:-1]), compressions, edges))
    return chains


@cache
def rows(closest: float = 0.9, farthest: float = 1.1) -> list[Particles]:
    """Return 500 rows of 3 to 9 particles by their one solution, of random distances [m]."""
    random, sampled = generator(), []
    for _ in range(500):
        distances = random.uniform(closest, farthest, int(random.integers(2, 9)))
        centres = np.concatenate(([0.0], np.cumsum(distances)))
        sampled.append(Particles(centres, contact_forces(centres, 1.0, 1.0), np.empty(0)))
    return sampled


# ---- springs in series


def springs() -> Iterator[Statement]:
    """Yield equation (1), the stiffness of springs in series."""
    n = np.arange(1, 21)
    yield Statement("eq-1", "Introduction, eq. (1)", "k' = k/n for n springs in series",
        [springs_in_series(count) for count in n.tolist()], 1.0 / n, unit="k",
        note="equilibrium of n massless springs, n = 1 to 20")  # fmt: skip


def springs_in_series(count: int) -> float:
    """Return the end-to-end stiffness [k] of equal springs in series, from their equilibrium."""
    balance = 2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    balance[-1, -1] = 1.0
    force = np.zeros(count)
    force[-1] = 1.0
    return float(1 / np.linalg.solve(balance, force)[-1])


def row_energy(contacts: int) -> float:
    """Return the energy of a row of the source's particles [J] at 1 N/m under 1 N.

    It is half the force times the overlaps of the deformable law.
    """
    forces = np.ones(contacts)
    return float(0.5 * forces @ compliance(contacts, deformable=True) @ forces)


def series_energy() -> Iterator[Statement]:
    """Yield the displays of the discussion and equation (18): energy of springs in series."""
    n = np.arange(1, 11)
    springs = np.array([spring_energy(count, 1.0, 1.0) for count in n.tolist()])
    particles = np.array([row_energy(count) for count in n.tolist()])
    k, c = generator().uniform([10.0, 0.01], [1000.0, 0.5], (50, 2)).T
    yield Statement("eq-u-2", "Discussion, third display",
        "U_2 = 1/2 (1/2 k)(2 c_1)^2 = 1/4 4 c_1^2 = 2 U_1",
        [spring_energy(2, a, a * b) for a, b in zip(k, c, strict=True)], c**2, k * c**2,
        tolerance=1e-11, unit="J", reason="round-off",
        correction="1/4 k 4 c_1^2 = k c_1^2: the step before has lost k")  # fmt: skip
    where = "Discussion, after the displays"
    yield Statement("u-n", where, "U_n = n U_1", springs / springs[0], n, unit="U_1",
        note="springs in series under one force")  # fmt: skip
    yield Statement("u-n-particles", where,
        "U_n = n U_1 holds for the source's own deformable particles", particles / particles[0], n,
        2 * n - 1, unit="U_1",
        correction="U_n = (2n - 1) U_1: inner ones are pressed from both sides")  # fmt: skip
    stiffness, first = 100.0, 0.2
    yield Statement("eq-18", "Discussion, eq. (18)", "1/2 m v^2 = U_n = n U_1 = n (1/2 k c_n)",
        [spring_energy(count, stiffness, stiffness * first) for count in n.tolist()],
        n * 0.5 * stiffness * (n * first), n * 0.5 * stiffness * first**2, tolerance=1e-11,
        unit="J", reason="round-off",
        correction="n (1/2 k c_1^2): squared, and of one spring")  # fmt: skip
    slopes = [float(np.polyfit(np.log(n), 0.5 * np.log(u), 1)[0]) for u in (springs, particles)]
    yield Statement("sqrt-n", "Discussion, eq. (18)", "v ~ sqrt(n)", slopes[0], 0.5,
        tolerance=1e-9, reason="slope of an exact power",
        note=f"{slopes[1]:.2f} for the source's own particles")  # fmt: skip


def spring_energy(springs: int, stiffness: float, force: float) -> float:
    """Return the energy of equal springs in series under a force [J], from their equilibrium."""
    return 0.5 * force**2 / (stiffness * springs_in_series(springs))


# ---- two particles


def pairs() -> Iterator[Statement]:
    """Yield equations (14) and (15): the forces of pairs, from the slope of their energy."""
    distances = 1.0 - generator().uniform(1e-4, 0.2, 50)
    forces = np.array([slope_of_energy(np.array([0.0, d])) for d in distances])
    size, reason = 1e6 * (1.0 - distances), "central difference of energies of 1e4 J over 1e-7 m"
    yield Statement("eq-14", "Methods, eq. (14)", "F = k dx, for two particles",
        np.abs(forces[:, 0]), size, tolerance=0.01, unit="N", reason=reason,
        note="slope of the energy")  # fmt: skip
    printed = np.outer(size, [1.0, -1.0])
    yield Statement("eq-15", "Methods, eq. (15)",
        "a_1 = k/m (2r_0 - (x_2 - x_1)), a_2 = -k/m (2r_0 - (x_2 - x_1))", forces, printed,
        -printed, tolerance=0.01, unit="m/s2", reason=reason,
        correction="signs of a_1 and a_2 exchanged, for x_1 < x_2")  # fmt: skip


def slope_of_energy(x: Floats, step: float = 1e-7) -> Floats:
    """Return the forces [N] on particles at ``x`` (N,) [m], k = 1e6 N/m, from the elastic energy.

    The energy sum f c/2 is differentiated centrally, so that no sign is put in by hand.
    """

    def energy(place: Floats) -> float:
        force = contact_forces(place, 2 * RADIUS, 1e6)
        return float(0.5 * force @ (2 * RADIUS - np.diff(place)))

    moves = step * np.eye(x.size)
    return np.array([(energy(x - move) - energy(x + move)) / (2 * step) for move in moves])


# ---- boundaries of touching chains


def boundaries() -> Iterator[Statement]:
    """Yield equations (16) and (17): the boundaries of a chain from its centres."""

    def formula(centres: Floats) -> float:
        n = centres.size
        i = np.arange(1, n + 1)
        return float((-1) ** n * RADIUS + ((-1.0) ** (i + 1) * (2 * (n - i) + 1)) @ centres) / n

    near, far = rows(), rows(1.0001, 1.2)
    closer = _closest_touch([row for row in near if row.distances.min() < 1.0])
    yield Statement("closest-pair", f"{THREE}; Appendix A, proof by contradiction",
        "the two particles whose centres are closest are in contact",
        all(_closest_touch([*near, *far])), corrected=all(closer),
        note=f"closer than d: {sum(closer)} of {len(closer)} touch; else "
        f"{sum(_closest_touch(far))}",
        correction="only if they are closer than a diameter")  # fmt: skip
    chains = touching_chains()
    yield Statement("eq-16", "Methods, eq. (16); Appendix A, eq. (A7)",
        "b_0 = ((-1)^n r_0 + sum (-1)^(i+1) (2(n-i)+1) x_i)/n",
        [c.boundaries[0] for c in chains], [formula(c.centres) for c in chains],
        [first_boundary(c.centres, RADIUS) for c in chains], unit="m",
        note="200 chains of 2 to 9 particles, laid out from b_0",
        correction="the r_0 term is ((-1)^n - 1)/2 r_0: none for even n")  # fmt: skip
    yield Statement("eq-17", "Methods, eq. (17)", "b_n = x_n + (x_n - b_(n-1))",
        [c.boundaries[-1] for c in chains], [2 * c.centres[-1] - c.boundaries[-2] for c in chains],
        unit="m")  # fmt: skip
    lowest = min(float(np.linalg.eigvalsh(compliance(n, True))[0]) for n in range(1, 20))
    errors = [
        np.abs(compressions_by_sweeps(row.centres, 2 * RADIUS) - row.compressions).max()
        for row in near
    ]
    yield Statement("unique", "Methods, after eq. (17)",
        "positions and constraints fix contacts and deformations uniquely",
        lowest > 0 and max(errors) < 1e-12,
        reason="eigenvalues above 0; two methods without common code to 1e-12 m",
        note=f"the matrix of the complementarity problem is positive definite ({lowest:.4f})",
    )  # fmt: skip


def _closest_touch(some: Sequence[Particles]) -> list[bool]:
    return [bool(row.compressions[np.argmin(row.distances)] > 0) for row in some]


def lengths() -> Iterator[Statement]:
    """Yield equation (A2) and the text on the length of a chain."""
    printed, right, chains = [], [], touching_chains()
    for chain in chains:
        n, x, first = chain.centres.size, chain.centres, chain.boundaries[0]
        printed.append(np.sum(2 * x * (-1) ** (n + 1) + first * (-1) ** n))
        right.append(2 * (-1.0) ** (n - np.arange(1, n + 1)) @ x + (-1) ** n * first)
    yield Statement("eq-a2", "Appendix A, eq. (A2)", "b_n = sum (2 x_i (-1)^(n+1) + b_0 (-1)^n)",
        [c.boundaries[-1] for c in chains], printed, right, tolerance=1e-11, unit="m",
        reason="round-off", correction="b_n = sum 2 (-1)^(n-i) x_i + (-1)^n b_0")  # fmt: skip
    threes = touching_chains(50, (3,))
    alternating = [
        2 * (c.centres[2] - c.centres[1] + c.centres[0] - c.boundaries[0]) for c in threes
    ]
    yield Statement("eq-chain-length", BOUNDARIES,
        "b_3 - b_0 = 2x_3 - 2x_2 + 2x_1 - 2b_0 for three",
        [c.boundaries[3] - c.boundaries[0] for c in threes], alternating, unit="m")  # fmt: skip

    def length(centres: Floats, first: float) -> float:
        edge = first
        for centre in centres.tolist():
            edge = 2 * centre - edge
        return edge - first

    odd = [touching_chains(1, (n,))[0] for n in (3, 5, 7)]
    changes = [
        length(c.centres, c.boundaries[0] + 0.01) - length(c.centres, c.boundaries[0]) for c in odd
    ]
    yield Statement("odd-chains", BOUNDARIES,
        "the centres give the length of a chain, and so all boundaries of odd ones", changes,
        np.zeros(3), tolerance=1e-12, unit="m",
        reason="a length that the centres fix would not change", note="b_0 moved by 0.01 m",
        correction="the length is not known; the third law closes odd chains, too")  # fmt: skip


def deformations() -> Iterator[Statement]:
    """Yield equations (A3) to (A6): deformations of particles and compressions of contacts."""
    chains = touching_chains()
    shortened = [c.deformations for c in chains]
    yield Statement("eq-a3", "Appendix A, eq. (A3)", "dx_i = 2 (r_0 - (x_i - b_(i-1)))",
        np.concatenate([np.convolve(c.compressions, [1, 1]) for c in chains]),
        np.concatenate([2 * (RADIUS - (c.centres - c.boundaries[:-1])) for c in chains]),
        unit="m")  # fmt: skip
    recovered = [compressions_by_sweeps(c.centres, 2 * RADIUS) for c in chains]
    yield Statement("eq-a4", "Appendix A, eqs. (A4) and (A5)",
        "dx_i = c_(i-1,i) + c_(i,i+1), of the first and last one of them",
        np.concatenate(shortened), np.concatenate([np.convolve(c, [1, 1]) for c in recovered]),
        unit="m")  # fmt: skip
    yield Statement("eq-a6", "Appendix A, eq. (A6)",
        "dx_1 = dx_2 - (dx_3 - ... (dx_(n-1) - dx_n))", [d[0] for d in shortened],
        [(-1.0) ** np.arange(d.size - 1) @ d[1:] for d in shortened], unit="m")  # fmt: skip


def examples() -> Iterator[Statement]:
    """Yield the example of four particles, and the pattern that is made of it."""

    def balance(b: float, x: Floats) -> float:
        inner = RADIUS - x[1] + 2 * x[0] - 2 * b - RADIUS + x[2] - (2 * x[1] - 2 * x[0] + b)
        last = RADIUS - x[3] + 2 * x[2] - 2 * x[1] + 2 * x[0] - b
        return float(RADIUS - x[0] + b - (inner + last))

    chains = touching_chains(50, (4,))
    yield Statement("eq-four-inserted", "Appendix A, example of four particles, third line",
        "... = r_0 - x_2 + 2x_1 - 2b_0 - r_0 + x_3 - ...", [c.boundaries[0] for c in chains],
        [brentq(balance, -100.0, 100.0, args=(c.centres,)) for c in chains],
        [np.array([7.0, -5.0, 3.0, -1.0]) @ c.centres / 4 for c in chains], tolerance=1e-11,
        unit="m", reason="round-off",
        correction="- b_0 in place of - 2b_0; the last line is right")  # fmt: skip
    weights = []
    for n in range(2, 8):
        alternating = (-1.0) ** np.arange(n)
        equations = np.eye(n + 1) + np.eye(n + 1, k=1)  # b_(i-1) + b_i = 2 x_i
        equations[n] = np.append(alternating, 0.0) - np.append(0.0, alternating)
        # the last row: sum (-1)^i (2r_0 - (b_(i+1) - b_i)) = 0
        weights.append(-2 * float(alternating.sum()) * n * float(np.linalg.inv(equations)[0, n]))
    yield Statement("odd-coefficients", "Appendix A, before eq. (A7)",
        "the pattern of four particles, alternating odd coefficients, is the general solution",
        weights, np.zeros(6), ((-1.0) ** np.arange(2, 8) - 1) / 2, tolerance=1e-9, unit="r_0",
        reason="inverse of small matrices", note="weight of r_0 in n b_0, n = 2 to 7",
        correction="odd chains have - r_0, too")  # fmt: skip


# ---- contacts of a row


def contacts() -> Iterator[Statement]:
    """Yield equations (A8) to (A11): which particles of a row touch."""
    alone = touching_chains(50, (2,))
    yield Statement("eq-a8", "Appendix A, eq. (A8)",
        "c_(i,j) <= 2r_0 - dx_i, reached when i has no neighbour to its left",
        [p.compressions[0] for p in alone], [1.0 - p.deformations[0] for p in alone],
        [1.0 - p.distances[0] for p in alone], unit="m",
        note="two particles alone, where the bound is reached",
        correction="c_(i,j) <= 2r_0 - (x_j - x_i), as the proof uses it")  # fmt: skip
    sets = [_contact_sets(row) for row in rows()[:50]]
    yield Statement("many-groupings", "Appendix A, identifying chains",
        "particles can be grouped in many ways that satisfy axisymmetry and the third law",
        np.median(sets) > 1, reason="two sets of contacts or more for half of the rows",
        note=f"{min(sets)} to {max(sets)} sets of contacts")  # fmt: skip
    distance, deformation, beyond = _open_pairs()
    gaps = distance - (1.0 - deformation.sum(axis=1) / 2)
    yield Statement("eq-a9", "Appendix A, eq. (A9)",
        "not in contact: x_j - x_i > (2r_0 - dx_i)/2 + (2r_0 - dx_j)/2", gaps.min() > -1e-12,
        note=f"smallest gap {gaps.min():.1e} m of {gaps.size}")  # fmt: skip
    smaller = distance > 1.0 - deformation.min(axis=1)
    larger = distance >= 1.0 - deformation.max(axis=1) - 1e-12
    yield Statement("eq-a10", "Appendix A, eq. (A10)",
        "with dx_i the smaller of the two, x_j - x_i > 2r_0 - dx_i", smaller.all(),
        corrected=larger.all(), note=f"{smaller.sum()} of {smaller.size} pairs",
        correction="dx_i is the larger of the two")  # fmt: skip
    deformed = deformation.max(axis=1) > 0
    less, more = (
        (distance > beyond[np.arange(distance.size), side])[deformed]
        for side in (deformation.argmin(axis=1), deformation.argmax(axis=1))
    )
    yield Statement("eq-a11", "Appendix A, last display",
        "x_j - x_i > 2r_0 - (2r_0 - (x_i - x_h)) = x_i - x_h: the pair is not the closest",
        less.all(), corrected=more.all(), note=f"{less.sum()} of {less.size} pairs",
        correction="for the more deformed one, and only if it is pressed at all")  # fmt: skip


def _contact_sets(row: Particles) -> int:
    """Return how many sets of contacts of a row have repulsive forces that close their overlaps."""
    overlap = 1.0 - row.distances
    n, law = overlap.size, compliance(overlap.size, deformable=True)
    groups = [np.flatnonzero(code >> np.arange(n) & 1) for code in range(2**n)]
    forces = [np.linalg.solve(law[np.ix_(group, group)], overlap[group]) for group in groups]
    return sum(bool((force > 0).all()) for force in forces)


def _open_pairs() -> tuple[Floats, Floats, Floats]:
    """Return distances (P,) [m] of neighbours that do not touch, and both (P, 2) [m] deformations.

    The third part are the distances to the other neighbours (P, 2) [m], infinite at an end.
    """
    pairs_apart = []
    for row in rows():
        distances = np.concatenate(([np.inf], row.distances, [np.inf]))
        for i in np.flatnonzero(row.compressions == 0):
            pairs_apart.append(
                [distances[i + 1], *row.deformations[i : i + 2], *distances[i : i + 3 : 2]]
            )
    table = np.array(pairs_apart)
    return table[:, 0], table[:, 1:3], table[:, 3:]


# ---- corrections with a computation of their own


def errata() -> Iterator[Statement]:
    """Yield corrections on chains in series, joined boundaries and static towers."""
    yield Statement("series", "Errata, of the source", "n contacts in series have k/n",
        1 / (2 * row_energy(10)), 1 / 10, series_stiffness(10, 1.0, deformable=True), unit="k",
        note="ten contacts",
        correction="k/(2n - 1) for the source's own deformable particles")  # fmt: skip
    joined = np.linalg.solve(compliance(3, deformable=True), np.array([0.9, 0.6, 1.0]) / 10)
    yield Statement("joined-boundaries",
        "the source, Appendix A, read by what overlaps at the moment",
        "chains whose boundaries overlap at the moment belong together", (joined > 0).all(),
        note=f"overlaps of 0.9, 0.6 and 1 join to {joined.min():.3f}",
        correction="a contact is certain only if its neighbours cannot open it")  # fmt: skip
    n = np.arange(2, 20)
    forces = [static_forces(count, 1.0, 1.0) for count in n.tolist()]
    overlaps = [float((compliance(f.size, deformable=True) @ f)[-1]) for f in forces]
    yield Statement("preload", OURS, "static tower, deformable law: overlap i is 2 i m g/k",
        overlaps, 2.0 * n, (3 * n - 1) / 2, unit="m g/k",
        note="last overlap of 2 to 19 contacts",
        correction="(3n - 1)/2 m g/k at the base, which has no contact below")  # fmt: skip
