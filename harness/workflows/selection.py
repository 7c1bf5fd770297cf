"""Names of engines and cases in texts with commas; light enough for a kept verification."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from harness.cases.registry import ALL
from harness.engines.registry import engine_class, engine_names
from harness.errors import RequestError


def selected_engines(engines: str | Iterable[str], solvers: Sequence[str] = ()) -> list[str]:
    """Return the names of engines and solvers, in the order of the registry, then others.

    ``all`` stands for every engine and the solvers. Raise RequestError for an unknown name, and for
    none.
    """
    names, known = list(dict.fromkeys(words_in(engines))), [*engine_names(), *solvers]
    for name in names:
        if ":" in name:
            engine_class(name)  # module:Class, which raises where there is none
        elif name not in (ALL, *known):
            must = f"{ALL}, or one or more of {', '.join(known)}"
            raise RequestError(f"--engines {name!r} is not known: must be {must}")
    if not names:
        raise RequestError(f"--engines {engines!r}: names no engine")
    chosen = [name for name in names if name != ALL]
    return list(dict.fromkeys([*known, *chosen])) if ALL in names else chosen


def words_in(texts: str | Iterable[str]) -> list[str]:
    """Return the words of a text with commas, or of several texts."""
    many = texts.split(",") if isinstance(texts, str) else texts
    return [text.strip() for text in many if text.strip()]
