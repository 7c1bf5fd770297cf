"""``dem-harness theory``."""

from __future__ import annotations

from dataclasses import dataclass

from harness.cli.command import option
from harness.cli.options import Json, Reading


@dataclass(frozen=True)
class ShockOptions:
    """What makes the shock, one of three."""

    shock: float | None = option(
        None, "Energy after over energy before the shock, 0 to 1.  [default: 1/4]"
    )
    restitution: float | None = option(None, "Normal restitution e, 0 to 1, that makes the shock.")
    impulse_ratio: float | None = option(
        None, "Impulse ratio alpha = J(n)/J(1), 0 to 2, that makes the shock."
    )
    reading: Reading | None = option(
        None,
        "How e or alpha makes a shock: `kept`, energy after over before (default for e); `lost`, "
        "from the velocity lost, as the source prints it (default for alpha).",
    )


def theory(asked: ShockOptions, json: Json = False) -> None:
    """Critical angle of the incline in closed form.

    tan(theta_c / 2) = tan(15 deg) (1 - sqrt(shock)) / (1 + sqrt(shock));
    10.2078 deg without rebound.
    """
    from harness.cli import output
    from harness.workflows import theory as closed_forms

    record = closed_forms(**vars(asked)).record()
    (output.print_json if json else output.print_record)(record)
