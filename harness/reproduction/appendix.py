"""Appendices of the source: boundaries of a chain (A1) to (A11), window of the impulse; errata."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from scipy.optimize import brentq

from harness.cases.tower.impulse import impulse, turnaround
from harness.cases.tower.parameters import LAWS, Tower
from harness.cases.tower.runs import solve
from harness.model.law import damping_ratio
from harness.reproduction import samples
from harness.reproduction.background import HALF_DIGIT
from harness.reproduction.samples import MEDIAN, RADIUS, Floats
from harness.reproduction.statements import Outcome, Statement, holds
from harness.solvers.chain import compressions_by_sweeps
from harness.theory.chain import compliance, series_stiffness, static_forces

FIRST_PACKET = 1.5  # [t0] end of the contacts with the neighbour, as printed
BOUNDARIES = "Appendix A, boundaries within a chain"
ENERGY_BOUND = "Appendix B, after Fig. 15"
PACKETS = "Appendix B, Fig. 14"
OURS = "Errata, of our restatement"


# ---- boundaries of touching chains


@Statement("Appendix A, eq. (A2)", "b_n = sum (2 x_i (-1)^(n+1) + b_0 (-1)^n)", 1e-11, "m",
           "round-off", correction="b_n = sum 2 (-1)^(n-i) x_i + (-1)^n b_0")  # fmt: skip
def _eq_a2() -> Outcome:
    printed, right, chains = [], [], samples.touching_chains()
    for chain in chains:
        n, x, first = chain.centres.size, chain.centres, chain.boundaries[0]
        printed.append(np.sum(2 * x * (-1) ** (n + 1) + first * (-1) ** n))
        right.append(2 * (-1.0) ** (n - np.arange(1, n + 1)) @ x + (-1) ** n * first)
    return Outcome([c.boundaries[-1] for c in chains], printed, right)


@Statement(BOUNDARIES, "b_3 - b_0 = 2x_3 - 2x_2 + 2x_1 - 2b_0 for three", unit="m")
def _eq_chain_length() -> Outcome:
    chains = samples.touching_chains(50, (3,))
    printed = [2 * (c.centres[2] - c.centres[1] + c.centres[0] - c.boundaries[0]) for c in chains]
    return Outcome([c.boundaries[3] - c.boundaries[0] for c in chains], printed)


@Statement(BOUNDARIES,
           "the centres give the length of a chain, and so all boundaries of odd ones", 1e-12, "m",
           "a length that the centres fix would not change",
           correction="the length is not known; the third law closes odd chains, too")  # fmt: skip
def _odd_chains() -> Outcome:
    def length(centres: Floats, first: float) -> float:
        edge = first
        for centre in centres.tolist():
            edge = 2 * centre - edge
        return edge - first

    chains = [samples.touching_chains(1, (n,))[0] for n in (3, 5, 7)]
    changes = [
        length(c.centres, c.boundaries[0] + 0.01) - length(c.centres, c.boundaries[0])
        for c in chains
    ]
    return Outcome(changes, np.zeros(3), note="b_0 moved by 0.01 m")


@Statement("Appendix A, eq. (A3)", "dx_i = 2 (r_0 - (x_i - b_(i-1)))", unit="m")
def _eq_a3() -> Outcome:
    printed = [2 * (RADIUS - (c.centres - c.boundaries[:-1])) for c in samples.touching_chains()]
    values = [np.convolve(c.compressions, [1, 1]) for c in samples.touching_chains()]
    return Outcome(np.concatenate(values), np.concatenate(printed))


@Statement("Appendix A, eqs. (A4) and (A5)",
           "dx_i = c_(i-1,i) + c_(i,i+1), of the first and last one of them", unit="m")  # fmt: skip
def _eq_a4() -> Outcome:
    recovered = [compressions_by_sweeps(c.centres, 2 * RADIUS) for c in samples.touching_chains()]
    printed = np.concatenate([np.convolve(c, [1, 1]) for c in recovered])
    return Outcome(np.concatenate([c.deformations for c in samples.touching_chains()]), printed)


@Statement("Appendix A, eq. (A6)", "dx_1 = dx_2 - (dx_3 - ... (dx_(n-1) - dx_n))", unit="m")
def _eq_a6() -> Outcome:
    deformations = [c.deformations for c in samples.touching_chains()]
    printed = [(-1.0) ** np.arange(d.size - 1) @ d[1:] for d in deformations]
    return Outcome([d[0] for d in deformations], printed)


@Statement("Appendix A, example of four particles, third line",
           "... = r_0 - x_2 + 2x_1 - 2b_0 - r_0 + x_3 - ...", 1e-11, "m", "round-off",
           correction="- b_0 in place of - 2b_0; the last line is right")  # fmt: skip
def _eq_four_inserted() -> Outcome:
    def balance(b: float, x: Floats) -> float:
        inner = RADIUS - x[1] + 2 * x[0] - 2 * b - RADIUS + x[2] - (2 * x[1] - 2 * x[0] + b)
        last = RADIUS - x[3] + 2 * x[2] - 2 * x[1] + 2 * x[0] - b
        return float(RADIUS - x[0] + b - (inner + last))

    chains = samples.touching_chains(50, (4,))
    printed = [brentq(balance, -100.0, 100.0, args=(c.centres,)) for c in chains]
    last_line = [np.array([7.0, -5.0, 3.0, -1.0]) @ c.centres / 4 for c in chains]
    return Outcome([c.boundaries[0] for c in chains], printed, last_line)


@Statement("Appendix A, before eq. (A7)",
           "the pattern of four particles, alternating odd coefficients, is the general solution",
           1e-9, "r_0", "inverse of small matrices",
           correction="odd chains have - r_0, too")  # fmt: skip
def _odd_coefficients() -> Outcome:
    weights = []
    for n in range(2, 8):
        alternating = (-1.0) ** np.arange(n)
        balance = np.eye(n + 1) + np.eye(n + 1, k=1)  # b_(i-1) + b_i = 2 x_i
        balance[n] = np.append(alternating, 0.0) - np.append(0.0, alternating)
        # the last row: sum (-1)^i (2r_0 - (b_(i+1) - b_i)) = 0
        weights.append(-2 * float(alternating.sum()) * n * float(np.linalg.inv(balance)[0, n]))
    right = ((-1.0) ** np.arange(2, 8) - 1) / 2
    return Outcome(weights, np.zeros(6), right, "weight of r_0 in n b_0, n = 2 to 7")


# ---- contacts of a row


@Statement("Appendix A, eq. (A8)",
           "c_(i,j) <= 2r_0 - dx_i, reached when i has no neighbour to its left", unit="m",
           correction="c_(i,j) <= 2r_0 - (x_j - x_i), as the proof uses it")  # fmt: skip
def _eq_a8() -> Outcome:
    pairs = samples.touching_chains(50, (2,))
    printed, right = [1.0 - p.deformations[0] for p in pairs], [1.0 - p.distances[0] for p in pairs]
    note = "two particles alone, where the bound is reached"
    return Outcome([p.compressions[0] for p in pairs], printed, right, note)


@Statement("Appendix A, identifying chains",
           "particles can be grouped in many ways that satisfy axisymmetry and the third law",
           reason="two sets of contacts or more for half of the rows")  # fmt: skip
def _many_groupings() -> Outcome:
    counts = []
    for row in samples.rows()[:50]:
        overlap = 1.0 - row.distances
        n, law = overlap.size, compliance(overlap.size, deformable=True)
        groups = [np.flatnonzero(code >> np.arange(n) & 1) for code in range(2**n)]
        forces = [np.linalg.solve(law[np.ix_(group, group)], overlap[group]) for group in groups]
        counts.append(sum(bool((force > 0).all()) for force in forces))
    return holds(np.median(counts) > 1, f"{min(counts)} to {max(counts)} sets of contacts")


@Statement("Appendix A, eq. (A9)",
           "not in contact: x_j - x_i > (2r_0 - dx_i)/2 + (2r_0 - dx_j)/2")  # fmt: skip
def _eq_a9() -> Outcome:
    pairs = samples.open_pairs()
    gaps = pairs.distance - (1.0 - pairs.deformations.sum(axis=1) / 2)
    return holds(gaps.min() > -1e-12, f"smallest gap {gaps.min():.1e} m of {gaps.size}")


@Statement("Appendix A, eq. (A10)", "with dx_i the smaller of the two, x_j - x_i > 2r_0 - dx_i",
           correction="dx_i is the larger of the two")  # fmt: skip
def _eq_a10() -> Outcome:
    pairs = samples.open_pairs()
    smaller = pairs.distance > 1.0 - pairs.deformations.min(axis=1)
    larger = pairs.distance >= 1.0 - pairs.deformations.max(axis=1) - 1e-12
    note = f"{smaller.sum()} of {smaller.size} pairs"
    return holds(smaller.all(), note, corrected=larger.all())


@Statement("Appendix A, last display",
           "x_j - x_i > 2r_0 - (2r_0 - (x_i - x_h)) = x_i - x_h: the pair is not the closest",
           correction="for the more deformed one, and only if it is pressed at all")  # fmt: skip
def _eq_a11() -> Outcome:
    distance, deformations, beyond = samples.open_pairs()
    deformed = deformations.max(axis=1) > 0
    less, more = (
        (distance > beyond[np.arange(distance.size), side])[deformed]
        for side in (deformations.argmin(axis=1), deformations.argmax(axis=1))
    )
    return holds(less.all(), f"{less.sum()} of {less.size} pairs", corrected=more.all())


# ---- the window of the impulse


def intervals(height: int) -> list[tuple[float, float]]:
    """Return from when to when the grain of a tower touches anything, within 6 t0."""
    return samples.contact_intervals(Tower(height=height), 6.0)


def last_of_packet(height: int) -> float:
    """Return when the last contact ends that began before 1.5 t0 [t0]."""
    return max(end for begin, end in intervals(height) if begin < FIRST_PACKET)


@Statement(PACKETS, "beyond ten particles contacts with neighbour and chain are well separated",
           reason="more than a contact time between them")  # fmt: skip
def _separated() -> Outcome:
    late = {n: [a for a, _ in intervals(n) if a >= FIRST_PACKET] for n in (10, 19)}
    separate = all(not starts or starts[0] > last_of_packet(n) + 1 for n, starts in late.items())
    return holds(separate, f"{sum(map(len, late.values()))} contacts begin after 1.5 t0, of 6 t0")


@Statement(PACKETS,
           "with twenty particles what happens up to 1.5 t0 is the limit for long chains", 0.01,
           "t0", "equal to a hundredth of t0, ten and twenty particles")  # fmt: skip
def _first_packet() -> Outcome:
    return Outcome(last_of_packet(19), last_of_packet(9), note="end of the grain's last contact")


@Statement(PACKETS,
           "one contact of the grain with two particles, two with three, three with four", 0.0,
           "contacts", "a count")  # fmt: skip
def _humps() -> Outcome:
    return Outcome([len(intervals(n)) for n in (1, 2, 3)], [1, 2, 3])


@Statement("Appendix B, before Fig. 15",
           "after t_0 the structure swings from the whole chain to one, two to seven particles",
           correction="for two to five particles")  # fmt: skip
def _structure_window() -> Outcome:
    tables = {law: samples.structure_angles(law, 8) for law in LAWS}
    heights = {law: tuple(t["height"][t["window_s"].notna()]) for law, t in tables.items()}
    note = f"n = {heights['deformable']} (deformable law), {heights['overlap']} (overlap law)"
    every = set(range(1, 7)) <= set(heights["deformable"])
    return holds(every, note, corrected=heights["deformable"] == (1, 2, 3, 4))


@Statement(ENERGY_BOUND,
           "the largest compression of the initial collision falls within 3 t_0",
           correction="not where weight matters, at the lowest stiffness and speed")  # fmt: skip
def _within_bound() -> Outcome:
    columns = samples.impulses()[["stiffness_N_per_m", "speed_m_per_s", "window_s"]]
    late = [
        end for k, speed, end in columns.itertuples(index=False)
        if end / 2 >= 3.0 * (1 - 1e-9) * Tower(stiffness=k, speed=speed).contact_time
    ]  # fmt: skip
    return holds(not late, f"not in {len(late)} of {len(columns)} towers")


def compressed_most(height: int) -> float:
    """Return when the whole chain of a tower is compressed most [t0]."""
    tower = samples.run(Tower(height=height))
    return turnaround(tower) / tower.tower.contact_time


@Statement(ENERGY_BOUND,
           "the time of the largest compression is half of collision and rebound", 0.1, "t0",
           "to a tenth of t0", correction="for two particles only")  # fmt: skip
def _half_period() -> Outcome:
    twice = {n: 2 * compressed_most(n) for n in (1, 2, 3, 19)}
    leaves = [max(end for begin, end in intervals(n) if begin < twice[n]) for n in twice]
    return Outcome(leaves, list(twice.values()), note="1, 2, 3 and 19 contacts")


@Statement(ENERGY_BOUND, "the window fails to capture the three-particle scenario",
           reason="three far above tall towers, five within a hundredth of them")  # fmt: skip
def _three_fails() -> Outcome:
    alpha = samples.ratios()[MEDIAN]
    values = ", ".join(f"{alpha[n]:.3f}" for n in (2, 3, 4, 19))
    fails = alpha[2] - alpha[19] > 0.3 and alpha[4] - alpha[19] < 0.01
    return holds(fails, f"alpha = {values} with three, four, five and twenty: four fail as well")


@Statement("Appendix B, text and caption of Fig. 16",
           "grain (caption) and chain (text) are compressed most at the same time", 0.05, "t0",
           "to a twentieth of t0", correction="the same for two particles only")  # fmt: skip
def _maximum_of_what() -> Outcome:
    towers = [samples.run(Tower(height=n)) for n in (1, 2, 3)]
    grain = [t.time_over_t0[int(np.argmax(t.deformations[:, 0]))] for t in towers]
    return Outcome([compressed_most(n) for n in (1, 2, 3)], grain, note="1, 2 and 3 contacts")


# ---- corrections with a computation of their own


@Statement("Errata, of the source", "n contacts in series have k/n", unit="k",
           correction="k/(2n - 1) for the source's own deformable particles")  # fmt: skip
def _series() -> Outcome:
    right = series_stiffness(10, 1.0, deformable=True)
    return Outcome(1 / (2 * samples.row_energy(10)), 1 / 10, right, "ten contacts")


@Statement(OURS, "a clipped contact rebounds with 0.1367 at nominal restitution 0", 5e-5,
           reason=HALF_DIGIT, correction="exp(-2) = 0.1353")  # fmt: skip
def _clipped_restitution() -> Outcome:
    _, restitution = samples.damped_contact(1.0, 1.0, 2 * damping_ratio(0.0), clipped=True)
    return Outcome(restitution, 0.1367, math.exp(-2))


@Statement("the source, Appendix A, read by what overlaps at the moment",
           "chains whose boundaries overlap at the moment belong together",
           correction="a contact is certain only if its neighbours cannot open it")  # fmt: skip
def _joined_boundaries() -> Outcome:
    joined = np.linalg.solve(compliance(3, deformable=True), np.array([0.9, 0.6, 1.0]) / 10)
    return holds((joined > 0).all(), f"overlaps of 0.9, 0.6 and 1 join to {joined.min():.3f}")


@Statement(OURS, "static tower, deformable law: overlap i is 2 i m g/k", unit="m g/k",
           correction="(3n - 1)/2 m g/k at the base, which has no contact below")  # fmt: skip
def _preload() -> Outcome:
    n = np.arange(2, 20)
    forces = [static_forces(count, 1.0, 1.0) for count in n.tolist()]
    overlaps = [float((compliance(f.size, deformable=True) @ f)[-1]) for f in forces]
    return Outcome(overlaps, 2.0 * n, (3 * n - 1) / 2, "last overlap of 2 to 19 contacts")


@Statement(OURS, "alpha is 0.53 to 0.54 for towers above n = 2, all six runs", 0.01,
           reason="0.53 and 0.54 to half of their last digit",
           correction="from n = 4 on, and not at 1e5 N/m and 2 m/s")  # fmt: skip
def _tall_alpha() -> Outcome:
    every = [(case, n, a) for case, alpha in samples.ratios().items() for n, a in alpha.items()]
    values = [a for _, n, a in every if n > 2]
    rest = [a for case, n, a in every if n > 3 and case != (1e5, 2.0)]
    return Outcome(values, 0.535, 0.535, value_corrected=rest)


def symplectic_euler_error(steps: int, shifted: bool) -> float:
    """Return the error of the displacement [v0/omega] after 0.7 of half a period.

    Velocity first, then position, for a grain with weight on a spring (omega = v0 = 1, g = 0.3),
    as the power of a matrix. ``shifted`` takes the first velocity as that of half a step before.
    """
    weight, end = 0.3, 0.7 * math.pi
    h = end / steps
    advance = np.array([[1 - h * h, h, h * h * weight], [-h, 1.0, h * weight], [0.0, 0.0, 1.0]])
    start = np.array([0.0, 1.0 - (0.5 * h * weight if shifted else 0.0), 1.0])
    exact = weight * (1 - math.cos(end)) + math.sin(end)
    return abs(float((np.linalg.matrix_power(advance, steps) @ start)[0]) - exact)


@Statement(OURS, "MFiX's Euler scheme is of first order", 0.1, reason="a tenth of an order",
           correction="second order but for the first half step of gravity")  # fmt: skip
def _mfix_order() -> Outcome:
    steps = [50, 100, 200, 400, 800]

    def order(shifted: bool) -> float:
        errors = [symplectic_euler_error(n, shifted) for n in steps]
        return -float(np.polyfit(np.log(steps), np.log(errors), 1)[0])

    note = "leapfrog, started half a step late"
    return Outcome([order(False), order(True)], [1.0, 1.0], [1.0, 2.0], note)


@cache
def impulse_ratio_at(gamma: float, height: int, stiffness: float) -> float:
    """Return alpha(n), turnaround window, at m g/(v0 sqrt(k m)) = gamma."""
    speed = 9.81 / (gamma * math.sqrt(stiffness))
    towers = (Tower(height=n, stiffness=stiffness, speed=speed) for n in (height, 1))
    tall, single = (impulse(solve(t, "exact", duration=4.0, samples=1000)) for t in towers)
    return tall / single


@Statement(OURS, "alpha(n) depends on m g/(v0 sqrt(k m)) alone", 1e-6,
           reason="three stiffnesses, 1e4 to 1e8 N/m; a window's end to 1e-8")  # fmt: skip
def _one_parameter() -> Outcome:
    same = [impulse_ratio_at(0.009, 6, k) for k in (1e4, 1e6, 1e8)]
    return Outcome(same, np.full(3, same[1]), note="six contacts at 0.009")
