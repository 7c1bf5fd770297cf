"""Record each run of a command in the history: start, quantities, end.

The name of a quantity says which run it is of: runs of the same name can be drawn over one another.
Parameters are named where they are not the default.
"""

from __future__ import annotations

import contextlib
import math
import platform
import sqlite3
import sys
import time
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.comparison.regression import BaselineRecord
from harness.errors import HarnessError
from harness.observables.row import Row

if TYPE_CHECKING:
    from harness.comparison.verdicts import Check
    from harness.store.history import History
    from harness.workflows.progress import Progress

_INCLINE_DEFAULTS = {
    "diameter_m": 1.0,
    "density_kg_per_m3": 6.0 / math.pi,
    "gravity_m_per_s2": 9.81,
}
_TOWER_DEFAULTS = {"mass_kg": 1.0, "gravity_m_per_s2": 9.81, "base": "fixed"}
_TOWER = (
    ("impulse_Ns", "impulse, {window} window", "N s"),
    ("peak_force_N", "peak force", "N"),
    ("turnaround_s", "turnaround", "s"),
    ("energy_drift", "energy drift", ""),
)
"""Key, name and unit of what ``tower`` measures."""


def angle_quantities(record: Mapping[str, Any]) -> list[Row]:
    """Return the critical angle of ``critical-angle`` and the closed form."""
    if record.get("extrapolated"):
        where = "extrapolated"
    else:
        where = (
            f"k = {record['stiffness_N_per_m']:.12g} N/m, "
            f"{record['steps_per_contact']:.12g} steps per contact"
        )
    if record.get("wells", 10) != 10:
        where += f", {record['wells']} wells"
    name = f"critical angle: {record['method']}, {_contact(record)}, {where}"
    return [
        Row(
            name + _others(record, _INCLINE_DEFAULTS),
            record["critical_angle_deg"],
            record["uncertainty_deg"],
            "deg",
            record.get("closed_form_deg", math.nan),
        )
    ]


def case_quantities(cases: Iterable[BaselineRecord]) -> list[Row]:
    """Return what cases of the baseline measured, named as their rows are."""
    return [
        replace(quantity, name=f"{case.name}: {name}")
        for case in cases
        for name, quantity in case.quantities.items()
    ]


def tower_quantities(record: Mapping[str, Any]) -> list[Row]:
    """Return impulse, peak force, turnaround and energy drift of ``tower``."""
    case = (
        (
            f"{record['solver']}, {record['law']} law, n = {record['height']}, "
            f"k = {record['stiffness_N_per_m']:.12g} N/m, v0 = {record['speed_m_per_s']:.12g} m/s, "
            f"{record['duration_s'] / record['contact_time_s']:.6g} t0"
        )
        + ("" if record["step_s"] is None else f", step {record['step_s']:.6g} s")
        + _others(record, _TOWER_DEFAULTS)
    )
    window = record["window"]
    return [
        Row(f"tower: {name.format(window=window)}: {case}", float(record[key]), math.nan, unit)
        for key, name, unit in _TOWER
    ]


def run_quantities(record: Mapping[str, Any], settings: Mapping[str, Any]) -> list[Row]:
    """Return the quantities of ``run`` with their references; ``settings`` are values set."""
    values = "".join(f", {name} = {value}" for name, value in sorted(settings.items()))
    return [
        Row(
            f"{record['case']}: {name}: {record['engine']}{values}",
            quantity["value"],
            math.nan,
            quantity["unit"],
            expected=math.nan if quantity["reference"] is None else quantity["reference"],
        )
        for name, quantity in record["quantities"].items()
    ]


def impulse_quantities(
    rows: Iterable[Mapping[Hashable, Any]], solver: str, others: Mapping[str, float]
) -> list[Row]:
    """Return the impulse ratio of each row of ``impulse``; ``others`` are mass and gravity."""
    rest = _others(others, _TOWER_DEFAULTS)
    return [
        Row(
            f"impulse ratio alpha({row['height']}): {solver}, {row['law']} law, "
            f"{row['window']} window, k = {row['stiffness_N_per_m']:.12g} N/m, "
            f"v0 = {row['speed_m_per_s']:.12g} m/s{rest}",
            row["impulse_ratio"],
            math.nan,
            "",
        )
        for row in rows
    ]


