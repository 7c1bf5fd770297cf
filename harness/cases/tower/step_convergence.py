"""How fast a code's error falls with its step: the observed order, with its interval."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from harness.cases.tower.comparison import compare
from harness.comparison.convergence import slope_order
from harness.errors import RequestError
from harness.observables.tower import Floats, TowerRun

if TYPE_CHECKING:
    import pandas as pd

FLOOR = 1e-12
"""Relative differences below this are rounding, and tell nothing of an order."""

LEAST = 3
"""Steps that an order with an interval needs."""


@dataclass(frozen=True)
class Order:
    """The order p of error ~ step^p and its 95 % interval; NaN where it cannot be told."""

    value: float
    interval: tuple[float, float]


@dataclass(frozen=True)
class StepConvergence:
    """The errors of one code against a reference at S steps, coarsest first.

    Errors are those of :class:`harness.cases.tower.comparison.Difference`: force over
    the reference's peak, velocity over the speed at the start. ``floor`` (S,)
    is what rounding and interpolation leave; errors of the force at or below it do
    not enter the orders.
    """

    reference: TowerRun
    solver: str
    steps_per_contact: Floats  # (S,)
    step: Floats  # (S,) [s], as run
    peak_error: Floats  # (S,) of the force
    l2_error: Floats  # (S,) of the force
    velocity_error: Floats  # (S,) largest
    floor: Floats  # (S,) of the peak error
    peak_order: Order
    l2_order: Order
    velocity_order: Order

    def record(self) -> dict[str, Any]:
        """Return the result as a JSON-ready mapping."""
        tower = self.reference.tower
        return {
            "law": tower.law,
            "height": tower.height,
            "solver": self.solver,
            "reference": self.reference.solver,
            **_order_record("peak_force", self.peak_order),
            **_order_record("l2_force", self.l2_order),
            **_order_record("velocity", self.velocity_order),
            "errors": self.frame().to_dict(orient="records"),
        }

    def frame(self) -> pd.DataFrame:
        """Return the errors as a table, one row a step."""
        import pandas as pd

        return pd.DataFrame(
            {
                "steps_per_contact": self.steps_per_contact,
                "step_s": self.step,
                "peak_force_error": self.peak_error,
                "l2_force_error": self.l2_error,
                "velocity_error": self.velocity_error,
                "floor": self.floor,
            }
        )


def step_convergence(
    run: Callable[[float], TowerRun], reference: TowerRun, steps_per_contact: Sequence[float]
) -> StepConvergence:
    """Return errors and observed orders of ``run(steps_per_contact)`` against ``reference``.

    Raise RequestError for fewer than three different steps, for a run without a
    step, and for what :func:`harness.cases.tower.comparison.compare` refuses.
    """
    asked = sorted(set(steps_per_contact))
    if len(asked) < LEAST:
        raise RequestError(f"steps_per_contact = {asked}: must be at least {LEAST} different ones")
    found = [compare(run(steps), reference) for steps in asked]
    taken = [comparison.run.step for comparison in found]
    steps = np.array([step for step in taken if step is not None])
    if steps.size < len(asked):
        raise RequestError(f"solver = {found[0].run.solver!r}: has no step to converge in")
    peak = np.array([c.force.peak for c in found])
    l2 = np.array([c.force.l2 for c in found])
    velocity = np.array([c.velocity.peak for c in found])
    # the bound is at twice the spacing of a fourth-order interpolant
    floor = np.array([max(FLOOR, c.force.interpolation_error / 16) for c in found])
    told = peak > floor
    return StepConvergence(
        reference=reference,
        solver=found[0].run.solver,
        steps_per_contact=np.array(asked),
        step=steps,
        peak_error=peak,
        l2_error=l2,
        velocity_error=velocity,
        floor=floor,
        peak_order=_order(steps, peak, told),
        l2_order=_order(steps, l2, told),
        velocity_order=_order(steps, velocity, told),
    )


def _order(steps: Floats, errors: Floats, told: NDArray[np.bool_]) -> Order:
    told = told & (errors > 0)
    if told.sum() < LEAST:
        return Order(float("nan"), (float("nan"), float("nan")))
    return Order(*slope_order(steps[told], errors[told]))


def _order_record(name: str, order: Order) -> dict[str, Any]:
    """Return an order for JSON: None where it cannot be told."""
    known = bool(np.isfinite(order.value))
    return {
        f"{name}_order": order.value if known else None,
        f"{name}_order_interval": list(order.interval) if known else None,
    }
