"""The limit of a small step: refine a trial, extrapolate its quantities, state the tolerance.

A tolerance is a part of the quantity's size in the run: that of its value in SI units; of a ratio
1, or its limit, or the largest that it has (:meth:`ContactCase.sizes`). Small values of large
quantities are known no better than these; small quantities are.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.contact.motion import Array, Motion
from harness.cases.contact.parameters import SMOOTH
from harness.cases.contact.submodels import Trial
from harness.cases.contract import LevelName, Reference
from harness.comparison.convergence import Limit, limit
from harness.comparison.verdicts import Tolerance
from harness.parameters.law import ContactLaw
from harness.parameters.rules import Rules

if TYPE_CHECKING:
    from harness.cases.contact.contact_case import ContactCase
    from harness.cases.contact.motion import Followed


KINKED = 1e-4
ALONG_PATH = 1e-5
"""Of what begins or ends within a step along a given motion."""

_UPSTREAM = "the tests of the codes themselves allow 1e-3 to 1e-1"

WHY_SMOOTH = (
    "the law is smooth over the contact, and the series in the step is known: what its next term "
    f"leaves is below a millionth; {_UPSTREAM}"
)
WHY_KINKED = (
    "sliding, a clipped force or a dashpot begins or ends within a step, at another phase for "
    "every step: a jitter that falls with it, until the limit is known to this; "
    f"{_UPSTREAM}"
)

WHY_ALONG_PATH = (
    "along a given motion: what is cut back is so at the end of a step, the direction of sliding "
    "turns by steps: an error of the order of a step's part of a piece, squared, 1.6e-6 at level "
    f"quick, and a few times it; {_UPSTREAM}"
)

AGAIN = Tolerance(
    "", 1e-9, 1e-9, "round-off of a few thousand steps on ratios of the size of 1, and ten times it"
)
"""Of the baseline's records."""


def width_of(
    unit: str,
    *,
    kinked: bool,
    size: float = 1.0,
    along_path: bool = False,
) -> Tolerance:
    """Return the tolerance about an expected limit; what that is uncertain by is no part of it.

    ``size`` is that of a ratio in the run. ``along_path``: of forces along a given motion, without
    a jump.
    """
    part, why = (KINKED, WHY_KINKED) if kinked else (SMOOTH, WHY_SMOOTH)
    if kinked and along_path:
        part, why = ALONG_PATH, WHY_ALONG_PATH
    if unit != "1":
        return Tolerance(unit, 0.0, part, why)
    if size != 1.0:
        why = f"{part:.3g} of the quantity's size in the run, {size:.3g}: {why}"
    return Tolerance("", part * size, 0.0, why)


STEPS: Mapping[LevelName, tuple[int, ...]] = {
    "quick": (50, 100, 200, 400, 800),
    "default": (100, 200, 400, 800, 1600),
    "full": (100, 200, 400, 800, 1600, 3200, 6400),
}
"""Steps of the time that a contact takes, by level.

A contact begins half a step after the start and, the steps being parts of its own duration, ends
at the same phase of a step on every level: what is left is a series in the step.
"""

FINEST: Mapping[LevelName, int] = {"quick": 25_600, "default": 51_200, "full": 204_800}
"""Up to which a step is halved while a limit is too uncertain for its verdict, by level."""

SECONDS: Mapping[LevelName, float] = {"quick": 10.0, "default": 20.0, "full": 60.0}
"""That a run may take for it, as an engine's cost estimates it."""

RECORDED = 400
"""The steps of a contact that every level has: their values are those of the baseline."""

ROUND_OFF = 1e-13

RESOLVED = 4.0
"""Steps of an interval between two switches whose error shows in the runs themselves."""

MOST_POWERS = 3
"""That five steps resolve."""


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
    if law.bulk_response or law.surface_energy is not None:
        return (1.0, 1.5, 2.0)
    if law.damping == "none" and law.tangential.endswith(("/force", "_rescale")):
        return (1.0, 1.5, 2.0)
    elastic = {2.0, 3.0} if law.normal == "hooke" else {2.0, 2.5, 3.0}
    dashpot = {1.0, 1.0 + law.dashpot.growth(law.normal)} if law.damping != "none" else set()
    return tuple(sorted(elastic | dashpot))[:MOST_POWERS]


