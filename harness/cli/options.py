"""Options that several commands share."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

Json = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on stdout, and nothing else.")
]

Tolerances = Annotated[
    Path | None,
    typer.Option(
        "--tolerances",
        metavar="FILE",
        help="Named overrides of the regression tolerances, TOML.  "
        "[default: inputs/tolerances.toml]",
    ),
]


class Method(StrEnum):
    """The two routes to the critical angle."""

    PASSAGE = "passage"
    STEADY = "steady"


class Reading(StrEnum):
    """The two readings of the source's shock."""

    KEPT = "kept"
    LOST = "lost"


class ContactName(StrEnum):
    """The contacts that have a name."""

    SOURCE = "source"
    CLIPPED = "clipped"
    PLASTIC = "plastic"
