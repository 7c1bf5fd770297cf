"""The texts and tolerances of a case, from the TOML file beside its module."""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.comparison.verdicts import Tolerance
from harness.report.sections import Drawing, Opening, Section, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def text_of(case: type) -> dict[str, Any]:
    """Return the content of the TOML file of a case's module; {} where there is none."""
    return _toml_of(getattr(sys.modules[case.__module__], "__file__", None) or "")


@cache
def _toml_of(module: str) -> dict[str, Any]:
    named = Path(module).with_suffix(".toml")
    file = named if named.is_file() else named.with_name("case.toml")
    return tomllib.loads(file.read_text("utf-8")) if file.is_file() else {}


def tolerances_of(module: str) -> dict[str, Tolerance]:
    """Return the tolerances that ``case.toml`` beside a module has, each with its reason."""
    return tolerances_in(_toml_of(module)["tolerances"])


def tolerances_in(tables: Mapping[str, Mapping[str, Any]]) -> dict[str, Tolerance]:
    """Return the tolerances of tables, by their names; what a table leaves out is nothing."""
    none = {"unit": "", "absolute": 0.0, "relative": 0.0}
    return {name: Tolerance(**{**none, **table}) for name, table in tables.items()}


class Words:
    """The texts of a report on a case, without its numbers, from ``case.toml`` of a module.

    ``figures`` have a title and a caption, ``sections`` a title and paragraphs, ``tables`` a
    caption and a head. Names in braces are replaced by the values passed.
    """

    def __init__(self, module: str) -> None:
        self._texts, self._folder = _toml_of(module), Path(module).parent

    def drawing(self, name: str, draw: Callable[[], Figure], **values: Any) -> Drawing:
        """Return a figure by its name, which is that of its file; raise KeyError for another."""
        title, caption = self._texts["figures"][name]
        file, title, caption = (text.format(**values) for text in (name, title, caption))
        return Drawing(file, title, caption, draw)

    def section(self, name: str, **parts: Any) -> Section:
        """Return a section with its ``parts``, those of :class:`Section`; raise KeyError."""
        texts = self._texts["sections"][name]
        further = parts.pop("paragraphs", ())
        return Section(texts["title"], (*texts.get("paragraphs", ()), *further), **parts)

    def opening(self, figure: str = "", **values: Any) -> Opening:
        """Return the report's opening with the case's sketch; raise KeyError for none."""
        texts = self._texts["opening"]
        return Opening(
            texts["title"],
            (self._folder / "sketch.svg").read_text("utf-8"),
            tuple(step.format(**values) for step in texts["steps"]),
            texts["source"],
            tuple(texts["terms"].items()),
            figure,
        )

    def table(
        self,
        name: str,
        rows: Sequence[tuple[str, ...]],
        **values: Any,
    ) -> Table:
        """Return a table by its label, with rows; raise KeyError for another."""
        texts = self._texts["tables"][name]
        caption = texts["caption"].format(**values)
        return Table(name, caption, tuple(texts["head"]), tuple(rows))
