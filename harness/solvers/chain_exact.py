"""The exact propagator of a chain: modes between changes of contact, and roots where these are.

There is no step: what remains is rounding, which each change of contacts magnifies, as in any chain
of collisions. The cost is an eigenvalue problem for each change, O(L^3) in the runs of L touching
particles, and O(L^2) for each sample; a few hundred particles are the practical limit.

Each run of closed contacts swings by itself, M u'' = M g - K u. With the eigenvectors of
M^(-1/2) K M^(-1/2) every coordinate is a harmonic about its equilibrium; the rigid mode of a run
without the fixed base falls.
"""

from __future__ import annotations

import math
import time
from typing import NamedTuple

import numpy as np

from harness.compiled import compiled, shielded
from harness.errors import RequestError
from harness.model.scene import Floats
from harness.solvers.chain import (
    Chain,
    ChainMotion,
    Flags,
    Progress,
    factorise,
    solve,
    substitute,
)
from harness.solvers.kernels import first_root

MOST_PARTICLES = 5000  # the modes take 8 bytes for each pair of particles
SLACK = 1e-13  # a contact changes this far below 0 [scale of displacements], above rounding
ORDER = 22
REACH = 1.5  # of a Taylor series, in 1 / highest frequency: 1.5^23/23! = 4e-19
TURN_HALVINGS = 60
SLICE_SECONDS = 0.3  # between two looks for an interrupt


def run(
    chain: Chain, duration: float, *, samples: int, progress: Progress = lambda *_: None
) -> ChainMotion:
    """Return the motion of a chain for ``duration`` [s].

    There are ``samples`` at equal distances, one at each change of contacts, and one whenever the
    distance of the grain and the last particle turns. Raise RequestError for too many particles,
    and where rounding leaves open which contacts touch.
    """
    if chain.mass.size > MOST_PARTICLES:
        raise RequestError(
            f"height = {chain.mass.size - 1}: must be less than {MOST_PARTICLES} for the exact "
            "solver"
        )
    propagator = _Propagator(chain, duration, samples)
    while propagator.time < duration:
        shielded(propagator.advance)
        progress(propagator.sampled, samples)
    return propagator.motion()


class _Propagator:
    """A chain on its way from one change of contacts to the next."""

    def __init__(self, chain: Chain, duration: float, samples: int) -> None:
        self._chain, self._duration, self._samples = chain, duration, samples
        self._u, self._v = chain.displacement.copy(), chain.velocity.copy()
        self.time, self.sampled, self._in_no_time = 0.0, 0, 0
        self._closed = self._u[:-1] - self._u[1:] > SLACK * chain.length
        self._factor = np.zeros((3, self._closed.size))
        self._parts: list[tuple[Floats, Floats, Floats, Floats]] = []

    def advance(self) -> None:
        """Go from change to change, to the end or until an interrupt is looked for."""
        started = time.monotonic()
        while self.time < self._duration and time.monotonic() - started < SLICE_SECONDS:
            slack = SLACK * max(self._chain.length, float(np.abs(self._u).max()))
            self._settle(slack)
            modes = find_modes(self._chain, self._closed, self._factor, self._u, self._v)
            changed, lasted, turns = self._find_change(modes, slack)
            self._keep(modes, lasted, turns)
            self._u, self._v = modes.at_one(lasted)
            self.time = self._duration if changed < 0 else self.time + lasted
            # many changes in no time, to rounding, would never end
            self._in_no_time = self._in_no_time + 1 if lasted * modes.highest < 1e-9 else 0
            if changed >= 0:
                self._closed[changed] = not self._closed[changed]

    def motion(self) -> ChainMotion:
        """Return the motion at the samples so far, and now."""
        self._append(np.array([self.time]), self._u[None], self._v[None])
        time, u, v, force = (np.concatenate(part) for part in zip(*self._parts, strict=True))
        return ChainMotion(
            chain=self._chain, time=time, displacements=u, velocities=v, forces=force
        )

    def _settle(self, slack: float) -> None:
        """Bring the contact set up to date; raise RequestError where rounding hides it."""
        law, overlap = (self._chain.diagonal, self._chain.coupling), self._u[:-1] - self._u[1:]
        factorise(self._closed, *law, self._factor)
        # stricter than what the search allows: the new set is not at its own edge
        force = np.empty_like(overlap)
        solved = solve(overlap, *law, self._closed, self._factor, force, 0.25 * slack)
        if not solved or self._in_no_time > 4 * overlap.size + 16:
            raise RequestError(
                f"duration = {self._duration:.6g} s: which of {self._u.size} particles touch is "
                "below rounding before that: take a shorter run, or rk4"
            )

    def _find_change(self, modes: Modes, slack: float) -> tuple[int, float, list[float]]:
        """Return the contact that changes first, -1 for none, and when [s] from now.

        And when the distance of grain and base turns before [s].
        """
        x, w, local, turns = self._u, self._v, 0.0, []
        remaining = self._duration - self.time
        while True:
            reach = remaining - local
            if modes.highest > 0:
                reach = min(reach, REACH / modes.highest)
            changed, root = next_change(self._chain, self._closed, self._factor, x, w, reach, slack)
            until = local + reach * root
            before = w[0] - w[-1]
            x, w = modes.at_one(until)
            if before * (w[0] - w[-1]) < 0:
                turns.append(modes.turn(local, until, before))
            if changed >= 0:
                return changed, until, turns
            if until >= remaining * (1 - 1e-14):
                return -1, remaining, turns
            local = until

    def _keep(self, modes: Modes, lasted: float, turns: list[float]) -> None:
        """Keep the samples from now on, before the next change."""
        spacing, first = self._duration / self._samples, self.sampled + 1
        beyond = math.ceil((self.time + lasted) / spacing)
        # a sample on the change itself belongs to what follows
        numbers = np.arange(first, min(max(beyond, first), self._samples))
        self.sampled += numbers.size
        times = np.sort(np.concatenate(([0.0], numbers * spacing - self.time, turns)))
        self._append(self.time + times, *modes.at(times))

    def _append(self, times: Floats, u: Floats, v: Floats) -> None:
        force = np.empty((times.size, self._closed.size))
        _substitute_rows(u[:, :-1] - u[:, 1:], self._factor, force)
        self._parts.append((times, u, v, force))


