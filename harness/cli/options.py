"""What several commands share: types of options, and texts.

Names are spelled out, not imported: --help must not wait for numba.
"""

from __future__ import annotations

from typing import Annotated, Literal

import typer

Json = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on stdout, and nothing else.")
]

ContactName = Literal["source", "clipped", "plastic"]
Level = Literal["quick", "default", "full"]
Reading = Literal["kept", "lost"]
