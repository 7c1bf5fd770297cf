"""The limit of a small step: quantities of the same contact at several steps, extrapolated."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.contact_base.motion import Array
from harness.cases.contract import LevelName
from harness.parameters.contact_law import ContactLaw

if TYPE_CHECKING:
    from harness.cases.contact_base.contact_case import ContactCase
    from harness.cases.contact_base.reference import Followed
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

FINEST: Mapping[LevelName, int] = {"quick": 25_600, "default": 51_200, "full": 204_800}
"""Up to which a step is halved while a limit is too uncertain for its verdict, by level."""

SECONDS: Mapping[LevelName, float] = {"quick": 10.0, "default": 20.0, "full": 60.0}
"""That a run may take for it, as an engine's cost estimates it."""

RECORDED = 400
"""The rung that every level has: its values are those of the baseline."""

ROUND_OFF = 1e-13

RESOLVED = 4.0
"""Steps of an interval between two switches whose error shows in the runs themselves."""

MOST_POWERS = 3
"""That the five rungs of a ladder tell apart."""


def powers(law: ContactLaw, further: Sequence[float] = ()) -> tuple[float, ...]:
    """Return the lowest powers of the step h in the error of a law in a scheme.

    Those of velocity Verlet, and what ``further`` ones the scheme has.
    """
    return tuple(sorted({*further, *_powers(law)}))[:MOST_POWERS]


def lasting_powers(law: ContactLaw, further: Sequence[float] = ()) -> tuple[float, ...]:
    """Return the lowest powers of the step where no contact begins or ends: forces are smooth.

    Velocity Verlet is even in the step without a dashpot and a spring that follows the motion by
    steps, and if the scheme has no ``further`` ones.
    """
    even = law.damping == "none" and not law.tangential_spring and not further
    return (2.0, 4.0, 6.0) if even else (1.0, 2.0, 3.0)


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
    bounds: Mapping[str, Array] | None = None,
) -> dict[str, Limit]:
    """Return the limit of each quantity that every rung has, finite, by its name.

    ``terms`` are the powers of the step in the error, as :func:`powers` gives them.

    A kink (sliding begins, a force is clipped) falls at another phase of a step on every rung: the
    error that this leaves goes with the step squared, rungs weigh accordingly, and only
    the first power is told apart, or as many as are ``known`` where the motion up to it has none.
    Where the force ``jumps`` there, it goes with the step. Else the series holds on all rungs.
    ``bounds`` are least errors of the rungs by the name of a quantity, as :func:`unresolved` gives
    them.
    """
    h = 1.0 / np.asarray(steps, dtype=float)
    terms = (1.0, *(p for p in terms if p > 1.0))[:known] if kinked else terms
    weights = (h / h[-1]) ** (1 if jumps else 2) if kinked else np.ones_like(h)
    found = {}
    for name in rungs[0]:
        y = np.array([one.get(name, np.nan) for one in rungs])
        if np.isfinite(y).all():
            least = (bounds or {}).get(name, np.zeros_like(h))
            found[name] = _limit(h, y, weights, terms, least)
    return found


def _limit(h: Array, y: Array, weights: Array, terms: Sequence[float], least: Array) -> Limit:
    """Return the limit; the error of a rung is how far the series misses it, times its weight.

    It is no smaller than the ``least`` errors.
    """
    from harness.comparison.convergence import limit

    scale = float(np.abs(y).max()) or 1.0
    columns = np.column_stack([np.ones_like(h), *(h**p for p in terms)])
    series = np.linalg.lstsq(columns / weights[:, None], y / scale / weights, rcond=None)[0]
    missed = float(np.abs((columns @ series - y / scale) / weights).max())
    errors = scale * max(missed, ROUND_OFF) * weights
    return limit(h, y, np.maximum(errors, least), terms)


def unresolved(
    case: ContactCase[Any], parameters: Any, integrated: Followed, steps: Array
) -> dict[str, Array]:
    """Return what switches within a few steps of one another may hide from runs, by quantity.

    ``steps`` are the durations of a step [s], shape (rungs,). A switch takes effect at the end of
    a step. The interval between two of them, shorter than :data:`RESOLVED` steps, is off by up to
    a step, or missed as a whole: the velocities by the change of the acceleration times that. As
    long as every run misses it, their values lie on a series that leads elsewhere, and nothing in
    them shows it.
    """
    motion = integrated.motion
    plain = case.observed(parameters, motion)
    found = {name: np.zeros_like(steps) for name in plain}
    for one in integrated.intervals:
        if one.duration >= RESOLVED * steps.max():
            continue
        kick = one.change * one.duration
        later = (motion.time >= one.begin)[:, None, None]
        kicked = replace(
            motion,
            velocity=motion.velocity + later * kick[:, :3],
            omega=motion.omega + later * kick[:, 3:],
        )
        hidden = np.minimum(1.0, steps / one.duration) * (one.duration < RESOLVED * steps)
        for name, value in case.observed(parameters, kicked).items():
            if math.isfinite(value - plain.get(name, math.nan)):
                found[name] += abs(value - plain[name]) * hidden
    return found
