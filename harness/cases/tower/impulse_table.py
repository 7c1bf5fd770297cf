"""The impulse on the grain against the height of the tower."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, TypedDict

from harness.cases.tower.run import chosen_solver, covering, towers
from harness.errors import RequestError
from harness.observables.impulse import ImpulseRow, impulse_until
from harness.observables.tower import TowerRun
from harness.observables.windows import Window, window_end
from harness.parameters.tower import LAWS, Law, Tower

if TYPE_CHECKING:
    from harness.engines.contract import Engine

# the source's runs, which it calls rigidity 1e4 to 1e6
HEIGHTS = tuple(range(1, 20))
STIFFNESSES = (1e5, 1e6, 1e7)
SPEEDS = (2.0, 4.0)


class TableOptions(TypedDict, total=False):
    """What a table runs over, and what runs it: keywords of :func:`impulse_table`."""

    heights: Iterable[int]
    stiffnesses: Iterable[float]
    speeds: Iterable[float]
    laws: Iterable[Law]
    windows: Sequence[Window]
    solver: str | None
    engine: Engine | None


def impulse_table(
    *,
    heights: Iterable[int] = HEIGHTS,
    stiffnesses: Iterable[float] = STIFFNESSES,
    speeds: Iterable[float] = SPEEDS,
    laws: Iterable[Law] = LAWS,
    windows: Sequence[Window] = ("turnaround",),
    solver: str | None = None,
    case: Tower | None = None,
    engine: Engine | None = None,
) -> list[ImpulseRow]:
    """Return alpha(n) = J(n)/J(1) [1] for every combination, the source's by default.

    ``heights`` [contacts], ``stiffnesses`` [N/m], ``speeds`` [m/s].

    ``case`` gives what is not listed: mass, gravity, diameter and so on. A window that a tower
    does not show within 3 t0 leaves NaN in its row. ``solver`` (the exact one by default) and
    ``engine`` are those of :func:`harness.cases.tower.run.tower`; an engine runs the heights of
    one law, stiffness and speed together.
    """
    common, wanted = case or Tower(), tuple(heights)
    name = "exact" if solver is None and engine is None else chosen_solver(solver, engine)
    profiles = "structure" in windows  # its end is a contact's, which the grain does not feel
    rows: list[ImpulseRow] = []
    for law, k, speed in itertools.product(laws, stiffnesses, speeds):
        family = common.replace(law=law, stiffness=k, speed=speed, height=1)
        distinct = dict.fromkeys((1, *wanted))
        runs = towers(
            [family.replace(height=height) for height in distinct],
            solver=name,
            profiles=profiles,
            engine=engine,
        )
        found = {run.tower.height: _impulses(run, windows, engine) for run in runs}
        rows += [
            ImpulseRow(height, k, speed, law, window, end, value, value / found[1][window][1])
            for height in wanted
            for window, (end, value) in found[height].items()
        ]
    return rows


def _impulses(
    run: TowerRun, windows: Sequence[Window], engine: Engine | None
) -> dict[Window, tuple[float, float]]:
    """Return each window's end [s] and impulse [N s], NaN where there is none."""
    found: dict[Window, tuple[float, float]] = {}
    for window in windows:
        try:
            whole = covering(run, window, engine)
        except RequestError:
            found[window] = (math.nan, math.nan)
            continue
        end = window_end(whole, window)
        found[window] = end, impulse_until(whole, end)
    return found
