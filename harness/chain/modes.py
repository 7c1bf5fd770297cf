"""Modes of a chain whose contacts stay as they are: its motion in closed form.

Each run of closed contacts swings by itself, ``M u'' = M g - K u``. With the
eigenvectors of ``M^(-1/2) K M^(-1/2)`` every coordinate is a harmonic about its
equilibrium; the one rigid mode of a run without the fixed base falls.
"""

from __future__ import annotations

import math

import numpy as np

from harness.chain.arrays import Chain, Floats
from harness.chain.compiled import compiled
from harness.chain.complementarity import Flags, substitute


@compiled
def decompose(
    chain: Chain, closed: Flags, factor: Floats, shapes: Floats, frequency: Floats, first: Floats
) -> float:
    """Find the modes of the contact set; return the highest frequency [rad/s].

    ``shapes`` (N, N) takes the mode j of each run in column j, in coordinates
    ``sqrt(m) u``; ``frequency`` (N,) [rad/s], 0 for rigid modes and for a fixed
    particle, and ``first`` (N,) the first particle of the run of each mode.
    """
    particles = chain.displacement.size
    shapes[:] = 0.0
    highest = 0.0
    begin = 0
    while begin < particles:
        end = begin + 1
        while end < particles and closed[end - 1]:
            end += 1
        mobile = end - begin - (1 if chain.mobility[end - 1] == 0 else 0)
        first[begin:end] = begin
        frequency[begin:end] = 0.0
        if mobile:
            free = mobile == end - begin
            _run_modes(chain, factor, begin, mobile, free, shapes, frequency)
            highest = max(highest, frequency[begin + mobile - 1])
        begin = end
    return highest


@compiled
def _run_modes(
    chain: Chain, factor: Floats, begin: int, mobile: int, free: bool,
    shapes: Floats, frequency: Floats,
) -> None:  # fmt: skip
    """Write the modes of the ``mobile`` particles from ``begin`` on."""
    end = begin + mobile
    root = np.sqrt(chain.mass[begin:end])
    if mobile == 1 and free:
        shapes[begin, begin] = 1.0
        return
    values, vectors = np.linalg.eigh(_dynamical_matrix(factor, begin, mobile, free, root))
    if free:
        values[0] = 0.0
        vectors[:, 0] = root / math.sqrt(np.sum(root * root))
    for j in range(mobile):
        frequency[begin + j] = math.sqrt(max(values[j], 0.0))
        for i in range(mobile):
            shapes[begin + i, begin + j] = vectors[i, j]


@compiled
def _dynamical_matrix(factor: Floats, begin: int, mobile: int, free: bool, root: Floats) -> Floats:
    """Return ``M^(-1/2) K M^(-1/2)`` of a run: forces of unit displacements, by columns."""
    contacts = mobile - 1 if free else mobile
    pivots = np.ascontiguousarray(factor[:, begin : begin + contacts])
    matrix = np.zeros((mobile, mobile))
    overlap, force = np.zeros(contacts), np.zeros(contacts)
    for j in range(mobile):
        overlap[:] = 0.0
        if j < contacts:
            overlap[j] = 1.0
        if j > 0:
            overlap[j - 1] = -1.0
        substitute(overlap, pivots, force)
        for i in range(mobile):
            push = force[i - 1] if i > 0 else 0.0
            pull = force[i] if i < contacts else 0.0
            matrix[i, j] = (pull - push) / (root[i] * root[j])
    return 0.5 * (matrix + matrix.T)


@compiled
def project(
    chain: Chain, closed: Flags, shapes: Floats, frequency: Floats, first: Floats,
    amplitudes: Floats,
) -> None:  # fmt: skip
    """Set the ``amplitudes`` (4, N) of the modes from the state of ``chain``.

    Rows: coordinate and its rate now, acceleration of gravity, and equilibrium;
    of rigid modes the equilibrium is not used.
    """
    particles = chain.displacement.size
    u, v = chain.displacement, chain.velocity
    last = u[particles - 1] if chain.mobility[particles - 1] == 0 else 0.0
    for j in range(particles):
        y = rate = pull = 0.0
        # a run that holds on to a fixed base is measured from where the base is
        origin = _origin(closed, int(first[j]), last)
        for i in range(int(first[j]), particles):
            weight = shapes[i, j] * math.sqrt(chain.mass[i])
            y += weight * (u[i] - origin)
            rate += weight * v[i]
            pull += weight * chain.gravity[i]
            if i < particles - 1 and not closed[i]:
                break
        amplitudes[0, j], amplitudes[1, j], amplitudes[2, j] = y, rate, pull
        amplitudes[3, j] = pull / frequency[j] ** 2 if frequency[j] > 0 else 0.0


@compiled
def _origin(closed: Flags, begin: int, last: float) -> float:
    """Return ``last`` if the run from ``begin`` reaches the end of the chain, else 0."""
    for i in range(begin, closed.size):
        if not closed[i]:
            return 0.0
    return last


@compiled
def state_at(
    chain: Chain, closed: Flags, shapes: Floats, frequency: Floats,
    amplitudes: Floats, time: float, u: Floats, v: Floats,
) -> None:  # fmt: skip
    """Set ``u`` and ``v`` (N,) at ``time`` [s] after the amplitudes were taken."""
    particles = u.size
    last = chain.displacement[particles - 1] if chain.mobility[particles - 1] == 0 else 0.0
    y, rate = np.empty(particles), np.empty(particles)
    for j in range(particles):
        start, speed, pull, rest = amplitudes[:, j]
        if frequency[j] > 0:
            cosine, sine = math.cos(frequency[j] * time), math.sin(frequency[j] * time)
            y[j] = rest + (start - rest) * cosine + speed / frequency[j] * sine
            rate[j] = speed * cosine - (start - rest) * frequency[j] * sine
        else:
            y[j] = start + time * (speed + 0.5 * pull * time)
            rate[j] = speed + pull * time
    begin = 0
    while begin < particles:
        end = begin + 1
        while end < particles and closed[end - 1]:
            end += 1
        origin = _origin(closed, begin, last)
        for i in range(begin, end):
            place = motion = 0.0
            for j in range(begin, end):
                place += shapes[i, j] * y[j]
                motion += shapes[i, j] * rate[j]
            scale = 1 / math.sqrt(chain.mass[i])
            u[i] = origin + place * scale
            v[i] = motion * scale
        begin = end
    if chain.mobility[particles - 1] == 0:
        u[particles - 1], v[particles - 1] = last, 0.0
