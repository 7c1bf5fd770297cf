"""Measured points of a user: two columns of a CSV file, and their uncertainty if it has one."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from harness.errors import RequestError
from harness.model.motion import Floats

LARGEST_FILE = 10_000_000  # bytes; a device has no end


@dataclass(frozen=True)
class Points:
    """Points with the name of their file; ``uncertainty`` is None where none is known."""

    name: str
    x: Floats
    y: Floats
    uncertainty: Floats | None = None


def read_points(path: Path, x: str, y: str, uncertainty: str = "") -> Points:
    """Return the points of columns ``x`` and ``y``. Raise RequestError in a line for a bad file."""
    import pandas as pd

    option = f"--reference {path}"
    text = _text(path, option)
    try:
        frame = pd.read_csv(io.StringIO(text), comment="#", skipinitialspace=True)
    except (ValueError, pd.errors.ParserError) as error:
        raise RequestError(f"{option}: is no CSV table ({' '.join(str(error).split())})") from None
    for name in (x, y):
        if name not in frame:
            columns = ", ".join(map(str, frame.columns))
            raise RequestError(f"{option}: has no column {name!r}, but {columns}")
    names = [x, y, *([uncertainty] if uncertainty in frame else [])]
    numbers = [_numbers(frame[name], option) for name in names]
    if not len(frame):
        raise RequestError(f"{option}: has no rows")
    if len(numbers) > 2 and (numbers[2] < 0.0).any():
        raise RequestError(f"{option}: {uncertainty} must not be negative")
    return Points(path.name, numbers[0], numbers[1], numbers[2] if len(numbers) > 2 else None)


def _numbers(column: object, option: str) -> Floats:
    import pandas as pd

    series = pd.Series(column)
    values = np.asarray(pd.to_numeric(series, errors="coerce"), dtype=np.float64)
    for row, value in enumerate(values, 2):
        if not np.isfinite(value):
            found = series.iloc[row - 2]
            raise RequestError(f"{option}, row {row}: {series.name} = {found!r}: must be a number")
    return values


def _text(path: Path, option: str) -> str:
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST_FILE + 1)
    except OSError as error:
        raise RequestError(f"{option}: {error.strerror or error}") from None
    if len(data) > LARGEST_FILE:
        raise RequestError(f"{option}: is longer than {LARGEST_FILE} bytes")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        row = data.count(b"\n", 0, error.start) + 1
        raise RequestError(f"{option}, row {row}: is not UTF-8 text") from None
