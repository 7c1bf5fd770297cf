"""Compare tables of rows: accepted runs, other runs, other releases.

- ``compare(accepted, run)``: what moved against accepted values;
- ``compare(monday, tuesday)``: the difference of two runs;
- ``cells({"2022": a, "2023": b})``: the worst verdict of each setup in several releases.

``digest`` and ``differ`` show whether the engine was given the same input.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterable, Mapping
from enum import StrEnum
from itertools import compress
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from harness.results.rows import COLUMNS, KEY, Kind, Verdict, defects_of

Mask = NDArray[np.bool_]
Covers = Callable[[pd.DataFrame], Mask]  # which rows, by key and level, a run was to have

ROUND_OFF = 1e-12  # relative change that counts as rounding: some thousand units in the last place
RANKS = {Verdict.FAIL: 0, Verdict.KNOWN_DEFECT: 1, Verdict.NOT_TESTED: 1}
BEST_RANK = 2  # of all other verdicts
WIDEST = 2.0  # of the first tolerance: one that rests on the scatter of a run varies


class Change(StrEnum):
    """The class of a row's change, from the one to read first to the one to read last."""

    WORSE = "worse"  # in its verdict, or it is missing although it was requested
    OTHER_INPUT = "other input"  # the engine was given another script, value or scene
    MOVED = "moved"  # by more than its tolerance, or twice the first one
    BETTER = "better"
    NEW = "new"
    WITHIN = "within tolerance"
    ROUND_OFF = "within round-off"
    SAME = "same"
    NOT_COMPARABLE = "not comparable"  # only one of the runs was to have it


BAD = (Change.WORSE, Change.OTHER_INPUT, Change.MOVED)


def covers_all(rows: pd.DataFrame) -> Mask:
    """Return True for each row, shape (rows,)."""
    return np.ones(len(rows), bool)


def compare(
    before: pd.DataFrame,
    after: pd.DataFrame,
    *,
    covers_before: Covers = covers_all,
    covers_after: Covers = covers_all,
) -> pd.DataFrame:
    """Return one line for each key of two tables of rows, the gravest change first.

    Columns: the key, ``change``, ``moved_by`` [unit of the row], ``in_tolerances``,
    ``in_uncertainties``, and each other column of both tables with the endings ``_before`` and
    ``_after``. A row that one table lacks is not comparable where the request behind that table
    does not cover it, or where its setup was not tested: one row then represents all of the setup.
    """
    keys = list(KEY)
    both = before[list(COLUMNS)].merge(
        after[list(COLUMNS)],
        on=keys,
        how="outer",
        suffixes=("_before", "_after"),
    )
    both["moved_by"] = both["value_after"] - both["value_before"]
    both["in_tolerances"] = _ratio(both["moved_by"], _tolerance(both))
    spread = (both["uncertainty_before"] ** 2 + both["uncertainty_after"] ** 2) ** 0.5
    both["in_uncertainties"] = _ratio(both["moved_by"], spread)
    both["change"] = _changes(both, covers_before, covers_after)
    both["_place"] = both["change"].map({change: place for place, change in enumerate(Change)})
    both["_size"] = -both["in_tolerances"].abs()
    both = both.sort_values(["_place", "_size", *keys], kind="stable", ignore_index=True)
    first = [*keys, "change", "moved_by", "in_tolerances", "in_uncertainties"]
    rest = [name for name in both if name not in first and not str(name).startswith("_")]
    return both[[*first, *rest]]


def regressions(changes: pd.DataFrame) -> pd.DataFrame:
    """Return the changes that fail a run.

    A move is not one where the run itself gives the reason: a known defect, a defect that is
    fixed, or a row not tested. A finding may move unless it has a tolerance.
    """
    explained = changes["verdict_after"].isin(
        [Verdict.KNOWN_DEFECT, Verdict.FIXED, Verdict.NOT_TESTED]
    ) & (changes["change"] != Change.OTHER_INPUT)
    free = (changes["kind_after"] == Kind.FINDING) & changes["tolerance_after"].isna()
    free &= changes["change"] == Change.MOVED
    return changes[changes["change"].isin(BAD) & ~explained & ~free].reset_index(drop=True)


