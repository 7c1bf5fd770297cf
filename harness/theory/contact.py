"""Closed forms of contacts: impacts, rebound, adhesion, friction, rolling.

Each section gives its equation of motion and its source. Symbols: m* effective mass, R* effective
radius, E* effective modulus, e restitution, zeta damping ratio, omega = sqrt(k / m*), mu friction.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.special import beta

Floats = NDArray[np.float64]

# ---- the linear spring-dashpot contact: its restitution and its duration
#
# m x'' + 2 zeta omega m x' + omega^2 m x = 0 from x = 0 at speed 1:
# x = exp(-zeta omega t) sin(root omega t) / root, root^2 = 1 - zeta^2. With the attractive tail the
# contact ends when x returns to 0; clipped, it ends when the force k x + eta x' does (Schwager and
# Poeschel, Granular Matter 9, 465 (2007)).


def restitution_unclipped(zeta: float) -> float:
    """Return exp(-pi zeta / sqrt(1 - zeta^2)); 0 from critical damping on."""
    if zeta >= 1.0:
        return 0.0
    return math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta * zeta))


def restitution_clipped(zeta: float) -> float:
    """Return exp(-zeta omega t_end), the speed when the force vanishes over that before.

    At critical damping it is exp(-2) = 0.135: a clipped contact always rebounds.
    """
    return math.exp(-zeta * duration_clipped(zeta))


def duration_clipped(zeta: float) -> float:
    """Return omega t_end [-] of the clipped contact: when x'' first returns to 0."""
    if zeta == 1.0:
        return 2.0
    return abs(2.0 * cmath.acos(zeta) / cmath.sqrt(1.0 - zeta * zeta))


def duration_unclipped(zeta: float) -> float:
    """Return omega t_end [-] of a contact with its attractive tail, x = 0 again; zeta below 1."""
    return math.pi / math.sqrt(1.0 - zeta * zeta)


def largest_overlap(zeta: float) -> float:
    """Return omega x / v [-] where x' = 0, at half the time of :func:`duration_clipped`."""
    return math.exp(-0.5 * zeta * duration_clipped(zeta))


# ---- the head-on impact of elastic spheres under Hertz's law
#
# m* x'' = -K x^(3/2) with K = 4/3 E* sqrt(R*) (Johnson, Contact Mechanics (1985), section 11.4).


def stiffness(modulus: float, radius: float) -> float:
    """Return K = 4/3 E* sqrt(R*) [N/m^(3/2)] of the effective modulus [Pa] and radius [m]."""
    return 4.0 / 3.0 * modulus * math.sqrt(radius)


def largest_hertz_overlap(mass: float, coefficient: float, speed: float) -> float:
    """Return (5 m* v^2 / 4 K)^(2/5) [m]."""
    return float((1.25 * mass * speed**2 / coefficient) ** 0.4)


def largest_force(mass: float, coefficient: float, speed: float) -> float:
    """Return K overlap^(3/2) at the largest overlap [N]."""
    return float(coefficient * largest_hertz_overlap(mass, coefficient, speed) ** 1.5)


def contact_time(mass: float, coefficient: float, speed: float) -> float:
    """Return 4/5 B(2/5, 1/2) = 2.9433 times overlap / speed [s], with Euler's beta function."""
    periods = 0.8 * float(beta(0.4, 0.5))
    return periods * largest_hertz_overlap(mass, coefficient, speed) / speed


# ---- motion that is linear until a force reaches a limit

PLACES = 4000  # in a stretch of the motion, at which forces are compared with their limits


def _path(matrix: Floats, start: Floats, seconds: float) -> Floats:
    """Return the states of y' = A y at ``PLACES`` equal steps of a time, the start first."""
    step, path = expm(matrix * (seconds / PLACES)), np.array([start])
    while len(path) <= PLACES:
        path, step = np.concatenate([path, path @ step.T]), step @ step
    return path[: PLACES + 1]


