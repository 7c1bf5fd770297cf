"""Accept what was measured as the new baseline: say what would change, then write it whole."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from harness.atomic_write import whole_folder
from harness.comparison.baseline_record import BaselineRecord
from harness.comparison.metadata_diff import changed_parameters
from harness.comparison.regression import Baseline
from harness.errors import RequestError
from harness.store.baseline import case_text, in_checkout, series_text


@dataclass(frozen=True)
class Change:
    """A case whose files would change, and how: one line each."""

    case: BaselineRecord
    kind: str  # new or changed
    lines: tuple[str, ...]

    def record(self) -> dict[str, object]:
        """Return it as a JSON-ready mapping."""
        return {"case": self.case.name, "kind": self.kind, "changes": list(self.lines)}


def changes(measured: Sequence[BaselineRecord], baseline: Baseline) -> list[Change]:
    """Return what accepting would change; cases that were not measured stay as they are."""
    found = []
    for case in sorted(measured, key=lambda case: case.name):
        known = baseline.cases.get(case.name)
        if known is None:
            lines = [f"{n} = {q.value!r} {q.unit}".rstrip() for n, q in case.quantities.items()]
            found.append(Change(case, "new", tuple(lines)))
            continue
        merged = replace(case, levels=tuple(sorted({*case.levels, *known.levels})))
        same = case_text(merged) == case_text(known) and _same_series(merged, known)
        if not same:
            found.append(Change(merged, "changed", tuple(_lines(merged, known))))
    return found


def _same_series(case: BaselineRecord, known: BaselineRecord) -> bool:
    if case.series is None or known.series is None:
        return case.series is known.series
    return series_text(case.series) == series_text(known.series)


def _lines(case: BaselineRecord, known: BaselineRecord) -> list[str]:
    lines = changed_parameters(case.parameters, known.parameters)
    for name in sorted({*case.quantities, *known.quantities}):
        new, old = case.quantities.get(name), known.quantities.get(name)
        if new is None or old is None:
            lines.append(f"{name}: {'added' if old is None else 'dropped'}")
        elif new != old:
            apart = new.value - old.value
            lines.append(f"{name}: {old.value!r} -> {new.value!r} {new.unit} ({apart:+.2g})")
    if not _same_series(case, known):
        lines.append("series")
    for key in ("engine_version", "how", "platform", "script_sha256", "levels"):
        new, old = getattr(case, key), getattr(known, key)
        if new != old:
            lines.append(f"{key}: {_short(old)} -> {_short(new)}")
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


def write(accepted: Sequence[Change], folder: Path) -> None:
    """Write the changes into a baseline's folder: a whole copy aside, then renamed.

    Raise RequestError as :func:`check_target` does, and when it cannot be written;
    then the folder is as before.
    """
    check_target(folder)
    try:
        with whole_folder(folder, replace=True) as aside:
            if folder.is_dir():
                shutil.copytree(folder, aside)
            for change in accepted:
                _write_case(change.case, aside)
    except OSError as error:
        raise RequestError(f"--baseline {folder}: cannot be written ({error.strerror})") from None


def _write_case(case: BaselineRecord, folder: Path) -> None:
    path = folder / f"{case.name}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(case_text(case), encoding="utf-8")
    series = path.with_suffix(".csv")
    series.unlink(missing_ok=True)
    if case.series is not None:
        series.write_text(series_text(case.series), encoding="utf-8")
