"""What ``case.toml`` beside a case's module says: quantities, formula, tolerances, prose."""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.comparison.tolerances import Tolerance
from harness.report.sections import Drawing, Section, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def text_of(case: type) -> dict[str, Any]:
    """Return what stands in the file beside a case's module; {} where there is none."""
    return _beside(getattr(sys.modules[case.__module__], "__file__", None) or "")


@cache
def _beside(module: str) -> dict[str, Any]:
    file = Path(module).with_name("case.toml")
    return tomllib.loads(file.read_text("utf-8")) if file.is_file() else {}


def tolerances_of(module: str, section: str = "tolerances") -> dict[str, Tolerance]:
    """Return the tolerances that ``case.toml`` beside a module has, each with its reason.

    ``regression`` is the section of those of the baseline's records.
    """
    none = {"unit": "", "absolute": 0.0, "relative": 0.0}
    told = _beside(module)[section]
    return {name: Tolerance(**{**none, **one}) for name, one in told.items()}


class Words:
    """What a report says of a case but for its numbers, as ``case.toml`` beside a module has it.

    ``figures`` have a title and a caption, ``sections`` a title and paragraphs, ``tables`` a
    caption and a head. What stands in braces is a value that is given with the name.
    """

    def __init__(self, module: str) -> None:
        self._told = _beside(module)

    def drawing(self, name: str, draw: Callable[[], Figure], **values: Any) -> Drawing:
        """Return a figure by its name, which is that of its file; raise KeyError for another."""
        title, caption = self._told["figures"][name]
        file, title, caption = (text.format(**values) for text in (name, title, caption))
        return Drawing(file, title, caption, draw)

    def section(self, name: str, **parts: Any) -> Section:
        """Return a section with its ``parts``, those of :class:`Section`; raise KeyError."""
        told = self._told["sections"][name]
        further = parts.pop("paragraphs", ())
        return Section(told["title"], (*told.get("paragraphs", ()), *further), **parts)

    def table(
        self,
        name: str,
        rows: Sequence[tuple[str, ...]],
        numeric: Sequence[int] = (),
        prose: Sequence[int] = (),
        **values: Any,
    ) -> Table:
        """Return a table by its label, with rows; raise KeyError for another."""
        told = self._told["tables"][name]
        caption = told["caption"].format(**values)
        return Table(
            name, caption, tuple(told["head"]), tuple(rows), frozenset(numeric), frozenset(prose)
        )
