"""Which engines are asked for: by name, or all that there are."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from harness.engines.registry import ENGINES
from harness.errors import RequestError

ALL = "all"
ALWAYS = ("lammps", "reference")
"""Those that every comparison shows beside the others."""


@dataclass(frozen=True)
class Asked:
    """The engines to compare, in order, and those of them that were asked for by name.

    Only one that was named must be here; of ``all`` an engine may be missing.
    """

    engines: tuple[str, ...] = ()
    named: frozenset[str] = frozenset()
    everything: bool = False

    def wants(self, engine: str) -> bool:
        """Return whether an engine was asked for, also one that the registry does not have."""
        return self.everything or engine in self.named


def asked_engines(wanted: str | Iterable[str]) -> Asked:
    """Return the engines of ``all``, ``yade`` or ``yade,kratos``; none for no texts.

    LAMMPS and the reference DEM are always among them. Raise RequestError for a
    name that is not known, and for texts without a name.
    """
    texts = [wanted] if isinstance(wanted, str) else list(wanted)
    names = [name.strip() for text in texts for name in text.split(",") if name.strip()]
    for name in names:
        if name not in (ALL, *ENGINES):
            raise RequestError(
                f"--engines {name!r} is not known: must be {ALL}, or one or more of "
                f"{', '.join(ENGINES)}"
            )
    if not names:
        if texts:
            raise RequestError(f"--engines {','.join(texts)!r}: names no engine")
        return Asked()
    everything = ALL in names
    chosen = [e for e in ENGINES if everything or e in names or e in ALWAYS]
    return Asked(tuple(chosen), frozenset(names) - {ALL}, everything)