def counts_of_changes(changes: pd.DataFrame) -> dict[str, int]:
    """Return how many rows have each change, without classes that no row has."""
    numbers = changes["change"].value_counts()
    return {str(change): int(numbers[change]) for change in Change if change in numbers.index}


def cells(runs: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Return the worst verdict of each case, setup and engine, a column for each run.

    A variation that was not tested does not count where other rows of the cell were tested.
    """
    columns, keys = {}, ["case", "setup", "engine"]
    for name, rows in runs.items():
        groups = rows[rows["setup"] != ""].groupby(keys, sort=True)
        verdicts = {cell: _worst_verdict(part) for cell, part in groups}
        index = pd.MultiIndex.from_tuples(list(verdicts), names=keys)
        columns[name] = pd.Series(list(verdicts.values()), index, dtype=object)
    return pd.DataFrame(columns).fillna("")


def defect_counts(runs: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Return in how many cells of each run a known defect was found: defects by runs."""
    columns = {}
    for name, rows in runs.items():
        marked = by_defect(rows[rows["verdict"] == Verdict.KNOWN_DEFECT])
        places = marked.drop_duplicates(["defect", "case", "setup", "engine"])
        columns[name] = places.groupby("defect").size()
    return pd.DataFrame(columns).fillna(0).astype(int)


def by_defect(rows: pd.DataFrame) -> pd.DataFrame:
    """Return rows with one known defect each: a row of several once for each."""
    return rows.assign(defect=rows["defect"].map(defects_of)).explode("defect")


def counts(rows: pd.DataFrame) -> pd.DataFrame:
    """Return how many rows of each kind have each verdict: kinds by verdicts."""
    numbers = rows.groupby(["kind", "verdict"]).size().unstack(fill_value=0)
    kinds = [str(kind) for kind in Kind if kind in numbers.index]
    return numbers.loc[kinds, [str(verdict) for verdict in Verdict if verdict in numbers.columns]]


def _changes(both: pd.DataFrame, before: Covers, after: Covers) -> NDArray[np.object_]:
    # arrays: each operation of pandas takes as long as all of these
    verdicts = [both[f"verdict_{side}"].to_numpy(object) for side in ("before", "after")]
    appeared, gone = map(pd.isna, verdicts)
    was_untested, is_untested = (side == Verdict.NOT_TESTED for side in verdicts)
    setups = [*zip(*(both[name] for name in KEY if name != "quantity"), strict=True)]
    had = [{*compress(setups, mask)} for mask in (~gone, ~gone & ~is_untested)]
    untested = had[0] - had[1]  # one whose plain run is not has no variations either
    refused = np.array([s in untested or (*s[:-1], "") in untested for s in setups], bool)
    missed = gone & ~refused & after(_side(both, "before"))
    awaited = appeared & before(_side(both, "after"))
    ranks = [np.array([RANKS.get(v, BEST_RANK) for v in side], int) for side in verdicts]
    other_input = differ(*(_texts(both[f"inputs_{side}"]) for side in ("before", "after")))
    old, new = both["value_before"].to_numpy(float), both["value_after"].to_numpy(float)
    with np.errstate(invalid="ignore", over="ignore"):  # values may be infinite
        distance = np.abs(new - old)
    conditions = [
        (missed & ~was_untested, Change.WORSE),
        (awaited & (verdicts[1] == Verdict.FAIL), Change.WORSE),
        (awaited & ~is_untested, Change.NEW),
        (gone | appeared, Change.NOT_COMPARABLE),
        (ranks[1] < ranks[0], Change.WORSE),
        (other_input, Change.OTHER_INPUT),
        (ranks[1] > ranks[0], Change.BETTER),
        ((old == new) | (np.isnan(old) & np.isnan(new)), Change.SAME),
        (distance <= ROUND_OFF * np.abs(old), Change.ROUND_OFF),
        (distance <= _tolerance(both).to_numpy(float), Change.WITHIN),
    ]
    masks = [np.asarray(mask, bool) for mask, _ in conditions]
    names = [np.array(str(change), dtype=object) for _, change in conditions]
    return np.select(masks, names, np.array(str(Change.MOVED), dtype=object))


def _tolerance(both: pd.DataFrame) -> pd.Series[float]:
    """Return the second tolerance, at most twice the first: a wider one hides no move."""
    most, after = WIDEST * both["tolerance_before"], both["tolerance_after"]
    return after.where(~(most < after), most)


def _side(both: pd.DataFrame, side: str) -> pd.DataFrame:
    """Return keys and levels of the rows, the levels of one side."""
    return both[list(KEY)].assign(level=_texts(both[f"level_{side}"]))


def _texts(column: pd.Series[str]) -> pd.Series[str]:
    """Return a column with empty text where a table lacks the row."""
    return column.astype(object).where(column.notna(), "")


def _ratio(values: pd.Series[float], widths: pd.Series[float]) -> pd.Series[float]:
    """Return values over widths; NaN for a width that is missing, zero or not finite."""
    return values / widths.where((widths > 0.0) & np.isfinite(widths))


def _worst_verdict(cell: pd.DataFrame) -> str:
    untested = (cell["verdict"] == Verdict.NOT_TESTED) & (cell["check"] != "")
    deciding = cell if untested.all() else cell[~untested]
    order = [str(verdict) for verdict in Verdict]
    return str(min(deciding["verdict"], key=order.index))


# ---- digests of inputs: whether an engine was given another script, value or scene
#
# A digest is a hash and a sum, as "00f0a6d29b3c41e5 12.3456789012". The hash is of all but the
# sizes of numbers, which are in the sum: the last digits of one that was integrated depend on the
# CPU. A hash of rounded numbers would not do: one may lie next to a limit of rounding.

SAME_INPUT = 1e-8  # largest difference of two sums of one input; a number off by 1e-7 is beyond
GOLDEN = 0.6180339887498949  # its multiples modulo 1 are the weights of numbers


def digest(content: Any) -> str:
    """Return the digest of nested lists and tables of texts and numbers.

    A file counts by its name, which must be that of its content: each user has other folders.
    """
    numbers: list[float] = []
    text = json.dumps(_without_sizes(content, numbers))
    weights = ((1.0 + place * GOLDEN % 1.0) for place in range(len(numbers)))
    total = math.fsum(w * math.log(abs(x)) for w, x in zip(weights, numbers, strict=True))
    return f"{hashlib.sha256(text.encode()).hexdigest()[:16]} {total:.10f}"


def differ(before: Iterable[str], after: Iterable[str]) -> NDArray[np.bool_]:
    """Return which digests are of different inputs, shape (rows,); an empty one is of none."""
    return np.array([_is_other(*pair) for pair in zip(before, after, strict=True)], bool)


def _is_other(before: str, after: str) -> bool:
    if not before or not after or before == after:
        return False
    (hash_before, sum_before), (hash_after, sum_after) = _parts(before), _parts(after)
    return hash_before != hash_after or not abs(sum_before - sum_after) <= SAME_INPUT


def _parts(text: str) -> tuple[str, float]:
    name, _, number = text.partition(" ")
    try:
        return name, float(number)
    except ValueError:
        return name, math.nan


def _without_sizes(content: Any, numbers: list[float]) -> Any:
    """Return the content with the sign in place of each number, and append those to a list."""
    if isinstance(content, float) and math.isfinite(content):
        numbers += [content] if content else []
        return math.copysign(1.0, content) if content else 0.0
    if isinstance(content, str) and content.startswith("/"):
        return content.rpartition("/")[2]
    if isinstance(content, dict):
        return {name: _without_sizes(value, numbers) for name, value in content.items()}
    if isinstance(content, list | tuple):
        return [_without_sizes(item, numbers) for item in content]
    return content