def _contact(record: Mapping[str, Any]) -> str:
    if record["contact"] != "custom":
        return f"{record['contact']} contact"
    mass = "" if record["effective_mass"] == "full" else ", half mass"
    return f"damping ratio {record['damping_ratio']:.12g}, tail {record['tail']}{mass}"


def _others(record: Mapping[str, Any], defaults: Mapping[str, Any]) -> str:
    changed = {
        key: record[key] for key, usual in defaults.items() if record.get(key, usual) != usual
    }
    return "".join(f", {key} = {value}" for key, value in changed.items())


@dataclass
class Recording:
    """What a command records of its run before it ends."""

    status: int = 0
    engine: Mapping[str, Any] = field(default_factory=dict)
    quantities: Sequence[Row] = ()
    cached: bool = False
    folder: Path | None = None
    progress: Progress = lambda *_: None


Finish = Callable[[Recording, float, str], None]
"""Completes a run: with the recording, the seconds it took, and a note on what ended it."""


@contextlib.contextmanager
def recorded(command: str, *, quiet: bool = False) -> Iterator[Recording]:
    """Record a run from here to the end of the block, with the error that ended it, if any.

    Yield what the command fills in, with what shows its progress unless ``quiet``. A default place
    that cannot be written costs a note on stderr, one that was named in DEM_HARNESS_HOME the
    command: RequestError.
    """
    from harness.cli import interrupted_status
    from harness.workflows import progress_bars

    recording, clock = Recording(), time.monotonic()
    with _begin(command) as finish:
        try:
            with progress_bars(command, quiet=quiet) as recording.progress:
                yield recording
        except HarnessError as error:
            recording.status = error.exit_status
            finish(recording, time.monotonic() - clock, str(error))
            raise
        except KeyboardInterrupt:
            recording.status = interrupted_status()
            finish(recording, time.monotonic() - clock, "interrupted")
            raise
        # of an exception that nobody foresaw the run stays unfinished
        finish(recording, time.monotonic() - clock, "")


def verdicts(checks: Sequence[Mapping[str, Any]]) -> list[Check]:
    """Return the checks of a verification's record as rows."""
    from harness.comparison.verdicts import Check
    from harness.shown import adapter

    rows: list[Check] = adapter(list[Check]).validate_python(checks)
    return rows


@contextlib.contextmanager
def _begin(command: str) -> Iterator[Finish]:
    """Insert a run that starts now; yield what completes it."""
    from harness import __version__
    from harness.files import history_place
    from harness.store.acceptance import commit
    from harness.store.entries import tell_stderr
    from harness.store.history import History, RunStart

    place = history_place()
    system = f"{platform.system()} {platform.machine()}, Python {platform.python_version()}"
    start = RunStart(command, given_words(command), __version__, commit(), system)
    with contextlib.ExitStack() as stack:
        try:
            history = stack.enter_context(History(place.path))
            run = history.begin(start)
        except (OSError, sqlite3.Error) as error:
            if place.named_by:
                raise place.refused(str(error)) from None
            tell_stderr(f"history {place.path} cannot be written ({error}); no record of this run")
            yield lambda *_: None
        else:
            yield partial(_finish, history, run)


def _finish(history: History, run: int, recording: Recording, seconds: float, note: str) -> None:
    """Complete the run; a history that went away meanwhile must not cost its result."""
    from harness.store.entries import tell_stderr
    from harness.store.history import RunEnd

    end = RunEnd(
        status=recording.status,
        seconds=seconds,
        engine=recording.engine.get("engine", ""),
        engine_version=recording.engine.get("engine_version", ""),
        how=recording.engine.get("how", ""),
        cached=recording.cached,
        folder=str(recording.folder.absolute()) if recording.folder else "",
        note=note,
    )
    try:
        history.finish(run, end, recording.quantities)
    except sqlite3.Error as error:
        tell_stderr(f"history {history.path} cannot be written ({error}); the run has no end there")


def given_words(command: str) -> list[str]:
    """Return the words after the command as text, as the shell handed them over."""
    words = sys.argv[1:]
    words_after = words[words.index(command) + 1 :] if command in words else []
    # what is not UTF-8 on the command line cannot be stored as it is
    return [word.encode("utf-8", "backslashreplace").decode() for word in words_after]
