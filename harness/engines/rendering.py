"""Render templates that lie in folders, the first folder that has one first."""

from __future__ import annotations

import contextlib
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness import __version__
from harness.errors import EngineError, HarnessError

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
    with _named(file):
        template = _environment(tuple(folders), tuple(sorted(options.items()))).get_template(file)

    def rendered(values: Mapping[str, Any]) -> str:
        with _named(file):
            text = template.render(version=__version__, **values)
        return text if text.endswith("\n") else text + "\n"

    return rendered


@contextlib.contextmanager
def _named(file: str) -> Iterator[None]:
    """Raise EngineError, with file and line, for a template that cannot be rendered."""
    try:
        yield
    except HarnessError:
        raise
    except Exception as error:
        frames = traceback.extract_tb(error.__traceback__)
        places = [(frame.filename, frame.lineno) for frame in frames if ".j2" in frame.filename]
        if (line := getattr(error, "lineno", None)) is not None:
            places.append((getattr(error, "name", None) or file, line))
        where, line = places[-1] if places else (file, None)
        place = f"{where}, line {line}" if line else where
        said = " ".join(str(error).split())[:160]
        raise EngineError(
            f"template {place} cannot be rendered: {type(error).__name__}: {said}"
        ) from error


def _source(folders: Sequence[Folder], name: str) -> tuple[str, str, None] | None:
    """Return a template with its name, by which errors know it."""
    text = text_in(folders, name)
    return None if text is None else (text, name, None)


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
        loader=FunctionLoader(lambda name: _source(folders, name)),
        undefined=StrictUndefined,
        autoescape=False,
        **chosen,
    )
