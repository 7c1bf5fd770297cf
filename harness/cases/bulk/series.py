"""What the series of a bulk run must hold: all rows and all grains; and the energy gained in it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from harness.cases.bulk.beds import Bed, BedOfOneKind
from harness.engines.output import Output, Table
from harness.errors import EngineLostAtomsError, EngineOutputError

LONGEST_GAP = 1.5  # [shortest interval between two rows] as some codes are a step late


def read_series(p: Bed, output: Output, columns: Sequence[str], **known: int) -> Table:
    """Return the series of a run; the first column is ``time_s`` or ``step``.

    Raise EngineOutputError where rows are missing, and where ``known`` results or the number of
    steps differ from those of the parameters.
    """
    output.check_numbers({**known, "steps": p.settle_steps + p.steps})
    table = output.table(columns)
    steps = columns[0] == "step"
    times = table["step"] - p.settle_steps if steps else table["time_s"]
    end = p.steps * (1.0 if steps else p.step_size)
    gaps = np.diff(times, prepend=min(0.0, times[0]), append=max(end, times[-1]))
    inner = gaps[1:-1]
    if not inner.size or gaps.max() > LONGEST_GAP * inner.min():
        place = int(gaps.argmax())
        start = times[place - 1] if place else 0.0
        raise EngineOutputError(
            f"{output.who} left a series that lacks rows: none for {gaps[place]:.4g} after "
            f"{start:.4g}"
        )
    return table


def check_grains(
    p: BedOfOneKind, output: Output, table: Table, beyond: str, event: str, why: str = ""
) -> None:
    """Raise EngineLostAtomsError for a grain that is ``beyond`` the walls, for the reason ``why``.

    The output has the number within the walls at the ``event`` that disturbs the bed, the series
    the number beyond them later.
    """
    within = output.number("grains")
    times = [0.0] if within < p.grains else table["time_s"][table["astray"] != 0.0]
    if len(times):
        raise EngineLostAtomsError(
            f"{output.who}: a grain is {beyond} {times[0]:.3g} s after {event}: {why}step_size = "
            f"{p.step_size:g} s is too long, youngs_modulus = {p.youngs_modulus:g} Pa too small"
        )
    if within > p.grains:
        raise EngineOutputError(f"{output.who} began with {within:.0f} grains of {p.grains}")


def energy_rise(output: Output, table: Table) -> float:
    """Return the largest rise [J] of kinetic and potential energy above what it was before."""
    later = table["kinetic_J"] + table["potential_J"]
    energy = np.concatenate([[output.number("released_J")], later])
    return float((energy - np.minimum.accumulate(energy)).max())


def time_per_step(p: Bed, output: Output, table: Table) -> float:
    """Return the wall time of a particle and step [us], of those that remain."""
    moved = p.every * table["remaining"].sum() if "remaining" in table else p.grains * p.steps
    return float(1e6 * output.seconds / (p.grains * p.settle_steps + moved))
