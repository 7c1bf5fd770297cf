"""Render templates that lie in folders, the first folder that has one first."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness import __version__

if TYPE_CHECKING:
    from jinja2 import Environment

Folder = Traversable | Path


def text_in(folders: Sequence[Folder], file: str) -> str | None:
    """Return the text of a template of this name, or None where no folder has it."""
    for folder in folders:
        path = folder / file
        if path.is_file():
            return path.read_text(encoding="utf-8")
    return None


def renderer(
    folders: Sequence[Folder], file: str, options: Mapping[str, bool]
) -> Callable[[Mapping[str, Any]], str]:
    """Return a function from the values of a template to its text, ended by a line feed."""
    template = _environment(tuple(folders), tuple(sorted(options.items()))).get_template(file)

    def rendered(values: Mapping[str, Any]) -> str:
        text = template.render(version=__version__, **values)
        return text if text.endswith("\n") else text + "\n"

    return rendered


@cache  # what templates include is compiled once
def _environment(folders: tuple[Folder, ...], options: tuple[tuple[str, bool], ...]) -> Environment:
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    chosen: dict[str, Any] = {
        "trim_blocks": True,
        "lstrip_blocks": False,
        "keep_trailing_newline": True,
    }
    chosen |= options
    return Environment(
        loader=FunctionLoader(lambda name: text_in(folders, name)),
        undefined=StrictUndefined,
        autoescape=False,
        **chosen,
    )
