"""The impulse on the grain against the height of the tower."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, TypedDict, Unpack

from harness.cases.contract import Progress, silent
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
    """What a table runs over; the source's values where nothing is given."""

    heights: Iterable[int]
    stiffnesses: Iterable[float]
    speeds: Iterable[float]
    laws: Iterable[Law]
    windows: Sequence[Window]


def families(case: Tower | None = None, **over: Unpack[TableOptions]) -> Iterator[list[Tower]]:
    """Yield the towers of each law, stiffness and speed, the height 1 that others need first."""
    heights = dict.fromkeys((1, *over.get("heights", HEIGHTS)))
    for law, k, speed in itertools.product(
        over.get("laws", LAWS), over.get("stiffnesses", STIFFNESSES), over.get("speeds", SPEEDS)
    ):
        family = (case or Tower()).replace(law=law, stiffness=k, speed=speed, height=1)
        yield [family.replace(height=height) for height in heights]


def impulse_table(
    *,
    solver: str | None = None,
    case: Tower | None = None,
    engine: Engine | None = None,
    progress: Progress = silent,
    **over: Unpack[TableOptions],
) -> list[ImpulseRow]:
    """Return alpha(n) = J(n)/J(1) [1] for every combination, the source's by default.

    ``heights`` [contacts], ``stiffnesses`` [N/m], ``speeds`` [m/s].

    ``over`` are lists of heights, stiffnesses [N/m], speeds [m/s], laws and windows
    (:class:`TableOptions`). ``case`` gives what is not listed: mass, gravity, diameter and so on. A
    window that a tower does not show within 3 t0 leaves NaN in its row. ``solver`` (the exact one
    by default) and ``engine`` are those of :func:`harness.cases.tower.run.tower`; an engine runs
    the heights of one law, stiffness and speed together. ``progress`` is called for each tower.
    """
    name = "exact" if solver is None and engine is None else chosen_solver(solver, engine)
    windows = over.get("windows", ("turnaround",))
    over["heights"] = wanted = tuple(over.get("heights", HEIGHTS))
    profiles = "structure" in windows  # its end is a contact's, which the grain does not feel
    groups = list(families(case, **over))
    rows: list[ImpulseRow] = []
    done, total = 0, sum(map(len, groups))
    for group in groups:
        found = {}
        for run in towers(group, solver=name, profiles=profiles, engine=engine):
            found[run.tower.height] = _impulses(run, windows, engine)
            done += 1
            progress("towers", done, total)
        one = group[0]
        k, speed = one.each("stiffness")[0], one.speed
        rows += [
            ImpulseRow(height, k, speed, one.law, window, end, value, value / found[1][window][1])
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
