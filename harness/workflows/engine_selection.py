"""Which engines are asked for: by name, or all that there are."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from harness.engines.registry import ALWAYS, engine_class, engine_names
from harness.errors import RequestError

ALL = "all"


@dataclass(frozen=True)
class EngineSelection:
    """The engines to compare, in order, and those of them that were asked for by name.

    Only one that was named must be here; of ``all`` an engine may be missing.
    """

    engines: tuple[str, ...] = ()
    named: frozenset[str] = frozenset()
    everything: bool = False

    def wants(self, engine: str) -> bool:
        """Return whether an engine was asked for, by name or among all."""
        return self.everything or engine in self.named


def asked_engines(wanted: str | Iterable[str]) -> EngineSelection:
    """Return the engines of ``all``, ``one`` or ``one,two``; none for no texts.

    Those that every comparison shows are always among them. Raise RequestError for a
    name that is not known, and for texts without a name.
    """
    texts = [wanted] if isinstance(wanted, str) else list(wanted)
    names = [name.strip() for text in texts for name in text.split(",") if name.strip()]
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
        if texts:
            raise RequestError(f"--engines {','.join(texts)!r}: names no engine")
        return EngineSelection()
    everything = ALL in names
    chosen = [name for name in known if everything or name in names or name in ALWAYS]
    others = [name for name in dict.fromkeys(names) if name not in (ALL, *known)]
    return EngineSelection((*chosen, *others), frozenset(names) - {ALL}, everything)