def _reaches(force: Floats, limit: float, matrix: Floats, start: Floats, end: float) -> float:
    """Return when a force, linear in the state, first exceeds a limit [s], ``end`` if never."""
    beyond = np.flatnonzero(_path(matrix, start, end) @ force > limit)
    if not beyond.size or beyond[0] == 0:
        return 0.0 if beyond.size else end

    def excess(t: float) -> float:
        return float(force @ expm(matrix * t) @ start) - limit

    low = end / PLACES * (int(beyond[0]) - 1)
    return float(brentq(excess, low, low + end / PLACES, xtol=1e-16 * end, rtol=1e-15))


# ---- a sphere that bounces under gravity on a linear spring and dashpot
#
# Flight: a parabola. Contact: x'' = g - 2 zeta omega x' - omega^2 x from x = 0 at speed v until x
# = 0 again (tail attractive). MFiX's verification case DEM02 holds the apexes against it.


class Rebound(NamedTuple):
    """Duration of a contact [s], speed at its end [m/s], largest overlap [m]."""

    duration: float
    speed: float
    overlap: float


def rebound(omega: float, zeta: float, gravity: float, speed: float) -> Rebound | None:
    """Return the contact of an impact; None where the sphere stays in contact for ever.

    ``omega`` = sqrt(k/m) [rad/s], ``zeta`` the damping ratio, below 1.
    """
    # of omega x, x' and 1
    rates = np.array([[0.0, omega, 0.0], [-omega, -2.0 * zeta * omega, gravity], [0.0, 0.0, 0.0]])
    start, period = np.array([0.0, speed, 1.0]), 2.0 * math.pi / omega / math.sqrt(1.0 - zeta**2)
    end = _reaches(np.array([-1.0, 0.0, 0.0]), 0.0, rates, start, period)
    if end == period:
        return None
    turn = _reaches(np.array([0.0, -1.0, 0.0]), 0.0, rates, start, period)
    _, last, _ = expm(rates * end) @ start
    return Rebound(end, -float(last), float((expm(rates * turn) @ start)[0]) / omega)


# ---- adhesion of elastic spheres: forces and overlaps of pull-off
#
# gamma is the surface energy of each body, 2 gamma the work of adhesion. Derjaguin, Muller and
# Toporov, J. Colloid Interface Sci. 53, 314 (1975); Johnson, Kendall and Roberts, Proc. R. Soc. A
# 324, 301 (1971): with c^2 = pi gamma / E* and the contact radius a
#
#     F = E* (4 a^3 / (3 R*) - 4 c a^(3/2)),   overlap = a^2 / R* - 2 c sqrt(a),
#
# and a^3 = s c^2 R*^2 with s = 9 without load, 4 where contact forms (overlap 0), 9/4 at the
# largest tension, 1/4 at the fold beyond which no area is left.

State = Literal["without load", "contact forms", "largest tension", "fold"]
SIZES: dict[State, float] = {
    "without load": 9.0, "contact forms": 4.0, "largest tension": 2.25, "fold": 0.25,
}  # fmt: skip


def dmt_pull_off(surface_energy: float, radius: float) -> float:
    """Return 4 pi gamma R* [N], the tension at overlap 0."""
    return 4.0 * math.pi * surface_energy * radius


def jkr_pull_off(surface_energy: float, radius: float) -> float:
    """Return 3 pi gamma R* [N], the largest tension, whatever the modulus."""
    return 3.0 * math.pi * surface_energy * radius


def jkr_contact_radius(state: State, surface_energy: float, modulus: float, radius: float) -> float:
    """Return a [m] of a state."""
    cube = SIZES[state] * math.pi * surface_energy * radius**2 / modulus
    return float(cube ** (1.0 / 3.0))


