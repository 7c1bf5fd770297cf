"""Results in a notebook: a few lines, a table and a figure."""

from __future__ import annotations

import html
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

    from harness.report.style import Figure

LEFT = "style='text-align:left'"


class Summarized(ABC):
    """A result that shows its summary as text or HTML; a dataclass is declared ``repr=False``."""

    @abstractmethod
    def summary(self) -> Mapping[str, str]:
        """Return the main values, at most five, by name."""

    def __repr__(self) -> str:
        return "\n".join(f"{name}: {text}" for name, text in self.summary().items())

    def _repr_html_(self) -> str:
        texts = [map(html.escape, item) for item in self.summary().items()]
        rows = [f"<tr><th scope='row' {LEFT}>{a}</th><td {LEFT}>{b}</td></tr>" for a, b in texts]
        return f"<table><tbody>{''.join(rows)}</tbody></table>"


class Plottable(Summarized):
    """A result with a table and a figure too."""

    @abstractmethod
    def to_frame(self) -> pd.DataFrame:
        """Return the result as a table."""

    @abstractmethod
    def draw(self) -> Figure:
        """Return the figure behind :meth:`plot`, in the style that is set."""

    def plot(self) -> Figure:
        """Return a matplotlib figure of the result, whose axes have units."""
        from harness.report.style import house_style

        with house_style():
            return self.draw()
