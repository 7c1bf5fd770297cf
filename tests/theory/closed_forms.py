"""Closed forms that tests hold solvers and scenes against, and that no case needs."""

import cmath
import math

import numpy as np
from scipy.integrate import solve_ivp


def slid_over_sphere(theta, energy):
    """Integrate sliding over a sphere from well to well, from an energy in m g d behind its crest.

    ``theta`` [rad] is the slope; SciPy's solution holds the angle from the vertical and its rate.
    """

    def next_well(_, state):
        return state[0] - theta - math.pi / 6

    next_well.terminal = True
    start = [theta - math.pi / 6, math.sqrt(2 * energy)]
    return solve_ivp(lambda _, state: [state[1], math.sin(state[0])], (0.0, 100.0), start,
                     events=next_well, rtol=1e-11, atol=1e-12)  # fmt: skip


def static_overlaps(contacts, mass, gravity, stiffness, deformable):
    """Return how much closer than touching the centres are at rest (n,) [m].

    Overlap law: weight/k. Deformable law: contact i shares its particles with
    its neighbours, ``2 i m g/k``, and ``(3n - 1)/2 m g/k`` at the base, which
    has none below; one contact alone has ``m g/k``.
    """
    unit = mass * gravity / stiffness
    i = np.arange(1.0, contacts + 1)
    if not deformable or contacts == 1:
        return i * unit
    overlaps = 2.0 * i * unit
    overlaps[-1] = (3 * contacts - 1) / 2 * unit
    return overlaps


def overlap_modes(mobile, omega):
    """Return the angular frequencies of M mobile particles on a fixed base (M,) [rad/s].

    Overlap law, all touching: ``2 omega sin((2j-1) pi / (2 (2M+1)))``.
    """
    j = np.arange(1.0, mobile + 1)
    return 2 * omega * np.sin((2 * j - 1) * math.pi / (2 * (2 * mobile + 1)))


# ---- the head-on impact with Hertz's spring and a viscous dashpot, integrated
#
# In units of the largest overlap without damping, (5 m v^2 / 4 K)^(2/5), and of the speed v,
#
#     x'' = -5/4 (x^(3/2) + a sqrt(x) x'),   x(0) = 0,   x'(0) = 1,
#
# with the one parameter a = A v / overlap. (The viscous law: Brilliantov et al., Phys. Rev. E 53,
# 5382 (1996).) Its limits have closed forms. For a -> 0 the loss of first order is 1 - e = a
# B(3/5, 3/2), with Euler's beta function. For a -> infinity the dashpot alone stops the grain, x'
# = 1 - 5/6 a x^(3/2), at x = (6 / 5a)^(2/3). Clipped, it leaves at x' = -x/a where the force
# vanishes, hence e = (6/5)^(2/3) a^(-5/3). Unclipped it creeps, x' = -x/a, until its damping ratio
# (about a x^(1/4)) is no longer large, at x of order a^-4: e falls as a^-5.


def hertz_restitution(damping, *, clipped):
    """Return the restitution for a = A v / overlap.

    The impact ends where x = 0, clipped where the force does, x + a x' = 0.
    """

    def rates(_, state):
        x = max(state[0], 0.0)
        return state[1], -1.25 * math.sqrt(x) * (x + damping * state[1])

    def end(time, state):
        if time == 0.0:
            return 1.0
        return state[0] + damping * state[1] if clipped else state[0]

    end.terminal = True
    end.direction = -1
    longest = 100.0 + 10.0 * damping * (1.0 + math.log1p(damping))
    solution = solve_ivp(
        rates, (0.0, longest), (0.0, 1.0), "DOP853", rtol=1e-11, events=end,
        atol=1e-14 / (1.0 + damping) ** 5, max_step=0.1 * (1.0 + damping),
    )  # fmt: skip
    return -solution.y[1, -1]


def relaxation(damping_coefficient, mass, radius, coefficient):
    """Return A [s] of a dashpot eta_n = eta_0 m* a, a^2 = R* overlap: eta_0 m* sqrt(R*) / K."""
    return damping_coefficient * mass * math.sqrt(radius) / coefficient


# ---- the oblique impact of spheres that stick
#
# u is the tangential velocity at the contact; a tangential impulse J changes u by 7/2 J / m* of
# solid spheres, of any two masses and of a sphere on a wall alike.


def held(stiffness, dashpot, duration):
    """Return the tangential velocity at a contact that sticks throughout, after over before.

    ``stiffness`` 7/2 k_t / m* [1/s2] of the spring and ``dashpot`` 7/2 eta_t / m* [1/s], either of
    which may be 0: u'' + dashpot u' + stiffness u = 0 from a spring at rest, over the ``duration``
    [s] of the contact. Without a dashpot the cosine of Walton, in Particulate Two-Phase Flow
    (1993), and of Schaefer, Dippel and Wolf, J. Phys. I France 6, 5 (1996).
    """
    half = 0.5 * dashpot
    turning = cmath.sqrt(stiffness - half * half)
    phase = turning * duration
    swings = cmath.sin(phase) / turning if turning else duration
    return math.exp(-half * duration) * (cmath.cos(phase) - half * swings).real