def jkr_overlap(state: State, surface_energy: float, modulus: float, radius: float) -> float:
    """Return the overlap [m] of a state: a^2 / R* (1 - 2 / sqrt(s)), negative for s below 4."""
    a = jkr_contact_radius(state, surface_energy, modulus, radius)
    return a * a / radius * (1.0 - 2.0 / math.sqrt(SIZES[state]))


def mdr_force_and_depth(
    surface_energy: float, modulus: float, radius: float, a: float
) -> tuple[float, float]:
    """Return force [N] and depth [m] of a sphere that sticks to a flat and is pulled, by mdr.

    ``modulus`` is E / (1 - nu^2), ``surface_energy`` that of sphere and flat, ``a`` the contact
    radius [m]; Zunker and Kamrin, J. Mech. Phys. Solids 183, 105492 (2024), elastic.
    """
    angle = math.asin(a / radius)
    length = math.sqrt(2.0 * math.pi * a * surface_energy / modulus)
    elastic = 2.0 * modulus * radius**2 * (angle - math.sin(angle) * math.cos(angle))
    depth = 4.0 * radius * math.sin(0.5 * angle) ** 2 - length
    return elastic - 2.0 * modulus * a * length, depth


def mdr_pull_off(surface_energy: float, modulus: float, radius: float) -> tuple[float, float]:
    """Return the largest tension [N], and the depth at which the area vanishes [m], by mdr.

    With a = R sin t the force is least where 2 R sin t tan t = 3/2 l, the depth where that is l/2;
    for small a / R these are JKR's 3/2 pi gamma R and fold. Arguments as those of
    :func:`mdr_force_and_depth`.
    """

    def where_length_is(part: float) -> tuple[float, float]:
        def excess(a: float) -> float:
            length = math.sqrt(2.0 * math.pi * a * surface_energy / modulus)
            return 2.0 * a * a - part * length * math.sqrt((radius - a) * (radius + a))

        a = float(brentq(excess, 1e-9 * radius, radius, xtol=1e-16 * radius, rtol=1e-15))
        return mdr_force_and_depth(surface_energy, modulus, radius, a)

    return -where_length_is(1.5)[0], where_length_is(0.5)[1]


# ---- oblique elastic impact with partial slip
#
# Maw, Barber and Fawcett, Wear 38, 101 (1976): a solid elastic sphere on a half-space of the same
# material, the contact circle of which sticks inside and slips outside. Computed by springs that
# do not know each other, which is the same problem (Lyashenko and Popov, Scientific Reports 5,
# 8479 (2015)): one at x is pressed by delta - x^2 / R, moves with the body while it sticks, and
# carries at most mu times its normal force.
#
# Dimensionless, the incidence and the one parameter of a solid sphere are
#
#     psi = kappa / mu * u / v,    kappa = 2 (1 - nu) / (2 - nu),    chi = 7/4 kappa
#
# with u and v the tangential and normal velocity at the contact. Sliding throughout, from psi = 4
# chi - 1 on, the rebound is psi - 4 chi.

SPRINGS, STEPS = 200, 2000  # on half of the largest contact, and of the impact


def stiffness_ratio(poisson: float) -> float:
    """Return kappa, tangential over normal stiffness of a contact that sticks."""
    return 2.0 * (1.0 - poisson) / (2.0 - poisson)


def partial_slip_rebound(
    psi: ArrayLike, poisson: float, springs: int = SPRINGS, steps: int = STEPS
) -> NDArray[np.float64]:
    """Return psi of the rebound for psi of the incidence, any shape; without spin before.

    ``springs`` on half of the contact and ``steps`` of the impact: the error falls with the step.
    """
    psi = np.asarray(psi, dtype=float)
    chi = 1.75 * stiffness_ratio(poisson)
    time, overlaps = _normal_motion(steps)
    h = time[1] - time[0]
    places = (np.arange(springs) + 0.5) / springs * np.sqrt(overlaps.max())
    width = 2.0 * (places[1] - places[0])  # both halves
    speed = psi.reshape(-1, 1).copy()
    strains = np.zeros((speed.size, springs))
    force = np.zeros_like(speed)
    for overlap in overlaps[1:]:
        speed -= h * chi * force
        limit = np.maximum(overlap - places**2, 0.0)
        strains = spring_strains(strains + h * speed, limit)
        force = width * strains.sum(axis=1, keepdims=True)
        speed -= h * chi * force
    return np.asarray(speed.reshape(psi.shape))


