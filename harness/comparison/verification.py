"""All that a verification found: checks, findings case by case, and what made them."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any

from harness.comparison.baseline_record import BaselineRecord
from harness.comparison.divergence import Comparison
from harness.comparison.engines import DeclaredEngine
from harness.comparison.findings import Findings, Headline
from harness.comparison.known_defects import KnownDefect
from harness.comparison.published import published
from harness.comparison.results import SCHEMA as SCHEMA
from harness.comparison.results import DivergenceRow, Engines, Results
from harness.comparison.verdicts import Check, Verdict
from harness.observables.provenance import Provenance
from harness.shown import Shown, record_frame, value_text

if TYPE_CHECKING:
    import pandas as pd

    from harness.shown.figure import Figure


@dataclass(frozen=True, repr=False)
class Verification(Shown):
    """The result of ``verify``.

    ``main`` are the findings of each case in the main engine, ``own`` those of the harness's own
    solvers, ``beside`` those of other engines, by engine and case. ``checks`` are all of them with
    the rows against the baseline. ``untested_cases`` were asked for by name, and no engine tested
    anything of them. ``status`` is the exit status: 3 where there are such or an engine died, 1
    when a verdict failed, else 0. ``scripts`` are the exact inputs that ran, by name, ``logs`` the
    engine's log of one run that finished for each script, by the same names; ``records`` what was
    held against the baseline, ``divergences`` the series that left the band about their reference,
    ``baseline`` where the accepted ones lie and ``baseline_sha256`` their digest. ``engines`` are
    those held beside the main one. ``defects`` are the known ones that checks are marked with, each
    with the script that shows it. With ``strict`` what is not tested counts as a failure.
    """

    level: str
    cases: tuple[str, ...]
    started: str
    seconds: float
    platform: str
    harness_version: str
    provenance: Provenance | None
    checks: tuple[Check, ...]
    main: Mapping[str, Findings] = field(default_factory=dict)
    own: Mapping[str, Findings] = field(default_factory=dict)
    beside: Mapping[str, Mapping[str, Findings]] = field(default_factory=dict)
    engines: tuple[DeclaredEngine, ...] = ()
    scripts: Mapping[str, str] = field(default_factory=dict)
    engine_errors: tuple[str, ...] = ()
    untested_cases: tuple[str, ...] = ()
    records: tuple[BaselineRecord, ...] = ()
    divergences: tuple[Comparison, ...] = ()
    baseline: str = ""
    baseline_sha256: str = ""
    logs: Mapping[str, str] = field(default_factory=dict)
    strict: bool = False
    defects: tuple[tuple[KnownDefect, str], ...] = ()

    @property
    def status(self) -> int:
        """Return the exit status that the verdicts ask for."""
        if self.engine_errors or self.untested_cases:
            return 3
        counted = {Verdict.FAIL, Verdict.NOT_TESTED} if self.strict else {Verdict.FAIL}
        return 1 if any(check.verdict in counted for check in self.checks) else 0

    @property
    def headlines(self) -> tuple[Headline, ...]:
        """Return the results to be told first."""
        return tuple(headline for found in self.findings() for headline in found.headlines)

    def findings(self) -> Iterator[Findings]:
        """Yield the findings of the main engine, then those of own solvers, case by case."""
        yield from self.main.values()
        yield from self.own.values()

    def of_case(self, case: str) -> dict[str, Findings]:
        """Return the findings of a case in the engines beside the main one, by engine."""
        return {engine: found[case] for engine, found in self.beside.items() if case in found}

    def frame(self) -> pd.DataFrame:
        """Return the checks as a table, one row each."""
        return record_frame(self.checks)

    def told(self) -> dict[str, str]:
        """Return the verdicts counted by kind, the headline, and who was verified."""
        told = [
            f"{h.name}: {value_text(h.value, h.uncertainty, h.unit)}" for h in self.headlines[:1]
        ]
        return {
            "verdicts": counted(self.checks),
            **({"headline": told[0]} if told else {}),
            "cases": f"{', '.join(self.cases)}; {self.level}",
            "engine": self.provenance.told if self.provenance else "none",
        }

    def drawn(self) -> Figure:
        """Draw how much of its tolerance each row takes."""
        return beside_tolerances(self.checks)

    @property
    def results(self) -> Results:
        """Return everything but the series, as it is published."""
        told: dict[str, Any] = {
            "engine": self.provenance,
            "divergences": tuple(DivergenceRow(**one.record()) for one in self.divergences),
            "engines": Engines(self.engines) if self.engines else None,
            "scripts": {
                name: hashlib.sha256(text.encode()).hexdigest()
                for name, text in self.scripts.items()
            },
        }
        same = {f.name: getattr(self, f.name) for f in fields(Results) if hasattr(self, f.name)}
        return Results(**{**same, **told})

    def record(self) -> dict[str, Any]:
        """Return the results with the keys of the cases as a JSON-ready mapping: results.json.

        What cases publish of engines beside the main one stands under ``engines``, their rows
        one after the other.
        """
        record = published(self.results)
        for found in self.findings():
            record |= found.published
        for found in (f for by_case in self.beside.values() for f in by_case.values()):
            for name, rows in found.published.items():
                record["engines"].setdefault(name, []).extend(rows)
        return record


def counted(checks: Sequence[Check]) -> str:
    """Return how many rows of each kind have each verdict; kinds are never added up."""
    rows = Counter((check.kind, check.verdict) for check in checks)
    return "; ".join(f"{kind}: {number} {verdict}" for (kind, verdict), number in rows.items())


def beside_tolerances(checks: Sequence[Check]) -> Figure:
    """Draw the difference over the tolerance of each judged row, kind by kind."""
    from harness.shown.figure import beside_tolerance

    groups: dict[str, list[float]] = {}
    for check in checks:
        if check.judged and check.tolerance > 0.0:
            groups.setdefault(str(check.kind), []).append(check.difference / check.tolerance)
    return beside_tolerance(groups, "difference over its tolerance")
