"""Where two ledgers differ: statuses exactly, numbers up to round-off."""

from __future__ import annotations

import numpy as np
import pandas as pd

NUMBERS = ("printed", "found", "corrected", "tolerance")

RELATIVE = 1e-6
"""Round-off of another processor or library, carried through a run of 1e5 steps."""

OF_TOLERANCE = 0.01
"""A residual is round-off itself: what counts is its size against the row's tolerance."""


def ledger_differences(first: pd.DataFrame, second: pd.DataFrame) -> list[str]:
    """Return one line for each way in which ``second`` departs from ``first``.

    Both as of :meth:`harness.reproduction.claims.Ledger.frame`; words are not
    compared, since they repeat the numbers.
    """
    a, b = first.set_index("key"), second.set_index("key")
    lines = [f"{key}: is not there any more" for key in a.index.difference(b.index, sort=False)]
    lines += [f"{key}: is new" for key in b.index.difference(a.index, sort=False)]
    for key in a.index.intersection(b.index, sort=False):
        one, other = a.loc[key], b.loc[key]
        if one["status"] != other["status"]:
            lines.append(f"{key}: was {one['status']}, is {other['status']}")
        was, now = (pd.to_numeric(row[[*NUMBERS]], errors="coerce") for row in (one, other))
        room = OF_TOLERANCE * np.nan_to_num(was["tolerance"])
        same = np.isclose(was, now, rtol=RELATIVE, atol=room, equal_nan=True)
        lines += [
            f"{key}: {name} was {was[name]:.10g}, is {now[name]:.10g}"
            for name in np.array(NUMBERS)[~same]
        ]
    return lines
