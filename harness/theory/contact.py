"""Closed forms of contacts: impacts, rebound, adhesion, friction, rolling.

Each section states its equation of motion and its source. Symbols: m* effective mass, R* effective
radius, E* effective modulus, e restitution, zeta damping ratio, omega = sqrt(k / m*), mu friction.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterable
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

# ---- the linear spring-dashpot contact: its restitution and its duration
#
# m x'' + 2 zeta omega m x' + omega^2 m x = 0 from x = 0 at speed 1. With the attractive tail kept
# the contact ends when x returns to 0; clipped, it ends when the force k x + eta x' does (Schwager
# and Poeschel, Granular Matter 9, 465 (2007)).

PHASES = 400  # places within a step at which a contact is taken to begin
MOST_STEPS = 1000.0  # per contact time, above which a restitution is the closed form's to 0.2 %
LONGEST = 10.0  # [pi / omega] after which a grain that has not left creeps, and does not rebound


def restitution_unclipped(zeta: float) -> float:
    """Return exp(-pi zeta / sqrt(1 - zeta^2)); 0 from critical damping on."""
    if zeta >= 1.0:
        return 0.0
    return math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta * zeta))


def restitution_clipped(zeta: float) -> float:
    """Return exp(-zeta omega t_end), the speed over that before when the force vanishes.

    x = exp(-zeta omega t) sin(root omega t) / root has x'' = 0 at :func:`duration_clipped`, where
    -x' is the exponential alone. At critical damping it is exp(-2) = 0.135: a clipped contact
    always rebounds.
    """
    return math.exp(-zeta * duration_clipped(zeta))


def duration_clipped(zeta: float) -> float:
    """Return omega t_end [-] of the clipped contact: when x'' first returns to 0."""
    if zeta == 1.0:
        return 2.0
    if zeta < 1.0:
        root = math.sqrt(1.0 - zeta * zeta)
        return 2.0 * math.acos(zeta) / root
    root = math.sqrt(zeta * zeta - 1.0)
    return 2.0 * math.acosh(zeta) / root


def duration_unclipped(zeta: float) -> float:
    """Return omega t_end [-] of a contact with its attractive tail, x = 0 again; zeta below 1."""
    return math.pi / math.sqrt(1.0 - zeta * zeta)


def largest_overlap(zeta: float) -> float:
    """Return omega x / v [-] where x' = 0.

    x = exp(-zeta omega t) sin(root omega t) / root, root^2 = 1 - zeta^2, turns where
    tan(root omega t) = root / zeta, half the time of :func:`duration_clipped`; beyond zeta = 1
    with sinh and tanh.
    """
    return math.exp(-0.5 * zeta * duration_clipped(zeta))


def restitution_in_steps(zeta: float, steps: float, *, clipped: bool) -> float:
    """Return the greatest restitution that the contact has at so many steps per pi / omega.

    v+ = v + h a(x, v), x+ = x + h v+, the recurrence of velocity Verlet in the velocities of half
    steps and of semi-implicit Euler. A step sees the contact only where there is overlap, so the
    restitution depends on where within a step the contact begins: this is the greatest over
    ``PHASES`` places, and not less than that of the closed form.
    """
    exact = (restitution_clipped if clipped else restitution_unclipped)(zeta)
    if steps > MOST_STEPS:
        return exact
    h = math.pi / steps
    x = h * (np.arange(PHASES) + 0.5) / PHASES  # the overlap in the first step that sees it
    v = np.ones(PHASES)
    touching = x > 0.0
    for _ in range(math.ceil(LONGEST * steps)):
        force = x + 2.0 * zeta * v
        force = np.maximum(force, 0.0) if clipped else force
        v = np.where(touching, v - h * force, v)
        x = np.where(touching, x + h * v, x)
        touching = touching & (x > 0.0)
        if not touching.any():
            break
    return max(exact, float(-v[~touching].min(initial=0.0)))


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
    from scipy.special import beta

    periods = 0.8 * float(beta(0.4, 0.5))
    return periods * largest_hertz_overlap(mass, coefficient, speed) / speed


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
    from scipy.optimize import brentq

    turns = omega * math.sqrt(1.0 - zeta * zeta)
    rest = gravity / omega**2
    sine = (gravity - zeta * omega * speed) / turns

    def velocity(time: float) -> float:
        wave = speed * math.cos(turns * time) + sine * math.sin(turns * time)
        return math.exp(-zeta * omega * time) * wave

    def overlap(time: float) -> float:
        wave = -rest * math.cos(turns * time)
        wave += (speed - zeta * omega * rest) / turns * math.sin(turns * time)
        return rest + math.exp(-zeta * omega * time) * wave

    peak = math.atan2(speed, -sine) / turns
    trough = peak + math.pi / turns
    if overlap(trough) > 0.0:
        return None
    end = float(brentq(overlap, peak, trough, xtol=1e-16 * trough, rtol=1e-15))
    return Rebound(end, -velocity(end), overlap(peak))


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
    """Return the overlap [m] of a state: a^2 / R* (1 - 2 / sqrt(s)), negative after pull-off."""
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
    """Return the largest tension [N], and the depth at which no area is left [m], by mdr.

    With a = R sin t the force is least where 2 R sin t tan t = 3/2 l, the depth where that is l/2;
    for small a / R these are JKR's 3/2 pi gamma R and fold. Arguments as those of
    :func:`mdr_force_and_depth`.
    """

    def radius_where(part: float) -> float:
        def excess(a: float) -> float:
            length = math.sqrt(2.0 * math.pi * a * surface_energy / modulus)
            return 2.0 * a * a / math.sqrt((radius - a) * (radius + a)) - part * length

        return _root(excess, 0.0, radius)

    tension, _ = mdr_force_and_depth(surface_energy, modulus, radius, radius_where(1.5))
    _, last = mdr_force_and_depth(surface_energy, modulus, radius, radius_where(0.5))
    return -tension, last


def _root(excess: Callable[[float], float], low: float, high: float) -> float:
    """Return where a function that is negative just above ``low`` turns positive, to round-off."""
    while low < (middle := 0.5 * (low + high)) < high:
        if excess(middle) < 0.0:
            low = middle
        else:
            high = middle
    return high


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

Array = NDArray[np.float64]

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


def spring_strains(strains: Array, limit: Array) -> Array:
    """Return strains cut back to Coulomb's limit; a spring that has left carries nothing."""
    return np.clip(strains, -limit, limit)