@compiled
def _substitute_rows(overlap: Floats, factor: Floats, force: Floats) -> None:
    for row in range(len(overlap)):
        substitute(overlap[row], factor, force[row])


# ---- modes: the motion while the contacts stay, in closed form


class Modes(NamedTuple):
    """Normal modes: shapes in coordinates sqrt(m) u, and their state at the last change.

    The frequency is 0 of a rigid mode and of the fixed particle; ``rest`` is the equilibrium of the
    others, ``pull`` the acceleration by gravity.
    """

    shapes: Floats  # (N, N), a mode in a column
    frequency: Floats  # (N,) [rad/s]
    place: Floats  # (N,)
    rate: Floats  # (N,)
    pull: Floats  # (N,)
    origin: Floats  # (N,) [m] from which displacements are measured
    root_mass: Floats  # (N,)

    @property
    def highest(self) -> float:
        """Return the highest frequency [rad/s], 0 where nothing touches."""
        return float(self.frequency.max())

    def at(self, times: Floats) -> tuple[Floats, Floats]:
        """Return displacements and velocities (T, N) at times (T,) [s] after the change."""
        place, rate = _coordinates(times, self.frequency, self.place, self.rate, self.pull)
        u = self.origin + place @ self.shapes.T / self.root_mass
        return u, rate @ self.shapes.T / self.root_mass

    def at_one(self, time: float) -> tuple[Floats, Floats]:
        """Return displacements and velocities (N,) at a time [s] after the change."""
        u, v = self.at(np.array([time]))
        return u[0], v[0]

    def turn(self, low: float, high: float, before: float) -> float:
        """Return when the distance of the first and the last particle turns [s], by bisection."""
        for _ in range(TURN_HALVINGS):
            middle = 0.5 * (low + high)
            v = self.at_one(middle)[1]
            low, high = (middle, high) if before * (v[0] - v[-1]) > 0 else (low, middle)
        return 0.5 * (low + high)


@compiled
def _coordinates(
    times: Floats, frequency: Floats, place: Floats, rate: Floats, pull: Floats
) -> tuple[Floats, Floats]:
    """Return all modes and their rates (T, N) at times (T,): a mode swings, or falls."""
    places = np.empty((times.size, frequency.size))
    rates = np.empty_like(places)
    for j, omega in enumerate(frequency):
        for i, t in enumerate(times):
            if omega > 0:
                rest = pull[j] / omega**2
                away, cosine, sine = place[j] - rest, math.cos(omega * t), math.sin(omega * t)
                places[i, j] = rest + away * cosine + rate[j] / omega * sine
                rates[i, j] = rate[j] * cosine - away * omega * sine
            else:
                places[i, j] = place[j] + t * (rate[j] + 0.5 * pull[j] * t)
                rates[i, j] = rate[j] + pull[j] * t
    return places, rates