def spring_strains(strains: Floats, limit: Floats) -> Floats:
    """Return strains cut back to Coulomb's limit, which is 0 outside the contact."""
    return np.clip(strains, -limit, limit)


def _normal_motion(steps: int) -> tuple[Floats, Floats]:
    """Return times and overlaps of a Hertzian impact with E* = R = m = v = 1, (steps + 1,)."""
    from scipy.integrate import solve_ivp  # slow to load

    time = np.linspace(0.0, contact_time(1.0, 4.0 / 3.0, 1.0), steps + 1)
    run = solve_ivp(
        lambda _, y: [y[1], -4.0 / 3.0 * max(y[0], 0.0) ** 1.5],
        (0.0, time[-1]), [0.0, 1.0], t_eval=time, rtol=1e-11, atol=1e-13,
    )  # fmt: skip
    return time, np.maximum(run.y[0], 0.0)


# ---- a solid sphere that slides, rolls or turns on a plane under its weight
#
# I = 2/5 m r^2.


class Incline(NamedTuple):
    """Whether a sphere rolls down an incline, its acceleration and r times its angular one."""

    rolls: bool
    acceleration: float
    turning: float


def down_an_incline(angle: float, friction: float, gravity: float) -> Incline:
    """Return how a sphere starts down an incline [rad, m/s2].

    It rolls with 5/7 g sin(angle) while tan(angle) <= 7/2 mu, for that takes a friction of 2/7 of
    the pull; else it slides with g (sin - mu cos), and r alpha = 5/2 mu g cos.
    """
    pull, load = gravity * math.sin(angle), gravity * math.cos(angle)
    if pull <= 3.5 * friction * load:
        return Incline(True, 5.0 / 7.0 * pull, 5.0 / 7.0 * pull)
    return Incline(False, pull - friction * load, 2.5 * friction * load)


def twisting_deceleration(twisting_friction: float, radius: float, gravity: float) -> float:
    """Return by how much omega about the normal falls in a second [rad/s2]: 5/2 mu_w g / r^2.

    The resisting torque is mu_w m g with mu_w a length [m]; Marshall's is 2/3 mu a, a the contact
    radius (of a pressure that is constant over the contact).
    """
    return 2.5 * twisting_friction * gravity / radius**2


# ---- a spring and a dashpot in parallel under a constant limit, in one direction
#
# The force against the motion is k q + c u, at most the limit in size: beyond it the spring is cut
# back so that both together hold the limit (Luding, Granular Matter 10, 235 (2008), section 4.2).


def limited_forces(
    stiffness: float, dashpot: float, limit: float, pieces: Iterable[tuple[float, float]]
) -> list[float]:
    """Return the force along the motion at the end of each piece: displacement, duration [s].

    The velocity is constant in a piece. The spring is slack at the start.
    """
    stretch, forces = 0.0, []
    for displacement, duration in pieces:
        drag = dashpot * displacement / duration
        resisting = stiffness * (stretch + displacement) + drag
        limited = math.copysign(min(abs(resisting), limit), resisting)
        stretch = (limited - drag) / stiffness
        forces.append(-limited)
    return forces


