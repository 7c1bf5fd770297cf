"""How a result shows itself to whoever asks for it in Python: a few lines, and a figure."""

from __future__ import annotations

import html
import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

if TYPE_CHECKING:
    import pandas as pd

    from harness.shown.figure import Figure

ROUND_OFF = 14
"""Decimals beyond which an uncertainty says nothing."""


class Shown(ABC):
    """A result that a notebook shows in a few lines, and that draws itself.

    A subclass has ``summary`` and ``drawn``; as a dataclass it leaves ``repr`` to this class.
    """

    @abstractmethod
    def summary(self) -> Mapping[str, str]:
        """Return what the result says of itself, a line each: at most five."""

    @abstractmethod
    def drawn(self) -> Figure:
        """Return the figure behind ``plot``, in whatever style is set."""

    def plot(self) -> Figure:
        """Return a figure of the result, a matplotlib Figure whose axes name their units."""
        from harness.shown.figure import house_style

        with house_style():
            return self.drawn()

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


def record_frame(rows: Iterable[Recorded]) -> pd.DataFrame:
    """Return a table with a row for each, the keys of its record as columns."""
    import pandas as pd

    return pd.DataFrame([row.record() for row in rows])


class Recorded(Protocol):
    """What has a record for a row of a table."""

    def record(self) -> dict[str, Any]:
        """Return it as a JSON-ready mapping."""


T = TypeVar("T", bound=Recorded)


class Listing(list[T]):
    """A list of things that have a ``record``, shown as a table."""

    def frame(self) -> pd.DataFrame:
        """Return a row for each, the keys of its record as columns."""
        return record_frame(self)

    def _repr_html_(self) -> str:
        frame = self.frame()
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