def find_modes(chain: Chain, closed: Flags, factor: Floats, u: Floats, v: Floats) -> Modes:
    """Return the modes of a contact set with its factors, in the state ``u`` and ``v`` (N,)."""
    # particles alone fall: a mode each
    shapes, (frequency, origin) = np.eye(u.size), np.zeros((2, u.size))
    edges = np.flatnonzero(np.diff(np.concatenate(([False], closed, [False]))))
    for begin, last in edges.reshape(-1, 2):
        fixed = chain.mobility[last] == 0
        if fixed:
            # a run that holds on to a fixed base is measured from where the base is
            origin[begin : last + 1] = u[-1]
        touching = slice(begin, last + (not fixed))
        frequency[touching], shapes[touching, touching] = _run_modes(
            chain, factor, begin, last, not fixed
        )
    if chain.mobility[-1] == 0:
        origin[-1] = u[-1]
    root = np.sqrt(chain.mass)
    place, rate, pull = (root * part @ shapes for part in (u - origin, v, chain.gravity))
    return Modes(shapes, frequency, place, rate, pull, origin, root)


def _run_modes(
    chain: Chain, factor: Floats, begin: int, last: int, free: bool
) -> tuple[Floats, Floats]:
    """Return frequencies [rad/s] and shapes of the mobile particles of a run."""
    contacts, mobile = last - begin, last - begin + free
    root = np.sqrt(chain.mass[begin : begin + mobile])
    # a row for each particle: the overlaps of its unit displacement
    overlap = np.eye(mobile, contacts) - np.eye(mobile, contacts, -1)
    force = np.empty_like(overlap)
    _substitute_rows(overlap, np.ascontiguousarray(factor[:, begin:last]), force)
    stiffness = force @ overlap.T / np.outer(root, root)
    values, vectors = np.linalg.eigh(0.5 * (stiffness + stiffness.T))
    if free:
        values[0], vectors[:, 0] = 0.0, root / np.linalg.norm(root)
    return np.sqrt(np.maximum(values, 0.0)), vectors


# ---- the first change of contacts: the first root of polynomials
#
# Within a time of about 1 / highest frequency the Taylor series of every contact force and every
# gap is exact to rounding. In the Bernstein basis a polynomial without a sign change among its
# coefficients has no root in the interval (Descartes); halving the interval until that is so,
# always looking at the earlier half first, cannot miss the first root, be it simple, double or one
# of a close pair (Lane and Riesenfeld 1981).


@compiled
def next_change(
    chain: Chain, closed: Flags, factor: Floats, u: Floats, v: Floats, reach: float, slack: float
) -> tuple[int, float]:
    """Return the contact that changes first within ``reach`` [s] and when, as a part of it.

    Return -1 and 1 if none does.
    """
    series = taylor_series(chain, closed, factor, u, v, reach)
    changed, root = -1, 1.0
    for i in range(closed.size):
        place = first_root(series[i], slack, root)
        if place < root:
            changed, root = i, place
    return changed, root


@compiled
def taylor_series(
    chain: Chain, closed: Flags, factor: Floats, u: Floats, v: Floats, reach: float
) -> Floats:
    """Return the Taylor coefficients (n, ORDER + 1) [m] of every contact, in units of ``reach``.

    Of a closed contact those of its force times ``diagonal``, of an open one of its gap; both
    vanish where the contact changes. From the force of derivative m follows derivative m + 2 of
    the displacement.
    """
    particles, n = u.size, u.size - 1
    series = np.empty((n, ORDER + 1))
    even, odd = u.copy(), v * reach
    overlap, force = np.empty(n), np.empty(n)
    for order in range(ORDER + 1):
        now = even if order % 2 == 0 else odd
        for i in range(n):
            overlap[i] = now[i] - now[i + 1]
        substitute(overlap, factor, force)
        for i in range(n):
            if closed[i]:
                series[i, order] = chain.diagonal[i] * force[i]
            else:
                gap = -overlap[i]
                if i > 0:
                    gap += chain.coupling[i - 1] * force[i - 1]
                if i < n - 1:
                    gap += chain.coupling[i] * force[i + 1]
                series[i, order] = gap
        scale = reach * reach / ((order + 1) * (order + 2))
        for i in range(particles):
            push = force[i - 1] if i > 0 else 0.0
            pull = force[i] if i < n else 0.0
            fall = chain.gravity[i] if order == 0 else 0.0
            now[i] = scale * ((push - pull) * chain.mobility[i] + fall)
    return series
