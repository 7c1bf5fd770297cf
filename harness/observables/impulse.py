"""The impulse of the contact force on the grain."""

from __future__ import annotations

from dataclasses import dataclass

from harness.errors import RequestError
from harness.observables.interpolation import grain_velocity_at
from harness.observables.tower import TowerRun
from harness.observables.windows import Window, window_end


def impulse_until(run: TowerRun, time: float) -> float:
    """Return the integral of the contact force on the grain up to ``time`` [N s].

    Momentum balance, ``J = m (v0 - v) + m g t``: exact, where a quadrature of the
    samples of the force would not be. Raise RequestError beyond the run.
    """
    t0 = run.tower.contact_time
    if not 0 <= time <= run.time[-1] * (1 + 1e-9):
        raise RequestError(
            f"duration = {run.time[-1] / t0:.6g} t0: must be at least {time / t0:.6g} t0, "
            "where the window ends"
        )
    mass = run.tower.each("mass")[0]
    lost = float(run.grain_velocity[0]) - grain_velocity_at(run, time)
    return mass * (lost + run.tower.gravity * time)


def impulse(run: TowerRun, window: Window = "turnaround") -> float:
    """Return the impulse on the grain over ``window`` [N s]."""
    return impulse_until(run, window_end(run, window))


@dataclass(frozen=True)
class ImpulseRow:
    """One entry of the impulse table: ``ratio`` is alpha(n) = J(n)/J(1).

    ``window_s``, ``impulse_Ns`` and ``ratio`` are NaN where the window does not
    exist, as the structure window of tall towers.
    """

    height: int
    stiffness: float  # [N/m]
    speed: float  # [m/s]
    law: str
    window: str
    window_s: float  # [s] its end
    impulse_Ns: float  # [N s]
    ratio: float  # [1]
