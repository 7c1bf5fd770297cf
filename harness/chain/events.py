"""Find the first change of contacts as the first root of polynomials.

Within a time of about ``1 / highest frequency`` the Taylor series of every contact
force and every gap is exact to rounding. In the Bernstein basis a polynomial
without a sign change among its coefficients has no root in the interval
(Descartes); halving the interval until that is so, always looking at the
earlier half first, cannot miss the first root, be it simple, double or one of a
close pair (Lane and Riesenfeld 1981).
"""

from __future__ import annotations

import numpy as np

from harness.chain.arrays import Chain, Floats
from harness.chain.compiled import compiled
from harness.chain.complementarity import Flags, substitute

ORDER = 22
REACH = 1.5  # of a segment, in 1 / highest frequency: 1.5^23/23! = 4e-19
_HALVINGS = 60


@compiled
def taylor_of_contacts(
    chain: Chain, closed: Flags, factor: Floats, u: Floats, v: Floats, reach: float,
    series: Floats,
) -> None:  # fmt: skip
    """Set the Taylor coefficients of every contact, in units of ``reach`` [s].

    ``series`` (n, ORDER + 1) [m]: of a closed contact its force times
    ``diagonal``, of an open one its gap; both vanish where the contact changes.
    From the force of derivative m follows derivative m + 2 of the displacement.
    """
    particles = u.size
    n = particles - 1
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
                    gap += chain.beside[i - 1] * force[i - 1]
                if i < n - 1:
                    gap += chain.beside[i] * force[i + 1]
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
def _halve(now: Floats, left: Floats) -> None:
    """Split at the middle (de Casteljau): ``left`` takes the first half, ``now`` the second."""
    degree = now.size - 1
    for level in range(degree + 1):
        left[level] = now[0]
        for k in range(degree - level):
            now[k] = 0.5 * (now[k] + now[k + 1])
