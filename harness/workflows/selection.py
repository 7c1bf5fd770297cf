"""Names of engines and cases in texts with commas; light enough for a kept verification."""

from __future__ import annotations

from collections.abc import Iterable

from harness.cases.registry import ALL
from harness.engines.registry import engine_class, engine_names
from harness.errors import RequestError


def selected_engines(engines: str | Iterable[str]) -> list[str]:
    """Return the names of engines; raise RequestError for an unknown one, and for none."""
    names = list(dict.fromkeys(words_in(engines)))
    known = engine_names()
    for name in names:
        if ":" in name:
            engine_class(name)  # module:Class, which raises where there is none
        elif name not in (ALL, *known):
            raise RequestError(
                f"--engines {name!r} is not known: must be {ALL}, or one or more of "
                f"{', '.join(known)}"
            )
    if not names:
        raise RequestError(f"--engines {engines!r}: names no engine")
    others = [name for name in names if name not in (ALL, *known)]
    return [*(known if ALL in names else [n for n in names if n in known]), *others]


def words_in(texts: str | Iterable[str]) -> list[str]:
    """Return the words of a text with commas, or of several texts."""
    many = texts.split(",") if isinstance(texts, str) else texts
    return [text.strip() for text in many if text.strip()]
