"""``dem-harness theory``."""

from __future__ import annotations

from dataclasses import dataclass

from harness.cli.command import Json, Reading


@dataclass(frozen=True)
class ShockOptions:
    """What makes the shock, one of three."""

    shock: float | None = None
    restitution: float | None = None
    impulse_ratio: float | None = None
    reading: Reading | None = None


def theory(asked: ShockOptions, json: Json = False) -> None:
    """Critical angle of the incline in closed form.

    tan(theta_c / 2) = tan(15 deg) (1 - sqrt(shock)) / (1 + sqrt(shock));
    10.2078 deg without rebound. With --restitution two readings of the source make the shock of
    one collision: one_shock_kept_deg, one_shock_lost_deg. event_driven_deg is the angle of rigid
    spheres by events, every rebound followed, up to a restitution of 0.7.
    """
    from harness.cli import files
    from harness.workflows import theory as closed_forms

    record = closed_forms(**vars(asked)).record()
    (files.print_json if json else files.print_record)(record)