def refine(
    terms: Sequence[float],
    steps: Sequence[int],
    levels: Sequence[Mapping[str, float]],
    *,
    kinked: bool,
    jumps: bool = False,
    resolved: int = 1,
    bounds: Mapping[str, Array] | None = None,
) -> dict[str, Limit]:
    """Return the limit of each quantity that every level has, finite, by its name.

    ``terms`` are the powers of the step in the error, as :func:`powers` gives them.

    A kink (sliding begins, a force is clipped) falls at another phase of a step on every level: the
    error that this leaves goes with the step squared, levels weigh accordingly, and
    only the first power is resolved, or as many as ``resolved`` where the motion up to it has none.
    Where the force ``jumps`` there, it goes with the step. Else the series holds on all levels.
    ``bounds`` are least errors of the levels by the name of a quantity, as :func:`unresolved` gives
    them.
    """
    h = 1.0 / np.asarray(steps, dtype=float)
    terms = (1.0, *(p for p in terms if p > 1.0))[:resolved] if kinked else terms
    weights = (h / h[-1]) ** (1 if jumps else 2) if kinked else np.ones_like(h)
    limits = {}
    for name in levels[0]:
        y = np.array([values.get(name, np.nan) for values in levels])
        if np.isfinite(y).all():
            least = (bounds or {}).get(name, np.zeros_like(h))
            limits[name] = _limit(h, y, weights, terms, least)
    return limits


def _limit(h: Array, y: Array, weights: Array, terms: Sequence[float], least: Array) -> Limit:
    """Return the limit; the error of a level is how far the series misses it, times its weight.

    It is no smaller than the ``least`` errors.
    """
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

    ``steps`` are the durations of a step [s], shape (levels,). A switch takes effect at the end of
    a step. The interval between two of them, shorter than :data:`RESOLVED` steps, is off by up to
    a step, or missed as a whole: the velocities by the change of the acceleration times that. As
    long as every run misses it, their values lie on a series that leads elsewhere, and nothing in
    them shows it.
    """
    motion = integrated.motion
    plain = case.observed(parameters, motion)
    hidden_errors = {name: np.zeros_like(steps) for name in plain}
    for interval in integrated.intervals:
        if interval.duration >= RESOLVED * steps.max():
            continue
        kick = interval.change * interval.duration
        later = (motion.time >= interval.begin)[:, None, None]
        kicked = replace(
            motion,
            velocity=motion.velocity + later * kick[:, :3],
            omega=motion.omega + later * kick[:, 3:],
        )
        hidden = np.minimum(1.0, steps / interval.duration) * (interval.duration < RESOLVED * steps)
        for name, value in case.observed(parameters, kicked).items():
            if math.isfinite(value - plain.get(name, math.nan)):
                hidden_errors[name] += abs(value - plain[name]) * hidden
    return hidden_errors


@dataclass(frozen=True)
class Tried:
    """A trial that an engine ran under its ``rules``; ``finest`` are its finest parameters."""

    trial: Trial
    rules: Rules
    finest: Any


@dataclass(frozen=True)
class RefinedTrial(Tried):
    """Results of a trial: what is expected, limits of its quantities, and its finest motion.

    ``plain`` is what is expected under the default rules. A force ``jumps`` within a step.
    ``levels`` are the parameters of the runs that the limits are of, and ``extrapolate`` makes
    limits of the values of such runs.
    """

    references: Mapping[str, Reference]
    plain: Mapping[str, Reference]
    limits: Mapping[str, Limit]
    motion: Motion
    kinked: bool
    jumps: bool
    levels: tuple[Any, ...]
    extrapolate: Callable[[Sequence[Mapping[str, float]]], dict[str, Limit]]


@dataclass(frozen=True)
class Evidence:
    """The trials of a case in an engine, by its title."""

    engine_title: str
    refined: tuple[RefinedTrial, ...] = ()
    failed: tuple[Tried, ...] = ()

    @property
    def tried(self) -> tuple[Tried, ...]:
        """Return all trials that ran, those that failed last."""
        return (*self.refined, *self.failed)
