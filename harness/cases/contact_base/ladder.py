"""The limit of a small step: quantities of the same contact at several steps, extrapolated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from harness.cases.contact_base.motion import Array
from harness.cases.contract import LevelName
from harness.parameters.contact_law import ContactLaw

if TYPE_CHECKING:
    from harness.comparison.convergence import Limit

STEPS: Mapping[LevelName, tuple[int, ...]] = {
    "quick": (50, 100, 200, 400, 800),
    "default": (100, 200, 400, 800, 1600),
    "full": (100, 200, 400, 800, 1600, 3200, 6400),
}
"""Steps of the time that a contact takes, by level.

A contact begins half a step after the start and, the steps being parts of its own duration, ends
at the same phase of a step on every rung: what is left is a series in the step.
"""

RECORDED = 400
"""The rung that every level has: its values are those of the baseline."""

ROUND_OFF = 1e-13

MOST_POWERS = 3
"""That the five rungs of a ladder tell apart."""


def powers(law: ContactLaw, further: Sequence[float] = ()) -> tuple[float, ...]:
    """Return the lowest powers of the step h in the error of a law in a scheme.

    Those of velocity Verlet, and what ``further`` ones the scheme has.
    """
    return tuple(sorted({*further, *_powers(law)}))[:MOST_POWERS]


def _powers(law: ContactLaw) -> tuple[float, ...]:
    """Return the powers of the step h in the error of a law, integrated by velocity Verlet.

    The scheme is of second order, but a dashpot is given the velocity of half a step before: first
    order. A force that begins as overlap^q is missed or counted for part of a step, at a rate of
    h^(1 + q): q is 0 for a constant dashpot, 1/4 for one of constant restitution with Hertz's
    spring and one that goes with the root of mdr's stiffness, 1/2 for one that goes with the
    contact radius, and 3/2 for Hertz's spring. The contact of jkr begins and ends with an area: its
    forces are smooth in between, and jump.

    What mdr remembers follows the motion by steps: the radius of a sphere that yields lags behind
    it by the ten steps that LAMMPS averages its growth over, the area that the bulk responds to by
    one; and the first step of a contact, which precedes that, is left to the elastic branch.

    A tangential spring that is held as a force, or rescaled, takes the slip of a whole step by the
    contact radius at its end: first order, also without a dashpot and along a given motion.
    """
    if law.normal == "jkr" or (law.yield_stress is not None and not law.bulk_response):
        return (1.0, 2.0, 3.0)
    if law.bulk_response or law.damping == "viscoelastic" or law.surface_energy is not None:
        return (1.0, 1.5, 2.0)
    if law.damping == "none" and law.tangential.endswith(("/force", "_rescale")):
        return (1.0, 1.5, 2.0)
    if law.damping == "none":
        return (2.0, 3.0) if law.normal == "hooke" else (2.0, 2.5, 3.0)
    if law.normal == "hooke":
        return (1.0, 2.0, 3.0)
    if law.damping in ("velocity", "mass_velocity"):
        return (1.0, 2.0, 2.5)
    return (1.0, 1.25, 2.0)


def climb(
    terms: Sequence[float],
    steps: Sequence[int],
    rungs: Sequence[Mapping[str, float]],
    *,
    kinked: bool,
    jumps: bool = False,
    known: int = 1,
) -> dict[str, Limit]:
    """Return the limit of each quantity that every rung has, finite, by its name.

    ``terms`` are the powers of the step in the error, as :func:`powers` gives them.

    A kink (sliding begins, a force is clipped) falls at another phase of a step on every rung: the
    error that this leaves goes with the step squared, rungs weigh accordingly, and only
    the first power is told apart, or as many as are ``known`` where the motion up to it has none.
    Where the force ``jumps`` there, it goes with the step. Else the series holds on all rungs.
    """
    h = 1.0 / np.asarray(steps, dtype=float)
    terms = (1.0, *(p for p in terms if p > 1.0))[:known] if kinked else terms
    weights = (h / h[-1]) ** (1 if jumps else 2) if kinked else np.ones_like(h)
    found = {}
    for name in rungs[0]:
        y = np.array([one.get(name, np.nan) for one in rungs])
        if np.isfinite(y).all():
            found[name] = _limit(h, y, weights, terms)
    return found


def _limit(h: Array, y: Array, weights: Array, terms: Sequence[float]) -> Limit:
    """Return the limit; the error of a rung is how far the series misses it, times its weight."""
    from harness.comparison.convergence import limit

    scale = float(np.abs(y).max()) or 1.0
    columns = np.column_stack([np.ones_like(h), *(h**p for p in terms)])
    series = np.linalg.lstsq(columns / weights[:, None], y / scale / weights, rcond=None)[0]
    missed = float(np.abs((columns @ series - y / scale) / weights).max())
    return limit(h, y, scale * max(missed, ROUND_OFF) * weights, terms)
