"""Largest stable step of RK4, and the step that is chosen."""

from __future__ import annotations

import math
from itertools import pairwise

from harness.errors import RequestError
from harness.parameters.tower import Tower

RK4_IMAGINARY_LIMIT = 2 * math.sqrt(2)
DEFAULT_STEPS_PER_CONTACT = 4000.0


def highest_frequency(tower: Tower, longest_chain: int | None = None) -> float:
    """Return an upper bound of the angular frequencies of any contact set [rad/s].

    Overlap law, from the row sums of M^-1 K: ``2 omega`` for equal particles,
    whatever their number. Deformable law: ``K = D A^-1 D^T`` and
    ``A >= T / max k``, whose lowest eigenvalue in a chain of L touching contacts is
    ``2 sin^2(pi / (2(L+1)))``; so ``sqrt(2) omega / sin(pi / (2(L+1)))``, which
    grows with the length. ``longest_chain`` is L, all contacts if not given.
    """
    stiffness, mass = tower.each("stiffness"), tower.each("mass")
    if tower.law == "overlap":
        contact = [0.0, *(2 / (1 / a + 1 / b) for a, b in pairwise(stiffness)), 0.0]
        rows = zip(pairwise(contact), mass, strict=True)
        return math.sqrt(max(2 * (left + right) / m for (left, right), m in rows))
    length = tower.height if longest_chain is None else min(longest_chain, tower.height)
    softest = 2 * math.sin(math.pi / (2 * (length + 1))) ** 2
    return math.sqrt(4 * max(stiffness) / (min(mass) * softest))


def largest_step(tower: Tower, longest_chain: int | None = None) -> float:
    """Return the largest stable step of RK4 [s], ``2 sqrt(2) / highest frequency``."""
    return RK4_IMAGINARY_LIMIT / highest_frequency(tower, longest_chain)


def chosen_step(
    tower: Tower,
    step: float | None = None,
    steps_per_contact: float | None = None,
    longest_chain: int | None = None,
) -> float:
    """Return the step [s]: as given, or 4000 per contact time pi sqrt(m/k).

    Without a request it is at most half the largest stable one. Raise
    RequestError, naming the bound, for a step that is not positive or not stable.
    """
    bound = largest_step(tower, longest_chain)
    if step is None and steps_per_contact is None:
        return min(tower.contact_period / DEFAULT_STEPS_PER_CONTACT, 0.5 * bound)
    if step is not None and steps_per_contact is not None:
        raise RequestError(
            f"step = {step} s and steps_per_contact = {steps_per_contact}: give one of them"
        )
    if steps_per_contact is not None:
        least = tower.contact_period / bound
        if not (math.isfinite(steps_per_contact) and steps_per_contact > least):
            raise RequestError(
                f"steps_per_contact = {steps_per_contact}: must be greater than {least:.6g}, "
                f"where RK4 becomes unstable ({tower.law} law, {_chain(tower, longest_chain)})"
            )
        return tower.contact_period / steps_per_contact
    if step is None or not (0 < step < bound):
        raise RequestError(
            f"step = {step} s: must be greater than 0 and less than {bound:.6g} s, "
            f"where RK4 becomes unstable ({tower.law} law, {_chain(tower, longest_chain)})"
        )
    return step


def _chain(tower: Tower, longest_chain: int | None) -> str:
    contacts = tower.height if longest_chain is None else min(longest_chain, tower.height)
    return f"{contacts} touching contact{'s' if contacts > 1 else ''}"