@lru_cache(maxsize=8)
def _normal_motion(steps: int) -> tuple[Array, Array]:
    """Return times and overlaps of a Hertzian impact with E* = R = m = v = 1, (steps + 1,)."""
    from scipy.integrate import solve_ivp

    def rates(_: float, y: Array) -> list[float]:
        return [y[1], -4.0 / 3.0 * max(y[0], 0.0) ** 1.5]

    def parts(_: float, y: Array) -> float:
        return float(y[0])

    parts.terminal, parts.direction = True, -1.0  # type: ignore[attr-defined]
    solution = solve_ivp(
        rates, (0.0, 10.0), [0.0, 1.0], events=parts, dense_output=True, rtol=1e-11, atol=1e-13
    )
    assert solution.t_events is not None
    assert solution.sol is not None
    time = np.linspace(0.0, solution.t_events[0][0], steps + 1)
    return time, np.maximum(solution.sol(time)[0], 0.0)


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

    ``inertia`` in kg m2; ``spring``: stiffness [N m] and dashpot [N m s] of less than critical
    damping; ``limit`` [N m] of the torque. It sticks until the torque reaches the limit, slows down
    at a constant rate while it slips, and sticks again where k omega = c limit / I, the rate of the
    torque if it stuck being none: from there on it swings below the limit.
    """
    from scipy.optimize import brentq

    k, c = spring
    decay, omega = 0.5 * c / inertia, math.sqrt(k / inertia)
    if decay >= omega:
        raise ValueError(f"dashpot = {c!r} N m s: must be below critical damping")
    rate = math.sqrt(omega * omega - decay * decay)

    def swings(t: float, turned: float, speed: float) -> tuple[float, float]:
        """Return angle and spin of the damped oscillation after a time."""
        sine, cosine, decayed = math.sin(rate * t), math.cos(rate * t), math.exp(-decay * t)
        push = (speed + decay * turned) / rate
        angle = decayed * (turned * cosine + push * sine)
        return angle, decayed * rate * (push * cosine - turned * sine) - decay * angle

    def beyond(t: float) -> float:
        turned, speed = swings(t, 0.0, spin)
        return k * turned + c * speed - limit

    # the torque is largest where its rate k omega + c alpha is none
    phase = math.atan2(rate * (k - 2.0 * decay * c), decay * k + c * (rate**2 - decay**2))
    largest = max(0.0, phase) / rate
    if beyond(largest) <= 0.0:
        return swings(time, 0.0, spin)[1]
    slips = 0.0 if beyond(0.0) >= 0.0 else float(brentq(beyond, 0.0, largest, xtol=1e-16 / omega))
    if time <= slips:
        return swings(time, 0.0, spin)[1]
    start, slowing = swings(slips, 0.0, spin)[1], limit / inertia
    last = c * slowing / k
    stands = slips + max(0.0, start - last) / slowing
    if time <= stands:
        return start - slowing * (time - slips)
    return swings(time - stands, (limit - c * last) / k, last)[1]


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

PLACES = 4000  # in the time at which forces are compared with their limits


def on_an_incline(
    times: Iterable[float], pull: float, mass: float, tangential: tuple[float, float],
    rolling: tuple[float, float], limits: tuple[float, float],
) -> list[Array] | None:  # fmt: skip
    """Return x [m], x' [m/s], q [m] and q' [m/s] of a sphere let go at rest, at times [s].

    ``pull`` is gravity along the incline [m/s2], both springs stiffness [N/m] and dashpot [kg/s];
    ``limits`` of their forces [N]. None where the contact slides, and where the torque falls below
    its limit again.
    """
    from scipy.linalg import expm
    from scipy.optimize import brentq

    (k, c), (kr, cr), times = tangential, rolling, [*times]
    w = math.sqrt(k / mass)
    slip = np.array([k / w, c, -k / w, -c, 0.0])  # T, of (w x, x', w q, q', 1)
    resists = np.array([0.0, 0.0, kr / w, cr, 0.0])
    constant = np.array([0.0, 0.0, 0.0, 0.0, limits[1]])

    def rates(turning: Array) -> Array:
        """Return the matrix of the motion under a torque over r, linear in the state."""
        matrix = np.zeros((5, 5))
        matrix[0, 1] = matrix[2, 3] = w
        matrix[1] = -slip / mass
        matrix[1, 4] = pull
        matrix[3] = (slip - turning) / (0.4 * mass)
        return matrix

    def states(matrix: Array, first: Array, span: float) -> Array:
        step, path = expm(matrix * span / PLACES), [first]
        for _ in range(PLACES):
            path.append(step @ path[-1])
        return np.array(path)

    sticking, start, end = rates(resists), np.array([0.0, 0.0, 0.0, 0.0, 1.0]), max(times)
    path = states(sticking, start, end)
    beyond = np.flatnonzero(path @ resists > limits[1])
    rolls = end
    if beyond.size:

        def excess(t: float) -> float:
            return float(resists @ expm(sticking * t) @ start) - limits[1]

        low = end / PLACES * (int(beyond[0]) - 1)
        rolls = float(brentq(excess, low, low + end / PLACES, xtol=1e-16 * end, rtol=1e-15))
        path = path[: int(beyond[0])]
    elif np.abs(path @ resists).max() > limits[1]:
        return None
    turned = expm(sticking * rolls) @ start
    onward = rates(constant)
    if rolls < end:
        after = states(onward, turned, end - rolls)
        rising = after @ (kr * np.array([0, 0, 0, 1.0, 0]) + cr * onward[3])
        if rising.min() < -1e-9 * np.abs(rising).max():
            return None
        path = np.concatenate([path, after])
    if np.abs(path @ slip).max() > limits[0]:
        return None
    scales = np.array([1.0 / w, 1.0, 1.0 / w, 1.0])
    reached = [
        expm(sticking * t) @ start if t <= rolls else expm(onward * (t - rolls)) @ turned
        for t in times
    ]
    return [state[:4] * scales for state in reached]


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
    times: Array, frequency: float, decay: float, acceleration: float, drive: float
) -> tuple[Array, Array]:
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
