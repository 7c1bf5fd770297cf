"""Methods of the source, equations (10) to (17): scales of time, pairs of particles, chains."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.optimize import brentq

from harness.cases.tower.impulse import STIFFNESSES
from harness.cases.tower.parameters import Tower
from harness.cases.tower.runs import solve
from harness.reproduction import samples
from harness.reproduction.background import HALF_DIGIT
from harness.reproduction.samples import RADIUS, Particles
from harness.reproduction.statements import Outcome, Statement, holds
from harness.solvers.chain import contact_forces, first_boundary
from harness.theory import chain
from harness.theory.incline import critical_angle, no_flight_bound, steady_energy

GRAVITY, CONTACT_TIME, CREST_TIME = 9.81, 0.007, 0.41  # [m/s2], [s], [s] as printed
GLASS_MODULUS, GLASS_DENSITY, PACKING, DEPTH = 70e9, 2500.0, 0.6, 0.5  # [Pa], [kg/m3], [1], [m]
STEP = 1e-4  # [s] of the runs with a fixed step
ERROR_STIFFNESSES = (1e2, 1e3, 1e4, 1e5, 1e6)  # [N/m]
RIGIDITY = "Methods, after eq. (10)"
PAIR = "Methods, after eq. (15)"
THREE = "Methods, before eq. (16)"
END = "Methods, before Results"
DIFFERENCES = "central difference of energies of 1e4 J over 1e-7 m"
Floats = NDArray[np.float64]


# ---- rigidity and times


@Statement("Methods, eq. (10)", "kappa = k/P is a number without dimension",
           correction="kappa = k/(P d); as printed for disks, whose P is per length")  # fmt: skip
def _eq_10() -> Outcome:
    metres, centimetres = (1e5, 9.81, 1.0), (1e5 / 100, 9.81 / 100**2, 100.0)  # k, P, d
    printed = [k / pressure for k, pressure, _ in (metres, centimetres)]
    right = [k / (pressure * d) for k, pressure, d in (metres, centimetres)]
    note = f"k/P is {printed[0]:.5g} in metres and {printed[1]:.5g} in centimetres: a length"
    same = (math.isclose(*printed, rel_tol=1e-12), math.isclose(*right, rel_tol=1e-12))
    return holds(same[0], note, corrected=same[1])


@Statement(RIGIDITY, "a glass bead under 50 cm of beads has a rigidity of 40,000", 5000.0,
           reason=HALF_DIGIT)  # fmt: skip
def _glass_bead() -> Outcome:
    pressure = GLASS_DENSITY * PACKING * GRAVITY * DEPTH
    return Outcome((GLASS_MODULUS / pressure) ** (2 / 3), 40_000.0, note="Hertz, (E/P)^(2/3)")


@Statement(f"{RIGIDITY}; Results, before Fig. 10",
           "rigidities of 1e4 to 1e6 span three orders of magnitude", 0.5, reason=HALF_DIGIT,
           correction="three values, two orders of magnitude")  # fmt: skip
def _orders_of_magnitude() -> Outcome:
    return Outcome(math.log10(1e6 / 1e4), 3.0, float(len(STIFFNESSES) - 1))


@Statement(RIGIDITY, "rigidities 1e4 and 1e6 are stiffnesses of 1e5 and 1e7 N/m at 9.81 m/s2", 0.5,
           reason="half of the last digit, of each rigidity")  # fmt: skip
def _stiffness() -> Outcome:
    weight = 1.0 * GRAVITY / 1.0  # [N/m] pressure of a row of disks, 1 kg and 1 m
    return Outcome([1e5 / weight / 1e4, 1e7 / weight / 1e6], [1.0, 1.0], note="over the printed")


@Statement("Methods, eq. (11)", "t_c = 1/4 sqrt(2g 2r (1 - sin 60)) cos 60/g", unit="s")
def _eq_11() -> Outcome:
    drop = 1 - math.sqrt(3) / 2  # [d] from crest to well of a level row, Pythagoras
    time = math.sqrt(2 * GRAVITY * drop * 2.0) / 8 / GRAVITY
    return Outcome(time, crest_time(1.0), note="an eighth of the speed of escape over g, r = 1 m")


def crest_time(radius: float) -> float:
    """Return t_c [s] by eq. (11) as printed, for spheres of a radius [m]."""
    rise = 1 - math.sin(math.pi / 3)
    return 0.25 * math.sqrt(2 * GRAVITY * 2 * radius * rise) * math.cos(math.pi / 3) / GRAVITY


@Statement("Methods, eq. (11)", "the formula gives t_c = 0.41 s", 0.005, "s", HALF_DIGIT,
           correction="t_c = 0.029 s by the formula")  # fmt: skip
def _t_c() -> Outcome:
    needed = float(brentq(lambda r: crest_time(r) - CREST_TIME, 1e-3, 1e6))
    return Outcome(crest_time(1.0), CREST_TIME, note=f"0.41 s needs a radius of {needed:.0f} m")


@cache
def rise_time(angle_deg: float) -> float:
    """Return the time [s] from well to crest in steady motion, spheres of 1 m, by quadrature."""
    rise, energy = math.radians(30 - angle_deg), steady_energy(angle_deg, 0.25)

    def slowness(angle: float) -> float:
        return 1 / math.sqrt(2 * (energy - math.cos(angle) + math.cos(rise)))

    return float(quad(slowness, 0.0, rise)[0]) * math.sqrt(1.0 / GRAVITY)


@Statement("Methods, before eq. (11)", "the grain takes about 0.41 s from well to crest",
           reason="between the shortest and the longest rise in steady motion")  # fmt: skip
def _crest_time() -> Outcome:
    fastest, slow = rise_time(no_flight_bound()), rise_time(critical_angle() + 1e-6)
    note = f"{fastest:.3f} s at the flight bound and {slow:.2f} s just above theta_c"
    return holds(fastest <= CREST_TIME <= slow, f"steady motion takes {note}")


@Statement("Methods, eq. (12)", "t_n = pi (k/m_eff - (gamma/m_eff)^2)^(-1/2)", 1e-8, "s",
           "integration with a relative tolerance of 1e-11",
           correction="(gamma/(2 m_eff))^2; without damping, as here, nothing changes")  # fmt: skip
def _eq_12() -> Outcome:
    k, m, gamma = samples.generator().uniform([50, 0.3, 0.5], [200, 1.0, 5.0], (50, 3)).T
    times = [samples.damped_contact(*case)[0] for case in zip(k, m, gamma, strict=True)]
    printed = np.pi / np.sqrt(k / m - (gamma / m) ** 2)
    return Outcome(times, printed, np.pi / np.sqrt(k / m - (gamma / (2 * m)) ** 2))


@Statement("Methods, eq. (12)", "t_n = 0.007 s at 100,000 N/m", 5e-4, "s", HALF_DIGIT)
def _t_n() -> Outcome:
    fixed = Tower(stiffness=1e5, gravity=0.0).contact_time
    note = f"two free particles; {fixed:.5f} s on a fixed one"
    return Outcome(math.pi / math.sqrt(2 * 1e5), CONTACT_TIME, note=note)


@Statement("Methods, after eq. (12)", "contacts are over long before the grain is on the crest",
           reason="ten contacts or more to a rise")  # fmt: skip
def _separation() -> Outcome:
    fastest, longest = rise_time(no_flight_bound()), samples.impulses()["window_s"].max()
    note = f"{fastest / CONTACT_TIME:.0f} contacts, {fastest / longest:.1f} of the longest window"
    return holds(fastest > 10 * CONTACT_TIME, note)


# ---- the rescaled impulse

ALPHA = np.linspace(0.3, 1.0, 15)


@Statement("Methods, eq. (13); Results, before Fig. 10",
           "J_0, the impulse of the ideal shock, is that of the two-particle run", unit="m v",
           correction="alpha(n) = J(n)/J(1), a ratio of two elastic runs")  # fmt: skip
def _eq_13_reference() -> Outcome:
    elastic = chain.impulse_on_fixed(1.0, 1e6, 1.0, 0.0)
    return Outcome(1.0, elastic, note="the ideal shock has e_n = 0, the two-particle run rebounds")


@Statement("Methods, eq. (13)",
           "v_i(n) = v_i alpha(n), hence shock(n) = |(v_0 - v_s alpha(n))/v_0|^2",
           correction="alpha scales the loss: v_i(n) = v_0 - alpha (v_0 - v_i)")  # fmt: skip
def _eq_13() -> Outcome:
    angles = [critical_angle(shock) for shock in ((1 - 0.27) ** 2, 0.27**2)]
    note = f"at alpha = 0.54 theta_c = {angles[0]:.2f} deg (third line), {angles[1]:.2f} (second)"
    return Outcome((0.5 * ALPHA) ** 2, (1 - 0.5 * ALPHA) ** 2, note=note)


@Statement("Methods, eq. (13)",
           "a contact that gives alpha of the impulse leaves |1 - alpha/2|^2 of the energy",
           correction="1/4 + 3/4 (1 - alpha)^2: the impulse acts along the normal")  # fmt: skip
def _eq_13_direction() -> Outcome:
    normal, tangential = math.sqrt(3) / 2, 0.5
    kept = (normal * (1 - ALPHA)) ** 2 + tangential**2
    return Outcome(kept, (1 - ALPHA / 2) ** 2, 0.25 + 0.75 * (1 - ALPHA) ** 2)


# ---- two particles


def slope_of_energy(x: Floats, step: float = 1e-7) -> Floats:
    """Return the forces [N] on particles at ``x`` (N,) [m], k = 1e6 N/m, from the elastic energy.

    The energy sum f c/2 is differentiated centrally, so that no sign is put in by hand.
    """

    def energy(place: Floats) -> float:
        force = contact_forces(place, 2 * RADIUS, 1e6)
        return float(0.5 * force @ (2 * RADIUS - np.diff(place)))

    moves = step * np.eye(x.size)
    return np.array([(energy(x - move) - energy(x + move)) / (2 * step) for move in moves])


@cache
def _pairs() -> tuple[Floats, Floats]:
    """Return k times the overlaps of 50 pairs [N], and the forces on both (50, 2) [N]."""
    distances = 1.0 - samples.generator().uniform(1e-4, 0.2, 50)
    forces = np.array([slope_of_energy(np.array([0.0, d])) for d in distances])
    return 1e6 * (1.0 - distances), forces


@Statement("Methods, eq. (14)", "F = k dx, for two particles", 0.01, "N", DIFFERENCES)
def _eq_14() -> Outcome:
    printed, forces = _pairs()
    return Outcome(np.abs(forces[:, 0]), printed, note="slope of the energy")


@Statement("Methods, eq. (15)", "a_1 = k/m (2r_0 - (x_2 - x_1)), a_2 = -k/m (2r_0 - (x_2 - x_1))",
           0.01, "m/s2", DIFFERENCES,
           correction="signs of a_1 and a_2 exchanged, for x_1 < x_2")  # fmt: skip
def _eq_15() -> Outcome:
    size, forces = _pairs()
    printed = np.outer(size, [1.0, -1.0])
    return Outcome(forces, printed, -printed)


@Statement(PAIR, "there is no analytical solution",
           correction="harmonic: half a wave, over after pi sqrt(m/2k)")  # fmt: skip
def _no_solution() -> Outcome:
    pair, t0 = samples.free_collision(2), chain.contact_time(1.0, 1e6)
    inside, peak = pair.time <= t0, chain.peak_overlap(1.0, 1e6, 2.0)
    wave = peak * np.sin(np.pi * pair.time[inside] / t0)
    error = float(np.abs(pair.compression[inside] - wave).max()) / peak
    note = f"the sine differs from the motion by {error:.0e} of the peak"
    return holds(error > 1e-6, note, corrected=error < 1e-9)


@Statement(PAIR, "two particles exchange their velocities", 1e-9, "m/s",
           "exact propagator at 2 m/s: round-off")  # fmt: skip
def _exchange() -> Outcome:
    return Outcome(samples.free_collision(2).final_velocity, [0.0, 2.0])


@cache
def peak_error(stiffness: float, steps_per_contact: float) -> float:
    """Return the error of the largest deformation of an RK4 run against v sqrt(m/2k) [%]."""
    case = Tower(height=1, base="free", gravity=0.0, stiffness=stiffness)
    motion = solve(case, "rk4", duration=1.0, steps_per_contact=steps_per_contact, samples=100_000)
    exact = chain.peak_overlap(1.0, stiffness, case.speed)
    return 100 * abs(float(motion.compression.max()) / exact - 1)


def peak_errors() -> tuple[list[float], list[float]]:
    """Return the errors [%] over stiffness, of steps of contact time/50 and of a fixed step."""
    scaled = [peak_error(k, 50.0) for k in ERROR_STIFFNESSES]
    return scaled, [peak_error(k, math.pi / math.sqrt(k) / STEP) for k in ERROR_STIFFNESSES]


@Statement(f"{PAIR}, and Fig. 7",
           "the error of the peak deformation is below 0.5 % from 10,000 N/m on",
           reason="the printed bound, for a step that follows the stiffness")  # fmt: skip
def _error_size() -> Outcome:
    largest = max(peak_errors()[0][2:])
    return holds(largest < 0.5, f"RK4, contact time/50: {largest:.1e} % at most")


@Statement(f"{PAIR}, and Fig. 7", "the error of the peak deformation falls with stiffness",
           reason="to a tenth from 1e2 to 1e6 N/m, by a scaled or a fixed step",
           correction="RK4's error depends on omega times the step alone")  # fmt: skip
def _error_falls() -> Outcome:
    scaled, fixed = peak_errors()
    note = f"from {scaled[0]:.1e} to {scaled[-1]:.1e} % scaled, {fixed[0]:.1e} to {fixed[-1]:.1e}"
    return holds(scaled[-1] < 0.1 * scaled[0] or fixed[-1] < 0.1 * fixed[0], f"{note} % fixed")


# ---- three particles and chains


def _deformations_of_three() -> tuple[Floats, Floats, Floats, NDArray[np.bool_]]:
    """Return the three deformations, and where both contacts press."""
    three = samples.free_collision(3)
    first, second, third = three.deformations.T
    return first, second, third, np.asarray((three.forces > 0).all(axis=1))


@Statement(THREE,
           "first two particles deform alike, once the third joins the second deforms more",
           reason="to 1e-9 of the peak before, at every sample after")  # fmt: skip
def _asymmetric() -> Outcome:
    first, second, _, both = _deformations_of_three()
    before = np.abs(first - second)[: int(np.argmax(both))]
    return holds(before.max() / first.max() < 1e-9 and (second[both] > first[both]).all())


@Statement(THREE, "the third particle is the least deformed of the chain of three",
           correction="at first only, not once the grain rebounds")  # fmt: skip
def _least_deformed() -> Outcome:
    first, _, third, both = _deformations_of_three()
    least = third[both] < first[both]
    note = f"true of {100 * float(np.mean(least)):.0f} % of the time in which all touch"
    return holds(least.all(), note, corrected=least[1:20].all())


@Statement(f"{THREE}; Appendix A, proof by contradiction",
           "the two particles whose centres are closest are in contact",
           correction="only if they are closer than a diameter")  # fmt: skip
def _closest_pair() -> Outcome:
    def touch(some: Sequence[Particles]) -> list[bool]:
        return [bool(row.compressions[np.argmin(row.distances)] > 0) for row in some]

    near, far = samples.rows(closest=(0.9, 1.1)), samples.rows(closest=(1.0001, 1.2))
    closer = touch([row for row in near if row.distances.min() < 1.0])
    note = f"closer than d: {sum(closer)} of {len(closer)} touch; else {sum(touch(far))}"
    return holds(all(touch([*near, *far])), note, corrected=all(closer))


@Statement("Methods, eq. (16); Appendix A, eq. (A7)",
           "b_0 = ((-1)^n r_0 + sum (-1)^(i+1) (2(n-i)+1) x_i)/n", unit="m",
           correction="the r_0 term is ((-1)^n - 1)/2 r_0: none for even n")  # fmt: skip
def _eq_16() -> Outcome:
    def formula(centres: Floats) -> float:
        n = centres.size
        i = np.arange(1, n + 1)
        return float((-1) ** n * RADIUS + ((-1.0) ** (i + 1) * (2 * (n - i) + 1)) @ centres) / n

    chains = samples.touching_chains()
    values, printed = [c.boundaries[0] for c in chains], [formula(c.centres) for c in chains]
    right = [first_boundary(c.centres, RADIUS) for c in chains]
    return Outcome(values, printed, right, "200 chains of 2 to 9 particles, laid out from b_0")


@Statement("Methods, eq. (17)", "b_n = x_n + (x_n - b_(n-1))", unit="m")
def _eq_17() -> Outcome:
    chains = samples.touching_chains()
    printed = [2 * c.centres[-1] - c.boundaries[-2] for c in chains]
    return Outcome([c.boundaries[-1] for c in chains], printed)


@Statement("Methods, after eq. (17)",
           "positions and constraints fix contacts and deformations uniquely",
           reason="eigenvalues above 0; two methods without common code to 1e-12 m")  # fmt: skip
def _unique() -> Outcome:
    lowest = min(float(np.linalg.eigvalsh(chain.compliance(n, True))[0]) for n in range(1, 20))
    note = f"the matrix of the complementarity problem is positive definite ({lowest:.4f})"
    return holds(lowest > 0 and samples.sweep_difference() < 1e-12, note)


@Statement(END, "with three particles the transfer of momentum is incomplete: the grain rebounds",
           1e-9, reason="exact propagator and matrix exponentials to 1e-9")  # fmt: skip
def _incomplete() -> Outcome:
    kept = samples.free_collision(3).final_velocity / 2.0
    return Outcome(kept, chain.final_velocities(3, deformable=True), note=f"{kept[0]:.4f} v")


@Statement(f"{END}; Discussion",
           "three particles deform more in total, and store more energy, than two")  # fmt: skip
def _stored() -> Outcome:
    runs = samples.free_collision(2), samples.free_collision(3)
    total = [float(run.deformations.sum(axis=1).max()) for run in runs]
    stored = [float(run.elastic_energy.max() / run.kinetic_energy[0]) for run in runs]
    change, energy = 100 * (total[1] / total[0] - 1), stored[1] / stored[0]
    return holds(change > 0 and energy > 1, f"{change:+.1f} % deformation, {energy:.2f} energy")


@Statement(END, "to the grain three particles are like one particle of reduced stiffness", 1e-3,
           "v_0", "one free particle of any stiffness leaves the grain at rest",
           correction="a rebound takes a larger mass as well")  # fmt: skip
def _softer() -> Outcome:
    softer = Tower(stiffness=(1e6, 5e5), base="free", gravity=0.0)
    kept = float(samples.run(softer, 1.5).final_velocity[0]) / softer.speed
    return Outcome(float(chain.final_velocities(3, deformable=True)[0]), kept)
