"""The exact propagator of a chain: modes between changes of contact, which are located.

No step and no error of one: what remains is rounding. The cost is that of an eigenvalue problem for
each change of contacts, O(L^3) in the runs of L touching particles, and O(L^2) for each sample; a
few hundred particles are the practical limit. RK4 is the one for long chains. Each change of
contacts magnifies the rounding of what came before it, as in any chain of collisions.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from harness.compiled import shielded
from harness.errors import RequestError
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower
from harness.solvers.chain.forces import Flags, solve, substitute
from harness.solvers.chain.motion import (
    Chain,
    Counts,
    Floats,
    Progress,
    Record,
    as_run,
    assemble,
    blank_record,
    compiled,
    wanted_samples,
    with_room,
    write_sample,
)

ORDER = 22
REACH = 1.5  # of a segment, in 1 / highest frequency: 1.5^23/23! = 4e-19
_HALVINGS = 60


class ModalState(NamedTuple):
    """The motion between two changes of contact: the contact set, its forces and its modes.

    A mode has its shape in coordinates ``sqrt(m) u`` in a column of ``shapes``, the frequency 0 if
    it is rigid or of a fixed particle, and the rows of ``amplitudes``: coordinate and its rate now,
    acceleration of gravity, and equilibrium, which a rigid one does not use.
    """

    closed: Flags  # (n,)
    factor: Floats  # (3, n)
    overlap: Floats  # (n,) [m]
    force: Floats  # (n,) [N]
    shapes: Floats  # (N, N)
    frequency: Floats  # (N,) [rad/s]
    first: Floats  # (N,) first particle of the run of each mode
    amplitudes: Floats  # (4, N)
    series: Floats  # (n, ORDER + 1)
    x: Floats  # (N,) [m] where the search for the next change stands
    w: Floats  # (N,) [m/s]
    y: Floats  # (N,) [m] at a sample
    z: Floats  # (N,) [m/s]
    counts: Counts  # rows of the record, samples, changes in no time
    time: Floats  # (1,) [s] of the last change


def modal_state(chain: Chain, closed: Flags) -> ModalState:
    """Return the arrays of a chain at its start, with the contacts (n,) that are ``closed``."""
    u, v = chain.displacement, chain.velocity
    particles, n = u.size, u.size - 1
    return ModalState(
        closed, np.zeros((3, n)), np.zeros(n), np.zeros(n),
        np.zeros((particles, particles)), np.zeros(particles), np.zeros(particles),
        np.zeros((4, particles)), np.zeros((n, ORDER + 1)),
        u.copy(), v.copy(), u.copy(), v.copy(), np.zeros(3, np.int64), np.zeros(1),
    )  # fmt: skip


# ---- modes: the motion of a chain whose contacts stay, in closed form
#
# Each run of closed contacts swings by itself, M u'' = M g - K u. With the eigenvectors of
# M^(-1/2) K M^(-1/2) every coordinate is a harmonic about its equilibrium; the one rigid mode of a
# run without the fixed base falls.


@compiled
def decompose(chain: Chain, state: ModalState) -> float:
    """Find the modes of the factorised contact set; return the highest frequency [rad/s]."""
    closed, shapes, frequency = state.closed, state.shapes, state.frequency
    particles = chain.displacement.size
    shapes[:] = 0.0
    highest = 0.0
    begin = 0
    while begin < particles:
        end = begin + 1
        while end < particles and closed[end - 1]:
            end += 1
        mobile = end - begin - (1 if chain.mobility[end - 1] == 0 else 0)
        state.first[begin:end] = begin
        frequency[begin:end] = 0.0
        if mobile:
            free = mobile == end - begin
            _run_modes(chain, state.factor, begin, mobile, free, shapes, frequency)
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
def project(chain: Chain, state: ModalState) -> None:
    """Set the amplitudes of the modes from the state of ``chain``."""
    closed, shapes, frequency = state.closed, state.shapes, state.frequency
    first, amplitudes = state.first, state.amplitudes
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
def state_at(chain: Chain, state: ModalState, time: float, u: Floats, v: Floats) -> None:
    """Set ``u`` and ``v`` (N,) at ``time`` [s] after the last change of contacts."""
    closed, shapes, frequency = state.closed, state.shapes, state.frequency
    amplitudes = state.amplitudes
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


# ---- the first change of contacts: the first root of polynomials
#
# Within a time of about 1 / highest frequency the Taylor series of every contact force and every
# gap is exact to rounding. In the Bernstein basis a polynomial without a sign change among its
# coefficients has no root in the interval (Descartes); halving the interval until that is so,
# always looking at the earlier half first, cannot miss the first root, be it simple, double or one
# of a close pair (Lane and Riesenfeld 1981).


@compiled
def taylor_of_contacts(chain: Chain, state: ModalState, reach: float) -> None:
    """Set the Taylor coefficients ``state.series`` [m] of every contact, in units of ``reach`` [s].

    Of a closed contact those of its force times ``diagonal``, of an open one of its gap; both
    vanish where the contact changes. From the force of derivative m follows derivative m + 2 of
    the displacement.
    """
    closed, series, u, v = state.closed, state.series, state.x, state.w
    particles = u.size
    n = particles - 1
    even, odd = u.copy(), v * reach
    overlap, force = np.empty(n), np.empty(n)
    for order in range(ORDER + 1):
        now = even if order % 2 == 0 else odd
        for i in range(n):
            overlap[i] = now[i] - now[i + 1]
        substitute(overlap, state.factor, force)
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


@compiled
def first_root(coefficients: Floats, shift: float, until: float) -> float:
    """Return the first root of ``shift + sum c_j s^j`` in [0, until], or 2 if there is none.

    ``until`` is at most 1. A value that is already negative at 0 counts as a
    root at 0.
    """
    rest = 0.0
    for j in range(1, coefficients.size):
        rest += abs(coefficients[j])
    if coefficients[0] + shift > rest:
        return 2.0
    if coefficients[0] + shift <= 0:
        return 0.0
    bernstein = _bernstein(coefficients, shift, until)
    low, width = 0.0, 1.0
    stack = np.empty((_HALVINGS + 2, coefficients.size))
    widths = np.empty(_HALVINGS + 2)
    depth = 0
    stack[0], widths[0] = bernstein, width
    while depth >= 0:
        width = widths[depth]
        now = stack[depth]
        if np.min(now) > 0:
            low += width
            depth -= 1
        elif width < 2.0 ** (-_HALVINGS + 8) or now[0] <= 0:
            return low * until
        else:
            _halve(now, stack[depth + 1])
            widths[depth] = widths[depth + 1] = 0.5 * width
            depth += 1
    return 2.0


@compiled
def _bernstein(coefficients: Floats, shift: float, until: float) -> Floats:
    """Return the Bernstein coefficients on [0, until] of a polynomial in powers."""
    degree = coefficients.size - 1
    result = coefficients.copy()
    result[0] += shift
    power = 1.0
    for j in range(degree + 1):
        result[j] *= power
        power *= until
    # b_k = sum_j C(k,j)/C(degree,j) c_j, by repeated summation
    binomial = 1.0
    for j in range(1, degree + 1):
        binomial *= (degree - j + 1) / j
        result[j] /= binomial
    for level in range(1, degree + 1):
        for k in range(degree, level - 1, -1):
            result[k] += result[k - 1]
    return result


@compiled
def _halve(now: Floats, half: Floats) -> None:
    """Split at the middle (de Casteljau): ``half`` takes the first half, ``now`` the second."""
    degree = now.size - 1
    for level in range(degree + 1):
        half[level] = now[0]
        for k in range(degree - level):
            now[k] = 0.5 * (now[k] + now[k + 1])


# ---- the propagator, from change to change


# a contact changes when its force or gap is this far below 0, as a part of the
# scale of displacements: above the rounding of the modes, below all else
_SLACK = 1e-13

_UNSETTLED = -2
"""In place of a contact that changes."""


MOST_PARTICLES = 5000
"""Of a tower: the modes take 8 bytes for each pair of particles."""

CUBES = 1e8
"""Particles to the third power, times changes of contact, between two looks for an interrupt."""


def run(
    tower: Tower,
    duration: float,
    *,
    samples: int | None = None,
    profiles: bool = False,
    progress: Progress = lambda *_: None,
) -> TowerRun:
    """Run ``tower`` for ``duration`` [s] and return its samples.

    There are ``samples`` at equal distances (1000 per t0 if not given), one at
    each change of contacts and one whenever the distance of grain and base turns. ``progress`` is
    called with the samples done and all of them. Raise RequestError for a duration or a number of
    particles out of range, and where rounding leaves open which contacts touch.
    """
    if not (math.isfinite(duration) and duration > 0):
        raise RequestError(f"duration = {duration} s: must be finite and greater than 0")
    if tower.particles > MOST_PARTICLES:
        raise RequestError(
            f"height = {tower.height}: must be less than {MOST_PARTICLES} for the exact solver"
        )
    wanted = wanted_samples(samples, duration / tower.contact_time)
    chain = assemble(tower)
    blank = blank_record(wanted + 64, tower.particles, profiles)
    record, rows = propagate(chain, blank, duration, wanted, progress)
    if rows < 0:
        raise RequestError(
            f"duration = {duration:.6g} s: which of {tower.particles} particles touch is below "
            "rounding before that: take a shorter run, or rk4"
        )
    order = np.argsort(record.rows[:rows, 0], kind="stable")
    sorted_record = Record(*(part[order] if part.shape[0] else part for part in record))
    return as_run(tower, "exact", None, sorted_record, rows, chain)


def propagate(
    chain: Chain,
    record: Record,
    duration: float,
    samples: int,
    progress: Progress = lambda *_: None,
) -> tuple[Record, int]:
    """Advance ``chain`` in place; return the record and its rows, -1 if no contact set is found."""
    u, v = chain.displacement, chain.velocity
    particles, state = u.size, modal_state(chain, u[:-1] - u[1:] > _SLACK * chain.length)
    changes, changed = math.ceil(CUBES / particles**3), 0
    while changed >= 0:
        record, changed = shielded(_advance, chain, state, record, duration, samples, changes)
        progress(int(state.counts[1]), samples)
    if changed == _UNSETTLED:
        return record, -1
    progress(samples, samples)
    return _sampled(chain, state, record, duration, u, v), int(state.counts[0])


@compiled
def _advance(
    chain: Chain, state: ModalState, record: Record, duration: float, samples: int, changes: int
) -> tuple[Record, int]:
    """Go through so many changes of contact; return the last contact that changed, -1 at the end.

    ``_UNSETTLED`` where contacts do not settle.
    """
    u, v = chain.displacement, chain.velocity
    closed, overlap, force, n = state.closed, state.overlap, state.force, u.size - 1
    changed = 0
    for _ in range(changes):
        for i in range(n):
            overlap[i] = u[i] - u[i + 1]
        slack = _SLACK * max(chain.length, np.max(np.abs(u)))
        # stricter than what the search allows: the new set is not at its own edge
        settled = solve(
            overlap, chain.diagonal, chain.coupling, closed, state.factor, force, 0.25 * slack
        )
        if settled < 0 or state.counts[2] > 4 * n + 16:
            return record, _UNSETTLED
        highest = decompose(chain, state)
        project(chain, state)
        record, time = with_room(record, state.counts[0]), state.time[0]
        write_sample(record, state.counts[0], time, chain, u, v, overlap, force)
        state.counts[0] += 1
        record, local, changed = _until_change(
            chain, state, record, time, duration, samples, slack, highest
        )
        u[:], v[:] = state.x, state.w
        state.time[0] = time + local
        if changed < 0:
            break
        # many changes in no time, to rounding, would never end
        state.counts[2] = state.counts[2] + 1 if local * highest < 1e-9 else 0
        closed[changed] = not closed[changed]
    return record, changed


@compiled
def _until_change(
    chain: Chain, state: ModalState, record: Record, time: float,
    duration: float, samples: int, slack: float, highest: float,
) -> tuple[Record, float, int]:  # fmt: skip
    """Move on from ``time`` [s] to the next change of contacts or the end, writing samples.

    Return the record, how long it took [s] and the contact that changes, -1 at the end.
    ``highest`` is the highest frequency [rad/s], 0 where nothing touches.
    """
    x, w, y, z, n = state.x, state.w, state.y, state.z, state.closed.size
    x[:], w[:] = chain.displacement, chain.velocity
    local, changed, ended = 0.0, -1, False
    while changed < 0 and not ended:
        reach = duration - time - local
        if highest > 0:
            reach = min(reach, REACH / highest)
        changed, root = _next_change(chain, state, reach, slack)
        until = local + reach * root
        ended = changed < 0 and time + until >= duration * (1 - 1e-14)
        if ended:
            until = duration - time
        before = w[0] - w[n]
        state_at(chain, state, until, x, w)
        if before * (w[0] - w[n]) < 0:
            at = _turn(chain, state, local, until)
            record = _sampled(chain, state, record, time + at, y, z)
        sample = state.counts[1]
        while (sample + 1) * duration / samples < time + until and sample + 1 < samples:
            sample += 1
            at = sample * duration / samples - time
            state_at(chain, state, at, y, z)
            record = _sampled(chain, state, record, time + at, y, z)
        state.counts[1] = sample
        local = until
    return record, local, changed


@compiled
def _sampled(
    chain: Chain, state: ModalState, record: Record, time: float, u: Floats, v: Floats
) -> Record:
    """Return the record with a sample of the state ``u`` and ``v`` (N,)."""
    row = state.counts[0]
    record = with_room(record, row)
    for i in range(state.overlap.size):
        state.overlap[i] = u[i] - u[i + 1]
    substitute(state.overlap, state.factor, state.force)
    write_sample(record, row, time, chain, u, v, state.overlap, state.force)
    state.counts[0] = row + 1
    return record


@compiled
def _next_change(chain: Chain, state: ModalState, reach: float, slack: float) -> tuple[int, float]:
    """Return the contact that changes first within ``reach`` [s] and when, as a part of it.

    Return -1 and 1 if none does.
    """
    taylor_of_contacts(chain, state, reach)
    changed, root = -1, 1.0
    for i in range(state.closed.size):
        place = first_root(state.series[i], slack, root)
        if place < root:
            changed, root = i, place
    return changed, root


@compiled
def _turn(chain: Chain, state: ModalState, low: float, high: float) -> float:
    """Return when, between ``low`` and ``high`` [s], the distance of grain and base turns.

    Leaves the state then in ``state.y`` and ``state.z``.
    """
    y, z, n = state.y, state.z, state.closed.size
    state_at(chain, state, low, y, z)
    sign = 1.0 if z[0] - z[n] > 0 else -1.0
    middle = low
    for _ in range(60):
        middle = 0.5 * (low + high)
        state_at(chain, state, middle, y, z)
        if sign * (z[0] - z[n]) > 0:
            low = middle
        else:
            high = middle
    return middle
