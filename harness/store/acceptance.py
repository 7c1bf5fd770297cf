"""Accept measured values as the new baseline: show what would change, then replace its files."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import ClassVar

import numpy as np

from harness.comparison.compare import ROUND_OFF, Change, Pair, compare
from harness.comparison.regression import Baseline, BaselineRecord, changed_parameters
from harness.errors import RequestError
from harness.files import whole_folder
from harness.observables.row import Row
from harness.shown import Record
from harness.store.baseline import (
    SERIES,
    TABLE,
    in_checkout,
    read_tables,
    same_series,
    same_text,
    table_texts,
)

METADATA = ("engine_version", "how", "platform", "script_sha256", "levels", "label", "family")


class ChangeKind(StrEnum):
    """How a record would change in the baseline."""

    NEW = "new"
    CHANGED = "changed"
    ROUND_OFF = "within round-off"
    METADATA = "same values, other metadata"


@dataclass(frozen=True)
class RecordChange(Record):
    """A record that would change in the baseline, with a text for each of its changes."""

    measured: BaselineRecord
    kind: ChangeKind
    lines: tuple[str, ...]

    JSON: ClassVar = {
        "case": "measured.name",
        "kind": "kind",
        "changes": "lines",
    }


def changes(measured: Sequence[BaselineRecord], baseline: Baseline) -> list[RecordChange]:
    """Return what accepting would change; records that were not measured stay as they are."""
    pending = []
    for record in sorted(measured, key=lambda record: record.name):
        accepted = baseline.records.get(record.name)
        if accepted is None:
            lines = [f"{n} = {q.value!r} {q.unit}".rstrip() for n, q in record.quantities.items()]
            pending.append(RecordChange(record, ChangeKind.NEW, tuple(lines)))
            continue
        merged = replace(record, levels=tuple(sorted({*record.levels, *accepted.levels})))
        if not same_text(merged, accepted):
            pending.append(
                RecordChange(merged, _kind(merged, accepted), tuple(_lines(merged, accepted)))
            )
    return pending


def _kind(record: BaselineRecord, accepted: BaselineRecord) -> ChangeKind:
    pairs = _pairs(record, accepted)
    classes = {change for pair in pairs for change in _changes_of(pair)}
    if record.parameters != accepted.parameters or _series_moved(record, accepted):
        return ChangeKind.CHANGED
    if classes - {Change.SAME, Change.ROUNDING}:
        return ChangeKind.CHANGED
    same = Change.ROUNDING not in classes and same_series(record, accepted)
    return ChangeKind.METADATA if same else ChangeKind.ROUND_OFF


def _pairs(record: BaselineRecord, accepted: BaselineRecord) -> list[Pair[Row]]:
    """Return the quantities of both, by name; nothing but round-off is tolerated."""
    compared = compare(accepted.quantities, record.quantities, lambda *_: 0.0)
    return [pair for _, pair in sorted(compared.items())]


def _changes_of(pair: Pair[Row]) -> Iterator[StrEnum]:
    yield pair.change
    if pair.before is None or pair.after is None:
        return
    if pair.before.unit != pair.after.unit:
        yield Change.MOVED
    apart = abs(pair.after.uncertainty - pair.before.uncertainty)
    if apart:
        tiny = apart <= ROUND_OFF * abs(pair.before.value)
        yield Change.ROUNDING if tiny else Change.MOVED


def _series_moved(record: BaselineRecord, accepted: BaselineRecord) -> bool:
    if record.series is None or accepted.series is None:
        return record.series is not accepted.series
    new, old = record.series.thinned(), accepted.series.thinned()
    if new.time.shape != old.time.shape or new.columns.keys() != old.columns.keys():
        return True
    pairs = [(new.time, old.time), *((new.columns[n], c) for n, c in old.columns.items())]
    return any(not np.all(np.abs(a - b) <= ROUND_OFF * np.max(np.abs(b))) for a, b in pairs)


def _lines(record: BaselineRecord, accepted: BaselineRecord) -> list[str]:
    lines = changed_parameters(record.parameters, accepted.parameters)
    for pair in _pairs(record, accepted):
        name, new, old = pair.row.name, pair.after, pair.before
        if new is None or old is None:
            lines.append(f"{name}: {pair.change if new else 'dropped'}")
        elif pair.change is not Change.SAME:
            apart = pair.moved_by
            lines.append(f"{name}: {old.value!r} -> {new.value!r} {new.unit} ({apart:+.2g})")
        elif new.uncertainty != old.uncertainty or new.unit != old.unit:
            lines.append(f"{name}: uncertainty {old.uncertainty:.3g} -> {new.uncertainty:.3g}")
    if not same_series(record, accepted):
        lines.append("series")
    for key in METADATA:
        new_text, old_text = (_short(getattr(version, key)) for version in (record, accepted))
        if new_text != old_text:
            lines.append(f"{key}: {old_text} -> {new_text}")
    return lines or ["parameters that only one of them has"]


def _short(value: object) -> str:
    return ", ".join(value) if isinstance(value, tuple) else str(value)[:30]


def check_target(folder: Path) -> None:
    """Raise RequestError for a folder that is no place for a baseline."""
    if not in_checkout(folder):
        raise RequestError(
            f"--baseline {folder}: belongs to the installed package and is not written; "
            "name a folder of your own"
        )
    if folder.exists() and not folder.is_dir():
        raise RequestError(f"--baseline {folder}: is a file; name a folder")


def write(accepted: Sequence[RecordChange], folder: Path) -> None:
    """Write the changes into a baseline's folder: a whole copy aside, then exchanged.

    Raise RequestError as :func:`check_target` does, and when it cannot be written;
    then the folder is as before.
    """
    check_target(folder)
    try:
        with whole_folder(folder, replace=True) as aside:
            if folder.is_dir():
                shutil.copytree(folder, aside)
            else:
                aside.mkdir()
            for engine in sorted({change.measured.engine for change in accepted}):
                of_engine = [c.measured for c in accepted if c.measured.engine == engine]
                _write_tables(engine, of_engine, aside)
    except OSError as error:
        raise RequestError(f"--baseline {folder}: cannot be written ({error.strerror})") from None


def _write_tables(engine: str, accepted: Sequence[BaselineRecord], folder: Path) -> None:
    table = folder / f"{engine}{TABLE}"
    kept = read_tables(table) if table.is_file() else []
    merged = {record.name: record for record in [*kept, *accepted]}
    texts = table_texts(merged.values(), engine)
    for name in (engine + TABLE, engine + SERIES):
        if name in texts:
            (folder / name).write_text(texts[name], encoding="utf-8")
        else:
            (folder / name).unlink(missing_ok=True)
