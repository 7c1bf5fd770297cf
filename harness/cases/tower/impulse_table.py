"""The impulse on the grain against the height of the tower."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from harness.cases.tower.run import covering, tower
from harness.errors import RequestError
from harness.observables.impulse import ImpulseRow, impulse_until
from harness.observables.windows import Window, window_end
from harness.parameters.tower import LAWS, Law, Tower

if TYPE_CHECKING:
    from harness.engines.contract import Engine

# the source's runs, which it calls rigidity 1e4 to 1e6
HEIGHTS = tuple(range(1, 20))
STIFFNESSES = (1e5, 1e6, 1e7)
SPEEDS = (2.0, 4.0)


def impulse_table(
    *,
    heights: Iterable[int] = HEIGHTS,
    stiffnesses: Iterable[float] = STIFFNESSES,
    speeds: Iterable[float] = SPEEDS,
    laws: Iterable[Law] = LAWS,
    windows: Sequence[Window] = ("turnaround",),
    solver: str = "exact",
    case: Tower | None = None,
    steps_per_contact: float | None = None,
    engine: Engine | None = None,
) -> list[ImpulseRow]:
    """Return alpha(n) = J(n)/J(1) for every combination, the source's by default.

    ``case`` gives what is not listed: mass, gravity, diameter and so on. A
    window that a tower does not show within 3 t0 leaves NaN in its row. The solver
    ``lammps`` runs in ``engine``, or in LAMMPS in-process.
    """
    common = case or Tower()
    rows: list[ImpulseRow] = []
    for law, k, speed in itertools.product(laws, stiffnesses, speeds):
        family = common.replace(law=law, stiffness=k, speed=speed, height=1)
        single = dict(_impulses(family, windows, solver, steps_per_contact, engine))
        for height in heights:
            one = family.replace(height=height)
            for window, (end, value) in _impulses(one, windows, solver, steps_per_contact, engine):
                ratio = value / single[window][1]
                rows.append(ImpulseRow(height, k, speed, law, window, end, value, ratio))
    return rows


def _impulses(
    case: Tower,
    windows: Sequence[Window],
    solver: str,
    steps_per_contact: float | None,
    engine: Engine | None,
) -> Iterator[tuple[Window, tuple[float, float]]]:
    """Yield each window's end [s] and impulse [N s], NaN where there is none."""
    profiles = "structure" in windows  # its end is a contact's, which the grain does not feel
    run = tower(
        case,
        solver=solver,
        steps_per_contact=steps_per_contact,
        profiles=profiles,
        engine=engine,
    )
    for window in windows:
        try:
            whole = covering(run, window, engine)
        except RequestError:
            yield window, (math.nan, math.nan)
            continue
        end = window_end(whole, window)
        yield window, (end, impulse_until(whole, end))
