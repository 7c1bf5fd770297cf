"""Closed forms that tests hold solvers and scenes against, and that no case needs."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from harness.theory import chain
from harness.theory import contact as bounce
from harness.theory import contact as cohesion
from harness.theory import contact as dashpot

Floats = NDArray[np.float64]


def slid_over_sphere(theta: float, energy: float) -> object:
    """Integrate sliding over a sphere from well to well, from an energy in m g d behind its crest.

    ``theta`` [rad] is the slope; SciPy's solution holds the angle from the vertical and its rate.
    """

    def slide(_: float, state: Floats) -> list[float]:
        return [state[1], math.sin(state[0])]

    def next_well(_: float, state: Floats) -> float:
        return float(state[0] - theta - math.pi / 6)

    next_well.terminal = True
    start = [theta - math.pi / 6, math.sqrt(2 * energy)]
    return solve_ivp(slide, (0.0, 100.0), start, events=next_well, rtol=1e-11, atol=1e-12)


def apexes(
    omega: float, zeta: float, gravity: float, height: float, bounces: int
) -> tuple[tuple[float, float], ...]:
    """Return time [s] and height [m] of each apex, above the place where contact begins.

    The first is the start at rest; fewer follow where the sphere stays in contact.
    """
    found = [(0.0, height)]
    time, speed = math.sqrt(2.0 * height / gravity), math.sqrt(2.0 * gravity * height)
    for _ in range(bounces):
        one = bounce.rebound(omega, zeta, gravity, speed)
        if one is None:
            break
        time, speed = time + one.duration, one.speed
        found.append((time + speed / gravity, 0.5 * speed**2 / gravity))
        time += 2.0 * speed / gravity
    return tuple(found)


def jkr_force(state: cohesion.State, surface_energy: float, radius: float) -> float:
    """Return the force [N] of a state, 4/3 pi gamma R* (s - 3 sqrt(s)); negative is tension."""
    s = cohesion.SIZES[state]
    return 4.0 / 3.0 * math.pi * surface_energy * radius * (s - 3.0 * math.sqrt(s))


def jkr_loss(end: cohesion.State, surface_energy: float, modulus: float, radius: float) -> float:
    """Return the work [J] that parting takes beyond the overlap 0 at which contact forms.

    The integral of F from the overlap of ``end`` to 0, negated: an impact with less kinetic
    energy than that sticks, another one loses it. In units of E* c^2 a^2 the integral of F is
    8/15 s - 8/3 sqrt(s) + 2.
    """

    def work(state: cohesion.State) -> float:
        s, a = (
            cohesion.SIZES[state],
            cohesion.jkr_contact_radius(state, surface_energy, modulus, radius),
        )
        shape = 8.0 / 15.0 * s - 8.0 / 3.0 * math.sqrt(s) + 2.0
        return math.pi * surface_energy * a * a * shape

    return work(end) - work("contact forms")


def strongly_damped(damping: float) -> float:
    """Return the restitution of the clipped contact as a -> infinity: (6/5)^(2/3) a^(-5/3)."""
    return float(1.2 ** (2.0 / 3.0) * damping ** (-5.0 / 3.0))


def first_order_loss() -> float:
    """Return d(1 - e)/da at a = 0: the work of the dashpot on the undamped motion."""
    from scipy.special import beta

    return float(beta(0.6, 1.5))


def viscoelastic_series(damping: float) -> float:
    """Return 1 - c a + 3/5 (c a)^2, the restitution to second order in a = A v / overlap.

    a grows as v^(1/5). Ramirez, Poeschel, Brilliantov and Schwager, Phys. Rev. E 60, 4465
    (1999): their C2 is 3/5 C1^2; c is :func:`first_order_loss`.
    """
    loss = first_order_loss() * damping
    return 1.0 - loss + 0.6 * loss**2


def sticks_at_first(friction: float, stiffness_ratio: float) -> float:
    """Return u / v up to which an elastic contact begins sticking: mu k_n / k_t.

    The ratio k_t / k_n is of stiffnesses at one overlap: 4 G* / E* for Hertz and increments of
    Mindlin's force, 2 (1 - nu) / (2 - nu) of like materials, which is psi = 1 in Maw, Barber and
    Fawcett, Wear 38, 101 (1976). Mindlin on the total displacement has 2/3 of it.
    """
    return friction / stiffness_ratio


def slides_throughout_elastic(friction: float, stiffness_ratio: float) -> float:
    """Return u / v from which on an elastic contact without damping slides to its end.

    A slider at its limit recovers with the spring as it opens, as long as u > -mu v k_n / k_t:
    7 mu - mu k_n / k_t, psi = 4 chi - 1 of Maw, Barber and Fawcett. With the limit of
    :func:`sticks_at_first` where that is larger.
    """
    recovery = sticks_at_first(friction, stiffness_ratio)
    return max(slides_throughout(friction, 1.0) - recovery, recovery)


def sticking_restitution(stiffness_ratio: float, damping_ratio: float, *, clipped: bool) -> float:
    """Return -u'/u of linear springs, mu so large that they stick, without tangential dashpot.

    u oscillates with omega_t^2 = 7/2 k_t / m*. The limit mu |N| vanishes with the normal force, at
    omega t = 2 acos(zeta) / sqrt(1 - zeta^2), whatever mu: the spring is cut back to nothing and
    starts anew for the attractive tail, if there is one. Hence -cos(omega_t t_1) cos(omega_t t_2)
    with t_1 until then and t_2 from then on; one cosine, of the whole contact, without damping.
    """
    shear = math.sqrt(3.5 * stiffness_ratio)
    repelled = dashpot.duration_clipped(damping_ratio)
    whole = math.pi / math.sqrt(1.0 - damping_ratio**2)
    tail = 0.0 if clipped else whole - repelled
    return -math.cos(shear * repelled) * math.cos(shear * tail)


class SlipToRoll(NamedTuple):
    """When a sphere that slides begins to roll [s], and its speed from then on [m/s]."""

    time: float
    speed: float


def slip_to_roll(speed: float, friction: float, gravity: float) -> SlipToRoll:
    """Return 2 u0 / (7 mu g) and 5/7 u0 of a sphere that starts without rotation.

    u = u0 - mu g t and r omega = 5/2 mu g t meet there; the speed does not depend on mu.
    """
    return SlipToRoll(2.0 * speed / (7.0 * friction * gravity), 5.0 / 7.0 * speed)


def rolling_deceleration(rolling_friction: float, radius: float, gravity: float) -> float:
    """Return by how much omega falls in a second [rad/s2] while rolling: 5/7 mu_r g / r.

    The resisting torque is mu_r r m g (mu_r a number; R* = r on a plane). Friction at the contact
    bears 5/7 mu_r m g, which mu must allow.
    """
    return 5.0 / 7.0 * rolling_friction * gravity / radius


DETACHMENT_VELOCITY = float(chain.grain_velocity(chain.DETACHMENT_TAU))  # -0.1322795
FIRST_CONTACT_RATIO = (1 - DETACHMENT_VELOCITY) / 2  # 0.5661397 of 2 m v0


def static_overlaps(
    contacts: int, mass: float, gravity: float, stiffness: float, deformable: bool
) -> Floats:
    """Return how much closer than touching the centres are at rest (n,) [m].

    Overlap law: weight/k. Deformable law: contact i shares its particles with
    its neighbours, ``2 i m g/k``, and ``(3n - 1)/2 m g/k`` at the base, which
    has none below; one contact alone has ``m g/k``.
    """
    unit = mass * gravity / stiffness
    i = np.arange(1.0, contacts + 1)
    if not deformable or contacts == 1:
        return np.asarray(i * unit)
    overlaps = 2.0 * i * unit
    overlaps[-1] = (3 * contacts - 1) / 2 * unit
    return overlaps


def overlap_modes(mobile: int, omega: float) -> Floats:
    """Return the angular frequencies of M mobile particles on a fixed base (M,) [rad/s].

    Overlap law, all touching: ``2 omega sin((2j-1) pi / (2 (2M+1)))``.
    """
    j = np.arange(1.0, mobile + 1)
    return np.asarray(2 * omega * np.sin((2 * j - 1) * math.pi / (2 * (2 * mobile + 1))))


def contact_time_of_gamma(gamma: float) -> float:
    """Return omega t0 [1] of a grain on one fixed particle, ``2 (pi - atan(1/Gamma))``.

    ``Gamma = m g / (v0 sqrt(k m))``; pi without gravity.
    """
    return 2 * (math.pi - math.atan2(1.0, gamma))


def impulse_of_gamma(gamma: float) -> float:
    """Return the impulse of that contact [1], in m v0: ``2 + Gamma omega t0``."""
    return 2 + gamma * contact_time_of_gamma(gamma)


def velocities_after(mass: tuple[float, float], speed: float) -> tuple[float, float]:
    """Return the velocities after a free elastic collision with a sphere at rest [m/s]."""
    first, second = mass
    total = first + second
    return (first - second) / total * speed, 2 * first / total * speed


def displacement_on_fixed(
    mass: float, stiffness: float, speed: float, gravity: float, time: float
) -> float:
    """Return how far the grain has moved after ``time`` [s] of that contact [m]."""
    omega = math.sqrt(stiffness / mass)
    rest = gravity / omega**2
    return rest * (1 - math.cos(omega * time)) + speed / omega * math.sin(omega * time)


def stacked_motion(
    times: ArrayLike,
    start: ArrayLike,
    masses: ArrayLike,
    radii: ArrayLike,
    plates: tuple[float, float],
    contact: tuple[float, ArrayLike, float],
) -> tuple[Floats, Floats]:
    """Return heights and velocities of the spheres, (times, spheres) [m, m/s], from rest.

    ``start``: heights [m], from below; ``plates``: heights of the lower and the upper one [m];
    ``contact``: stiffness [N/m], dashpots [kg/s] of the contacts from below (one more than
    spheres) and gravity [m/s2].
    """
    mass, radius, place = (np.asarray(values, dtype=float) for values in (masses, radii, start))
    stiffness, dashpots, gravity = contact
    size = len(mass)
    # overlaps = ahead - difference @ heights, for the contacts from below
    difference = np.vstack([np.eye(size), np.zeros(size)]) - np.eye(size + 1, size, -1)
    ahead = np.append(radius, 0.0) + np.insert(radius, 0, 0.0)
    ahead[0] += plates[0]
    ahead[-1] -= plates[1]
    eta = np.asarray(dashpots, dtype=float)[:, None]
    rates = np.zeros((2 * size + 1, 2 * size + 1))
    rates[:size, size:-1] = np.eye(size)
    rates[size:-1, :size] = -(difference.T * stiffness) @ difference / mass[:, None]
    rates[size:-1, size:-1] = -difference.T @ (eta * difference) / mass[:, None]
    rates[size:-1, -1] = difference.T @ (stiffness * ahead) / mass - gravity
    first = np.concatenate([place, np.zeros(size), [1.0]])
    states = np.array([expm(rates * time) @ first for time in np.atleast_1d(times)])
    return states[:, :size], states[:, size:-1]


def peak_force_on_fixed(mass: float, stiffness: float, speed: float, gravity: float) -> float:
    """Return the largest force [N] on one fixed particle, m g + sqrt((m g)^2 + k m v0^2)."""
    weight = mass * gravity
    return weight + math.sqrt(weight**2 + stiffness * mass * speed**2)


def relaxation(damping_coefficient: float, mass: float, radius: float, coefficient: float) -> float:
    """Return A [s] of a dashpot eta_n = eta_0 m* a, a^2 = R* overlap: eta_0 m* sqrt(R*) / K.

    ``harness.theory.contact.impact`` takes A v / overlap and returns the restitution.
    """
    return damping_coefficient * mass * math.sqrt(radius) / coefficient


def sliding_impulse(friction: float, restitution: float, speed: float) -> float:
    """Return the tangential impulse over m* [m/s] of an impact that slides: mu (1 + e) v.

    A sphere on a wall loses that much tangential velocity, and 5/2 of it is its change of r omega.
    """
    return friction * (1.0 + restitution) * speed


def slides_throughout(friction: float, restitution: float) -> float:
    """Return u / v from which on a rigid contact slides to its end: 7/2 mu (1 + e)."""
    return 3.5 * friction * (1.0 + restitution)
