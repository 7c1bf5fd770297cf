"""Write the tables of one engine's baseline as text: sorted, and exact to the last bit."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Iterator, Sequence

from harness.comparison.baseline_record import BaselineRecord
from harness.comparison.divergence import Series
from harness.errors import RequestError
from harness.store.parameter_text import parameter_text

TABLE, SERIES = ".csv", ".series.csv"

DIGITS = 12
"""Of a series: ten times finer than the narrowest band."""

OF_QUANTITY = ("quantity", "unit", "value", "uncertainty")
OF_RUN = ("engine_version", "how", "platform", "script", "script_sha256")
HEAD = (
    *("case", "record", "label", "parameters", "levels"),
    *OF_QUANTITY,
    *("family", "samples", *OF_RUN),
)
SERIES_HEAD = ("record", "column", "time_s", "value")
BETWEEN = "|"
"""Between the parts of a family."""

_ENGINE = re.compile(r"(?!.*\.series$)[A-Za-z0-9][\w.+-]*")


def table_texts(records: Iterable[BaselineRecord], engine: str) -> dict[str, str]:
    """Return the files of an engine's records as texts, by their names; none for no records.

    Raise RequestError for an engine whose name is none of a file, and for what a table
    cannot hold.
    """
    if not _ENGINE.fullmatch(engine):
        raise RequestError(f"baseline: engine {engine!r}: the name cannot be that of a file")
    chosen = sorted(records, key=lambda record: (record.case, record.name))
    if not chosen:
        return {}
    texts = {engine + TABLE: _text(HEAD, (row for one in chosen for row in _rows(one)))}
    with_series = [one for one in chosen if one.series is not None]
    if with_series:
        rows = (row for one in with_series for row in _samples(one))
        texts[engine + SERIES] = _text(SERIES_HEAD, rows)
    return texts


def same_text(one: BaselineRecord, other: BaselineRecord) -> bool:
    """Return whether two records of an engine would be written alike."""
    return list(_rows(one)) == list(_rows(other)) and same_series(one, other)


def same_series(one: BaselineRecord, other: BaselineRecord) -> bool:
    """Return whether the series of two records would be written alike."""
    return list(_samples(one)) == list(_samples(other))


def _text(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return stream.getvalue()


def _rows(record: BaselineRecord) -> Iterator[list[str]]:
    if any(BETWEEN in part for part in record.family):
        raise RequestError(f"baseline: {record.name}: {BETWEEN!r} in its family")
    cells = {
        "case": record.case,
        "record": record.name,
        "label": record.label,
        "parameters": parameter_text(record.parameters),
        "levels": " ".join(sorted(record.levels)),
        "family": BETWEEN.join(record.family),
        "samples": str(count_of(record.series.thinned()) if record.series else 0),
        **{key: getattr(record, key) for key in OF_RUN},
    }
    for name, quantity in sorted(record.quantities.items()):
        of_quantity = {
            "quantity": name,
            "unit": quantity.unit,
            "value": repr(float(quantity.value)),
            "uncertainty": repr(float(quantity.uncertainty)),
        }
        yield [({**cells, **of_quantity})[key] for key in HEAD]


def count_of(series: Series) -> int:
    """Return how many lines the samples of a series take."""
    return series.time.size * len(series.columns)


def _samples(record: BaselineRecord) -> Iterator[list[str]]:
    if record.series is None:
        return
    thin = record.series.thinned()
    for name, column in thin.columns.items():
        for time, value in zip(thin.time, column, strict=True):
            yield [record.name, name, _short(time), _short(value)]


def _short(value: float) -> str:
    return f"{value + 0.0:.{DIGITS}g}"
