"""All that a verification found: checks, findings case by case, and what made them."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from harness.comparison.baseline_record import BaselineRecord
from harness.comparison.divergence import Comparison
from harness.comparison.engines import DeclaredEngine
from harness.comparison.findings import Findings, Headline
from harness.comparison.verdicts import Check, Verdict
from harness.observables.provenance import Provenance

if TYPE_CHECKING:
    import pandas as pd

SCHEMA = 2
"""Version of the published form of results.json; raised when a key goes or changes its meaning."""


@dataclass(frozen=True)
class Verification:
    """The result of ``verify``.

    ``main`` are the findings of each case in the main engine, ``own`` those of the harness's own
    solvers, ``beside`` those of other engines, by engine and case. ``checks`` are all of them with
    the rows against the baseline. ``status`` is the exit status: 3 when an engine died, 1 when a
    verdict failed, else 0. ``scripts`` are the exact inputs that ran, by name, ``logs`` the
    engine's log of one run that finished for each script, by the same names; ``records`` what was
    held against the baseline, ``divergences`` the series that left the band about their reference,
    ``baseline`` where the accepted ones lie. ``engines`` are those held beside the main one.
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
    records: tuple[BaselineRecord, ...] = ()
    divergences: tuple[Comparison, ...] = ()
    baseline: str = ""
    logs: Mapping[str, str] = field(default_factory=dict)

    @property
    def status(self) -> int:
        """Return the exit status that the verdicts ask for."""
        if self.engine_errors:
            return 3
        return 1 if any(check.verdict is Verdict.FAIL for check in self.checks) else 0

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
        import pandas as pd

        return pd.DataFrame([check.record() for check in self.checks])

    def record(self) -> dict[str, Any]:
        """Return everything but the series as a JSON-ready mapping: results.json."""
        published: dict[str, Any] = {}
        for found in self.findings():
            published |= found.published
        return {
            "schema": SCHEMA,
            "level": self.level,
            "cases": list(self.cases),
            "started": self.started,
            "seconds": self.seconds,
            "platform": self.platform,
            "harness_version": self.harness_version,
            "status": self.status,
            "engine": self.provenance.record() if self.provenance else None,
            "engine_errors": list(self.engine_errors),
            "baseline": self.baseline,
            "headlines": [vars(headline) for headline in self.headlines],
            "divergences": [series.record() for series in self.divergences],
            "checks": [check.record() for check in self.checks],
            "engines": self._engines(),
            "scripts": {
                name: hashlib.sha256(text.encode()).hexdigest()
                for name, text in self.scripts.items()
            },
            **published,
        }

    def _engines(self) -> dict[str, Any] | None:
        if not self.engines:
            return None
        published: dict[str, list[Any]] = {}
        for found in (f for by_case in self.beside.values() for f in by_case.values()):
            for name, rows in found.published.items():
                published.setdefault(name, []).extend(rows)
        return {"declared": [engine.record() for engine in self.engines], **published}