def twisting_spin(
    time: float, spin: float, inertia: float, spring: tuple[float, float], limit: float
) -> float:
    """Return the spin [rad/s] after a time [s] of a body that only a twisting contact slows down.

    ``inertia`` in kg m2; ``spring``: stiffness [N m] and dashpot [N m s]; ``limit`` [N m] of the
    torque. It sticks until the torque reaches the limit, slows down at a constant rate while it
    slips, and sticks again where k omega = c limit / I, the rate of the torque if it stuck being
    none: from there on it swings below the limit.
    """
    k, c = spring
    sticks = np.array([[0.0, 1.0], [-k / inertia, -c / inertia]])  # of angle and spin
    # the torque is largest before the spin first is 0: at most pi / 2 times sqrt(I / k) after start
    swing = min(time, 2.0 * math.sqrt(inertia / k))
    slips = _reaches(np.array(spring), limit, sticks, np.array([0.0, spin]), swing)
    slips = slips if slips < swing else time
    first = float((expm(sticks * slips) @ [0.0, spin])[1])
    slowing = limit / inertia
    last = c * slowing / k
    stands = slips + max(0.0, first - last) / slowing
    if time <= stands:
        return first - slowing * (time - slips)
    return float((expm(sticks * (time - stands)) @ [(limit - c * last) / k, last])[1])


# ---- a sphere let go on an incline, held or slowed down by rolling resistance
#
# Forces act at r from the centre, with q = r phi:
#
#     m x'' = m p - T,   2/5 m q'' = T - f,   T = k (x - q) + c (x' - q'),
#     f = k_r q + c_r q', at most the limit mu_r N.
#
# It is linear until f reaches the limit, and linear with f = mu_r N from there on: at rest where
# tan(angle) < mu_r, at q = m p / k_r, x = q + m p / k; else accelerated by
# 5/7 (p - mu_r g cos(angle)) in the mean.


def on_an_incline(
    times: Iterable[float], pull: float, mass: float, tangential: tuple[float, float],
    rolling: tuple[float, float], limits: tuple[float, float],
) -> list[Floats] | None:  # fmt: skip
    """Return x [m], x' [m/s], q [m] and q' [m/s] of a sphere let go at rest, at times [s].

    ``pull`` is gravity along the incline [m/s2], both springs stiffness [N/m] and dashpot [kg/s];
    ``limits`` of their forces [N]. None where the contact slides, and where the torque falls below
    its limit again.
    """
    (k, c), (kr, cr), times = tangential, rolling, [*times]
    w = math.sqrt(k / mass)
    slip = np.array([k / w, c, -k / w, -c, 0.0])  # T, of (w x, x', w q, q', 1)
    resists = np.array([0.0, 0.0, kr / w, cr, 0.0])

    def rates(turning: Floats) -> Floats:
        matrix = np.zeros((5, 5))
        matrix[0, 1] = matrix[2, 3] = w
        matrix[1] = -slip / mass
        matrix[1, 4] = pull
        matrix[3] = (slip - turning) / (0.4 * mass)
        return matrix

    sticking, start, end = rates(resists), np.array([0.0, 0.0, 0.0, 0.0, 1.0]), max(times)
    rolls = _reaches(resists, limits[1], sticking, start, end)
    path = _path(sticking, start, rolls)
    if np.abs(path @ resists).max() > limits[1] * (1.0 + 1e-9):
        return None
    onward, turned = (
        rates(np.array([0.0, 0.0, 0.0, 0.0, limits[1]])),
        expm(sticking * rolls) @ start,
    )
    if rolls < end:
        after = _path(onward, turned, end - rolls)
        rising = after @ (np.array([0.0, 0.0, 0.0, kr, 0.0]) + cr * onward[3])
        if rising.min() < -1e-9 * np.abs(rising).max():
            return None
        path = np.concatenate([path, after])
    if np.abs(path @ slip).max() > limits[0]:
        return None
    reached = [
        expm(sticking * t) @ start if t <= rolls else expm(onward * (t - rolls)) @ turned
        for t in times
    ]
    return [state[:4] / (w, 1.0, w, 1.0) for state in reached]


