"""``dem-harness theory``."""

from __future__ import annotations

from harness.cli.command import Json, Reading
from harness.cli.files import print_json, print_record


def theory(
    *,
    shock: float | None = None,
    restitution: float | None = None,
    impulse_ratio: float | None = None,
    reading: Reading | None = None,
    json: Json = False,
) -> int:
    """Critical angle of the incline in closed form.

    tan(theta_c / 2) = tan(15 deg) (1 - sqrt(shock)) / (1 + sqrt(shock));
    10.2078 deg without rebound. With --restitution two readings of the source make the shock of
    one collision: one_shock_kept_deg, one_shock_lost_deg. event_driven_deg is the angle of rigid
    spheres by events, every rebound followed, up to a restitution of 0.7.

    For example:

        dem-harness theory --restitution 0.5
        dem-harness theory --shock 0.1 --json

    Parameters
    ----------
    shock
        Energy after over energy before the shock, 0 to 1. [default: 1/4]
    restitution
        Normal restitution e, 0 to 1, that makes the shock.
    impulse_ratio
        Impulse ratio alpha = J(n)/J(1), 0 to 2, that makes the shock.
    reading
        How e or alpha makes a shock: `kept`, energy after over before (default for e); `lost`,
        from the velocity lost, as the source prints it (default for alpha).
    """
    from harness.workflows import theory as closed_forms

    record = closed_forms(
        shock=shock, restitution=restitution, impulse_ratio=impulse_ratio, reading=reading
    ).to_json()
    (print_json if json else print_record)(record)
    return 0
