"""What a result is outside Python: JSON and a table by its fields, a few lines, a figure."""

from __future__ import annotations

import html
import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import is_dataclass
from enum import Enum
from functools import cache
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

if TYPE_CHECKING:
    import pandas as pd
    from pydantic import TypeAdapter

    from harness.shown.figure import Figure

ROUND_OFF = 14
"""Decimals beyond which an uncertainty says nothing."""


@cache
def adapter(kind: Any) -> TypeAdapter[Any]:
    """Return what reads and writes a dataclass."""
    from pydantic import TypeAdapter

    return TypeAdapter(kind)


def to_json(value: Any) -> Any:
    """Return a value as JSON has it, dataclasses by their fields; what is not finite stays so."""
    if isinstance(value, Record):
        return value.to_json()
    if isinstance(value, Mapping):
        return {key: to_json(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [to_json(item) for item in value]
    if is_dataclass(value):
        kind: Any = type(value)
        return adapter(kind).dump_python(value, mode="json")
    return str(value) if isinstance(value, (Enum, PurePath)) else value


class Record:
    """A dataclass that JSON and tables have by its fields, or by what ``JSON`` declares.

    ``JSON`` maps each key, with the unit in it, to the attribute that it has, one of an attribute
    after a dot; a key of stars puts in all keys of a mapping or a record. ``ROWS`` is the attribute
    with the rows of its table, empty for a table of one row.
    """

    JSON: ClassVar[Mapping[str, str]] = {}
    ROWS: ClassVar[str] = ""

    def to_json(self) -> dict[str, Any]:
        """Return the keys, JSON-ready."""
        if not self.JSON:
            kind: Any = type(self)
            fields: dict[str, Any] = adapter(kind).dump_python(self, mode="json")
            return fields
        record: dict[str, Any] = {}
        for key, path in self.JSON.items():
            value: Any = self
            for name in path.split("."):
                value = None if value is None else getattr(value, name)
            record |= to_json(value) if key.startswith("**") else {key: to_json(value)}
        return record

    def to_frame(self) -> pd.DataFrame:
        """Return the rows as a table, the keys of each as columns."""
        return frame_of(getattr(self, self.ROWS) if self.ROWS else [self])


class Result(Record, ABC):
    """A result that a notebook shows in a few lines, and that draws itself.

    A subclass has ``summary`` and ``draw``; as a dataclass it leaves ``repr`` to this class.
    """

    @abstractmethod
    def summary(self) -> Mapping[str, str]:
        """Return what the result says of itself, a line each: at most five."""

    @abstractmethod
    def draw(self) -> Figure:
        """Return the figure behind ``plot``, in whatever style is set."""

    def plot(self) -> Figure:
        """Return a figure of the result, a matplotlib Figure whose axes name their units."""
        from harness.shown.figure import house_style

        with house_style():
            return self.draw()

    def __repr__(self) -> str:
        """Return the same lines for a terminal."""
        return "\n".join(f"{name}: {text}" for name, text in self.summary().items())

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><th scope='row' style='text-align:left'>{html.escape(name)}</th>"
            f"<td style='text-align:left'>{html.escape(text)}</td></tr>"
            for name, text in self.summary().items()
        )
        return f"<table><tbody>{rows}</tbody></table>"


def frame_of(rows: Iterable[Any]) -> pd.DataFrame:
    """Return a table with a row for each, its keys as columns."""
    import pandas as pd

    return pd.DataFrame([to_json(row) for row in rows])


T = TypeVar("T", bound=Record)


class Listing(list[T]):
    """A list of records, shown as a table."""

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each, its keys as columns."""
        return frame_of(self)

    def _repr_html_(self) -> str:
        frame = self.to_frame()
        plain = [name for name in frame if frame[name].map(_is_plain).all()]
        return str(frame[plain].to_html(index=False, na_rep=""))


def value_text(value: float, uncertainty: float, unit: str = "") -> str:
    """Return a value as a person writes it, to the first digit of its uncertainty.

    >>> value_text(10.206981, 0.00042, "deg")
    '10.2070 ± 0.0004 deg'
    """
    places = decimals(uncertainty)
    finite = math.isfinite(value) and math.isfinite(uncertainty) and uncertainty > 0.0
    if not finite or places > ROUND_OFF:
        return f"{number(value)} {unit}".rstrip()
    return f"{value:.{places}f} ± {uncertainty:.{places}f} {unit}".rstrip()


def number(value: float, digits: int = 8) -> str:
    """Return a number for a table; a dash for one that is missing."""
    return "-" if math.isnan(value) else f"{value:.{digits}g}"


def in_words(name: str, unit: str = "") -> str:
    """Return a quantity's name in words, without the unit that it ends in.

    >>> in_words("contact_time_s", "s"), in_words("spin_ratio", "1")
    ('contact time', 'spin ratio')
    """
    suffix = "_" + unit.replace("/", "_per_").replace(" ", "_")
    return (name.removesuffix(suffix) if unit else name).replace("_", " ")


def power(value: Any) -> str:
    """Return a number as a person writes a power of ten: ``1e6``, and ``3.2e5`` between them.

    >>> power(1e6), power(250000.0)
    ('1e6', '2.5e5')
    """
    mantissa, exponent = f"{value:.1e}".split("e")
    return f"{float(mantissa):g}e{int(exponent)}"


def decimals(uncertainty: float) -> int:
    """Return the decimals down to the first digit of an uncertainty; two digits after a 1."""
    if not math.isfinite(uncertainty) or uncertainty <= 0.0:
        return 6
    exponent = math.floor(math.log10(uncertainty))
    leading = round(uncertainty / 10.0**exponent)
    return max(0, 1 - exponent if leading == 1 else -exponent)


def _is_plain(value: Any) -> bool:
    return value is None or (isinstance(value, (str, int, float)) and len(str(value)) <= 80)
