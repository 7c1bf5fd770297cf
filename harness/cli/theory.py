"""``dem-harness theory``."""

from __future__ import annotations

from typing import Annotated

import typer

from harness.cli.options import Json, Reading


def theory(
    shock: Annotated[
        float | None,
        typer.Option(help="Energy after over energy before the shock, 0 to 1.  [default: 1/4]"),
    ] = None,
    restitution: Annotated[
        float | None, typer.Option(help="Normal restitution e, 0 to 1, that makes the shock.")
    ] = None,
    impulse_ratio: Annotated[
        float | None,
        typer.Option(help="Impulse ratio alpha = J(n)/J(1), 0 to 2, that makes the shock."),
    ] = None,
    reading: Annotated[
        Reading | None,
        typer.Option(
            help="How e or alpha makes a shock: `kept`, energy after over before (default for e); "
            "`lost`, from the velocity lost, as the source prints it (default for alpha)."
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Critical angle of the incline in closed form.

    tan(theta_c / 2) = tan(15 deg) (1 - sqrt(shock)) / (1 + sqrt(shock));
    10.2078 deg without rebound.
    """
    from harness.cli.output import print_json, print_record
    from harness.workflows import theory as closed_forms

    found = closed_forms(
        shock=shock,
        restitution=restitution,
        impulse_ratio=impulse_ratio,
        reading=reading.value if reading else None,
    )
    if json:
        print_json(found.record())
    else:
        print_record(found.record())
