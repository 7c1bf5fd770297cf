"""Results, discussion and conclusion of the source: impulses, angles over height, equation (18)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from itertools import pairwise

import numpy as np

from harness.cases.tower.impulse import QUASI_STATIC, STIFFNESSES, angle_from_impulse_ratio, impulse
from harness.cases.tower.parameters import LAWS, Tower
from harness.reproduction import samples
from harness.reproduction.background import HALF_DIGIT
from harness.reproduction.samples import MEDIAN, Floats
from harness.reproduction.statements import Outcome, Statement, holds
from harness.theory.chain import contact_time_on_fixed

FLAT = 0.01  # of alpha: a change that a figure shows
TALLEST, LONGEST = 19, 10  # contacts of the tallest tower, and of the longest chain as printed
N = np.arange(1, 11)
THREE = "Results, three particles of Fig. 8"
AFTER_RATIO = "Results, after Fig. 10"
ENERGIES = "Discussion, after the displays"
READ_OFF = "a time read off a plot, in halves of t0"


# ---- runs of Figs. 8 and 9


@Statement("Results, Fig. 8", "t_0 is the contact of two particles", 1e-9, "s",
           "the exact propagator locates the end of a contact to round-off")  # fmt: skip
def _unit_of_time() -> Outcome:
    single = Tower(height=1)
    end = samples.contact_intervals(single)[0][1] * single.contact_time
    return Outcome(end, contact_time_on_fixed(1.0, 1e6, 2.0, 9.81), note="grain on a fixed one")


@Statement("Results, Fig. 9",
           "t/t_0 collapses runs whose stiffnesses are an order of magnitude apart",
           reason="a tenth of the two-particle peak, all along 3 t0")  # fmt: skip
def _collapse() -> Outcome:
    def curve(height: int, stiffness: float) -> Floats:
        tall, single = (samples.run(Tower(height=n, stiffness=stiffness)) for n in (height, 1))
        force = np.interp(np.linspace(0.0, 3.0, 601), tall.time_over_t0, tall.grain_force)
        return np.asarray(force / single.grain_force.max())

    neighbours = [(n, *pair) for n in (2, 9) for pair in pairwise(STIFFNESSES)]
    largest = max(float(np.abs(curve(n, b) - curve(n, a)).max()) for n, a, b in neighbours)
    return holds(largest < 0.1, f"forces of neighbours differ by {largest:.3f} of the peak")


@Statement(THREE, "the third particle joins at about 0.5 t0", 0.1, "t0", READ_OFF)
def _joins() -> Outcome:
    three = samples.run(Tower(height=2))
    return Outcome(float(three.time_over_t0[np.argmax(three.contacts == 2)]), 0.5)


@Statement(THREE, "the contact of the grain returns at 1 t0 and ends at about 1.5 t0", 0.1, "t0",
           READ_OFF)  # fmt: skip
def _returns() -> Outcome:
    return Outcome(samples.contact_intervals(Tower(height=2))[1], [1.0, 1.5])


@Statement("Results, after Fig. 8",
           "changes of the force curve fall on changes of the contact structure",
           reason="jumps of a tenth of the largest slope or more")  # fmt: skip
def _aligned() -> Outcome:
    three = samples.run(Tower(height=2))
    once = np.diff(three.time, prepend=-1.0) > 0  # a change of contacts is sampled twice
    force, contacts = three.grain_force[once], three.contacts[once]
    rate = np.gradient(force, three.time[once])
    changes = np.flatnonzero(np.diff(contacts) != 0)
    inside = changes[(changes > 3) & (changes < force.size - 5)]
    jumps = np.abs(rate[inside + 4] - rate[inside - 3]) / np.abs(rate).max()
    return holds(jumps.size and jumps.min() > 0.1, f"{jumps.size} changes, {jumps.min():.2f} least")


# ---- impulses over height


@Statement("Results, before Fig. 10",
           "the two-particle impulse stands for direct neighbours only",
           reason="between a rebound, 2 m v0, and a twentieth more")  # fmt: skip
def _null() -> Outcome:
    first = [
        impulse(samples.run(Tower(height=1, stiffness=k, speed=v))) / v for k, v in samples.ratios()
    ]
    return holds(min(first) >= 2.0 and max(first) < 2.1, f"J(1) up to {max(first):.4f} m v0")


def falls(alpha: Mapping[int, float]) -> bool:
    """Return whether alpha never rises with height by more than a hundredth."""
    return all(alpha[after] <= alpha[before] + FLAT for before, after in pairwise(sorted(alpha)))


@Statement("Results, Fig. 10", "impulses decrease with the length of the chain, in all six runs",
           reason="never up by more than a hundredth from one height to the next",
           correction="not at the lowest stiffness and speed, where it sinks on")  # fmt: skip
def _impulses_decrease() -> Outcome:
    falling = {case: falls(alpha) for case, alpha in samples.ratios().items()}
    rest = all(falls for case, falls in falling.items() if case != (1e5, 2.0))
    return holds(all(falling.values()), f"in {sum(falling.values())} of 6 runs", corrected=rest)


@cache
def longest_chains(height: int) -> tuple[int, int]:
    """Return the longest chain of the grain, and the longest anywhere, within 3 t0."""
    tower = samples.run(Tower(height=height, stiffness=MEDIAN[0], speed=MEDIAN[1]))
    longest, length = 0, np.zeros(tower.time.size, int)
    for touching in (tower.forces > 0).T:
        length = np.where(touching, length + 1, 0)
        longest = max(longest, int(length.max()))
    return int(tower.contacts.max()), longest


@Statement(AFTER_RATIO, "the length of chains levels off at about ten contacts", 1.0, "contacts",
           "about ten: to one contact",
           correction="the chain of the grain levels off at four contacts")  # fmt: skip
def _plateau() -> Outcome:
    (level, _), (grain, anywhere) = longest_chains(TALLEST), longest_chains(30)
    note = f"grain {level} at n = 19 and {grain} at 30; anywhere {anywhere} within 3 t0"
    return Outcome(float(level), float(LONGEST), note=note)


@Statement(AFTER_RATIO, "beyond ten contacts height has little to no effect on alpha", FLAT,
           reason="a hundredth of alpha")  # fmt: skip
def _little_effect() -> Outcome:
    tall = [[a for n, a in alpha.items() if n >= LONGEST] for alpha in samples.ratios().values()]
    return Outcome(max(max(alpha) - min(alpha) for alpha in tall), 0.0, note="largest variation")


@Statement("Results, Fig. 11",
           "the critical angle falls with height, as in thin layer stability",
           reason="by more than a degree, never up by more than a hundredth in alpha")  # fmt: skip
def _angle_falls() -> Outcome:
    alpha = samples.ratios()[MEDIAN]
    lost, kept = ([angle_from_impulse_ratio(alpha[n], r) for n in (1, TALLEST)]
                  for r in ("lost", "kept"))  # fmt: skip
    note = f"{lost[0]:.2f} to {lost[1]:.2f} deg (velocity lost), {kept[1]:.2f} deg (kept)"
    return holds(lost[1] < lost[0] - 1 and falls(alpha), note)


@Statement("Results, Fig. 11", "tall towers reach the published angle of frictionless spheres",
           QUASI_STATIC[1], "deg",
           "its uncertainty (Peyneau and Roux, Phys. Rev. E 78, 011307 (2008))")  # fmt: skip
def _tall_limit() -> Outcome:
    return Outcome(angle_from_impulse_ratio(samples.ratios()[MEDIAN][TALLEST]), QUASI_STATIC[0])


# ---- energy of springs and particles in series


def spring_energy(springs: int, stiffness: float, force: float) -> float:
    """Return the energy of equal springs in series under a force [J], from their equilibrium."""
    return 0.5 * force**2 / (stiffness * samples.springs_in_series(springs))


@Statement("Discussion, third display", "U_2 = 1/2 (1/2 k)(2 c_1)^2 = 1/4 4 c_1^2 = 2 U_1", 1e-11,
           "J", "round-off",
           correction="1/4 k 4 c_1^2 = k c_1^2: the step before has lost k")  # fmt: skip
def _eq_u_2() -> Outcome:
    k, c = samples.generator().uniform([10.0, 0.01], [1000.0, 0.5], (50, 2)).T
    energies = [spring_energy(2, a, a * b) for a, b in zip(k, c, strict=True)]
    return Outcome(energies, c**2, k * c**2)


@Statement(ENERGIES, "U_n = n U_1", unit="U_1")
def _u_n() -> Outcome:
    energies = [spring_energy(n, 1.0, 1.0) / spring_energy(1, 1.0, 1.0) for n in N.tolist()]
    return Outcome(energies, N, note="springs in series under one force")


@Statement(ENERGIES, "U_n = n U_1 holds for the source's own deformable particles", unit="U_1",
           correction="U_n = (2n - 1) U_1: inner ones are pressed from both sides")  # fmt: skip
def _u_n_particles() -> Outcome:
    return Outcome(
        [samples.row_energy(n) / samples.row_energy(1) for n in N.tolist()], N, 2 * N - 1
    )


@Statement("Discussion, eq. (18)", "1/2 m v^2 = U_n = n U_1 = n (1/2 k c_n)", 1e-11, "J",
           "round-off", correction="n (1/2 k c_1^2): squared, and of one spring")  # fmt: skip
def _eq_18() -> Outcome:
    k, first = 100.0, 0.2
    energies = [spring_energy(n, k, k * first) for n in N.tolist()]
    return Outcome(energies, N * 0.5 * k * (N * first), N * 0.5 * k * first**2)


@Statement("Discussion, eq. (18)", "v ~ sqrt(n)", 1e-9, reason="slope of an exact power")
def _sqrt_n() -> Outcome:
    springs, particles = (
        float(np.polyfit(np.log(N), 0.5 * np.log(energies), 1)[0])
        for energies in ([spring_energy(n, 1.0, 1.0) for n in N.tolist()],
                         [samples.row_energy(n) for n in N.tolist()])
    )  # fmt: skip
    return Outcome(springs, 0.5, note=f"{particles:.2f} for the source's own particles")


def scaled_angle(height: int) -> float:
    """Return the critical angle [deg] of alpha = 1/sqrt(n)."""
    return angle_from_impulse_ratio(1.0 / math.sqrt(height))


@Statement("Discussion, Fig. 13",
           "velocity lost as 1/sqrt(n) makes the angle fall, without an asymptote",
           reason="still falling by half a degree from ten to twenty")  # fmt: skip
def _energy_scaling() -> Outcome:
    angles = [scaled_angle(n) for n in (1, 2, 10, 20)]
    falling = angles[0] > angles[1] > angles[2] > angles[3] + 0.5
    return holds(falling, f"{angles[0]:.2f}, {angles[2]:.2f}, {angles[3]:.2f} deg at 1, 10, 20")


@Statement("Discussion, Fig. 13",
           "the energy argument gives the behaviour of the impulses, up to ten", 0.5, "deg",
           "the fall from n = 2 to 10 is of several degrees")  # fmt: skip
def _energy_agrees() -> Outcome:
    return Outcome(
        angle_from_impulse_ratio(samples.ratios()[MEDIAN][LONGEST]), scaled_angle(LONGEST)
    )


@Statement("Discussion, after eq. (18)", "no chain over ten particles forms, even for twenty")
def _longest_chain() -> Outcome:
    longest = max(longest_chains(TALLEST))
    overlap = int(samples.run(Tower(height=TALLEST, law="overlap")).contacts.max())
    return holds(longest <= LONGEST, f"{longest} contacts; overlap law {overlap}")


@Statement("Conclusion",
           "forces over an order of magnitude change deformations by less than 1e-6 % at 1e6",
           1e-6, "%", "the bound itself",
           correction="less than 9e-4 % of the diameter")  # fmt: skip
def _differences() -> Outcome:
    # dx/d is P d/k under a force of P d^2
    return Outcome(100 * (1 / 1e6) * (10 - 1), 0.0, note="from the confining force to ten times it")


@Statement("Conclusion", "chains can nearly halve the impulse", 0.05, reason=HALF_DIGIT)
def _halved() -> Outcome:
    least = {law: min(min(a.values()) for a in samples.ratios(law).values()) for law in LAWS}
    return Outcome(least["deformable"], 0.5, note=f"overlap law {least['overlap']:.4f}")
