"""What the source says: ``source.toml`` as frozen objects, in the order of the publication."""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass
from importlib import resources
from typing import Any

from harness.reproduction.wording import evaluated

_REASONS = {
    "round-off": "two routes in double precision, numbers of about 1: round-off",
    "last digit": "half of the last digit printed",
    "rows": "the rows named must stand as the erratum says",
}


@dataclass(frozen=True)
class Source:
    """A place in the publication, and what stands there.

    ``key`` is unique (``eq-6``, ``table-1-well``, ``text-t-c``, ``fig-4``, ``erratum-3``);
    ``where`` names section and number; ``says`` is one sentence or formula. ``formula`` computes
    what it gives exactly as it is printed, right or wrong, or ``holds`` is a condition on the
    numbers of a run; ``repaired`` is the same once it is corrected. ``finds`` is what a run finds,
    with its numbers in braces, and ``facts`` are
    the conditions and sentences of its parts. ``tolerance``
    [``unit``] is how far printed and found may lie apart, ``why`` where it comes from.
    ``evidence`` are links, relative to the report's folder or the repository
    (``figures/x.svg``, ``tests/theory/test_shock.py``). ``title`` is that of a figure;
    ``wrong`` and ``right`` are the statements that an erratum is about.
    """

    key: str
    where: str
    says: str
    formula: str = ""
    holds: str = ""
    repaired: str = ""
    finds: str = "{computed}"
    facts: tuple[tuple[str, str], ...] = ()
    tolerance: float = math.nan
    unit: str = ""
    why: str = ""
    correction: str = ""
    evidence: tuple[str, ...] = ()
    untestable: str = ""
    title: str = ""
    picture: str = ""
    wrong: tuple[str, ...] = ()
    right: tuple[str, ...] = ()

    def printed(self, **numbers: Any) -> Any:
        """Return what the formula gives as it is printed, of numbers and arrays alike."""
        return evaluated(self.formula, numbers)

    def corrected(self, **numbers: Any) -> Any:
        """Return what the formula gives once it is corrected; NaN without a correction."""
        return evaluated(self.repaired or "nan", numbers)


def _source(key: str, entry: dict[str, Any]) -> Source:
    fields: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in entry.items()}
    if "tolerance" in fields:
        fields["tolerance"], fields["unit"] = fields["tolerance"]
    if name := fields.pop("name", ""):
        fields["picture"] = f"fig-{int(key.removeprefix('fig-')):02d}-{name}"
        fields["evidence"] = (f"figures/{fields['picture']}.svg",)
        fields.setdefault("finds", "{facts}")
    elif "evidence" in fields:
        fields["evidence"] = tuple(f"tests/{test}.py" for test in fields["evidence"])
    why = "rows" if "wrong" in fields else fields.get("why", "")
    fields["why"] = _REASONS.get(why, why)
    return Source(key, **fields)


_TEXT = resources.files("harness.reproduction").joinpath("source.toml").read_text("utf-8")
SOURCES = {key: _source(key, entry) for key, entry in tomllib.loads(_TEXT).items()}
FIGURES = {key: source for key, source in SOURCES.items() if source.title}


def named_source(source: Source | str) -> Source:
    """Return the source of a key; raise KeyError for one that the publication has not."""
    return SOURCES[source] if isinstance(source, str) else source