def against_constant_torque(
    time: float, speed: float, pull: float, mass: float, stiffness: float,
    limits: tuple[float, float],
) -> tuple[float, float] | None:  # fmt: skip
    """Return speed and rim speed [m/s] of a sphere that rolls against a constant torque, at a time.

    Model A of Ai and others, Powder Technol. 206, 269 (2011). It rolls at a ``speed`` [m/s] at the
    start; ``pull`` is gravity along the floor [m/s2]. ``limits`` are those of friction and of the
    torque over the radius [N]: mu N and D = mu_r N. The spring s of friction, without a dashpot,
    follows s'' = p + 5/2 D/m - 7/2 k s/m, so that rolling changes by 5/7 (p - D/m). None where it
    slides, and where it may have stopped.
    """
    friction, drag = limits[0], limits[1] / mass
    rate, w = pull + 2.5 * drag, math.sqrt(3.5 * stiffness / mass)
    swing = abs(rate) / w
    stopped = speed + 5.0 / 7.0 * (pull - drag) * time <= 9.0 / 7.0 * swing
    if stopped or 4.0 / 7.0 * abs(rate) * mass > friction:
        return None
    slip = rate / w * math.sin(w * time)
    moved = speed + 5.0 / 7.0 * (pull - drag) * time + 2.0 / 7.0 * slip
    return moved, moved - slip


# ---- a sphere that a fluid drags, and heat through a contact
#
# m u' = m g - gamma u, from rest; LAMMPS's fix viscous. Heat: C_i T_i' = -+ G (T_1 - T_2), G = 2 k
# a through a circle of radius a between two half-spaces of conductivity k (Carslaw and Jaeger,
# Conduction of Heat in Solids (1959), section 8.2), or h pi a^2.


def dragged(times: float) -> tuple[float, float]:
    """Return speed over the terminal v = m g / gamma, and distance over v m / gamma.

    ``times`` m / gamma after it was let go.
    """
    return -math.expm1(-times), times + math.expm1(-times)


def conductance(model: Literal["radius", "area"], coefficient: float, a: float) -> float:
    """Return G [W/K] of a contact of radius ``a`` [m]: 2 k a, or h pi a^2 (W/m/K, W/m2/K)."""
    return 2.0 * coefficient * a if model == "radius" else coefficient * math.pi * a * a


def cooling_rate(conductance: float, capacities: Iterable[float]) -> float:
    """Return at which rate [1/s] a difference in temperature decays, between bodies of J/K.

    One that is not among them is kept at its temperature.
    """
    return conductance * sum(1.0 / capacity for capacity in capacities)


# ---- a contact on a wall that oscillates
#
# In the frame of the wall, of acceleration a cos(w t) from rest on, a linear contact is
# y'' + 2 d y' + W^2 y = -a cos(w t), y the displacement from rest: along the normal W^2 = k / m,
# 2 d = eta / m, along the surface 7/2 of them, y the slip.


def driven(
    times: Floats, frequency: float, decay: float, acceleration: float, drive: float
) -> tuple[Floats, Floats]:
    """Return y [m] and y' [m/s] at times [s], each (M,): W and d, a [m/s2] and w [rad/s].

    From rest; w may not be W without damping.
    """
    transfer = -acceleration / (frequency**2 - drive**2 + 2j * decay * drive)
    root = cmath.sqrt(decay**2 - frequency**2)
    eigenvalues = (-decay + root, -decay - root)
    # y = Re(transfer e^(i w t)) + c_1 e^(s_1 t) + c_2 e^(s_2 t) with y(0) = y'(0) = 0
    y, speed = -transfer.real, -(1j * drive * transfer).real
    first = (speed - eigenvalues[1] * y) / (eigenvalues[0] - eigenvalues[1])
    rates = np.array([1j * drive, *eigenvalues])
    parts = np.array([transfer, first, y - first])
    waves = np.exp(np.outer(np.asarray(times, dtype=float), rates))
    return (waves @ parts).real, (waves @ (rates * parts)).real
