"""What a verification found: findings of each case and engine, the whole run, its published form.

The dataclasses are the one source of results.json: the file is their dump, and
:func:`harness.workflows.diff` reads runs with them. Beside their keys stand those that cases
publish, which each case documents.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import computed_field

from harness.comparison.known_defects import KnownDefect
from harness.comparison.regression import BaselineRecord
from harness.comparison.series import Comparison
from harness.comparison.verdicts import Check, Verdict
from harness.errors import EngineError
from harness.observables.provenance import Provenance
from harness.observables.row import Number, Row
from harness.shown import Result, adapter, to_json, value_text

if TYPE_CHECKING:
    from harness.shown.figure import Figure


@dataclass(frozen=True)
class DeclaredEngine:
    """An engine's declared rules, copied for the report, and whether its results were used.

    ``version`` is empty where it could not be run, ``missing`` says why; ``unqualified``
    names the checks of its qualification that failed. ``lineage`` is the engine
    that it grew out of.
    """

    engine: str
    version: str
    how: str
    install_hint: str
    versions: tuple[str, ...]
    integrator: str
    tails: tuple[str, ...]
    effective_masses: tuple[str, ...]
    digits: int
    lineage: str
    caveats: tuple[str, ...]
    missing: str = ""
    unqualified: str = ""

    @computed_field  # type: ignore[prop-decorator]
    @property
    def summary(self) -> str:
        """Return whether the engine was used, and why not."""
        if self.missing:
            return "missing"
        return "did not qualify" if self.unqualified else "qualified"


@dataclass
class Findings:
    """What a case found in an engine (or in the harness's own solvers, ``engine`` empty).

    ``records`` are the values held against the baseline, ``errors`` those of records whose run
    died, by the record's name, ``untested`` why a record could not be made, by its name or a
    pattern of names (``*``, ``?``); ``divergences`` the series that left the band about their
    reference. ``published`` are keys of results.json. ``evidence`` is the case's own: what its
    sections are made from.
    """

    case: str
    engine: str = ""
    checks: list[Check] = field(default_factory=list)
    records: list[BaselineRecord] = field(default_factory=list)
    errors: dict[str, EngineError] = field(default_factory=dict)
    untested: dict[str, str] = field(default_factory=dict)
    divergences: list[Comparison] = field(default_factory=list)
    headlines: list[Row] = field(default_factory=list)
    published: Mapping[str, Any] = field(default_factory=dict)
    evidence: Any = field(default=None, repr=False)

    def add(self, other: Findings) -> None:
        """Add the records, errors and headlines of a part of the case."""
        self.records += other.records
        self.errors |= other.errors
        self.headlines += other.headlines


SCHEMA = 2
"""Version of this form; raised when a key goes or changes its meaning."""


@dataclass(frozen=True)
class DivergenceRow:
    """A series that left the band about its reference, and when.

    ``largest_difference`` is over the whole series, ``band`` the largest that passes;
    ``divergence_time_s`` is the first time outside for good [s], ``stays`` whether it is outside
    up to the end.
    """

    case: str
    column: str
    largest_difference: Number
    band: Number
    divergence_time_s: Number
    from_first_step: bool | None = None
    stays: bool | None = None


@dataclass(frozen=True)
class Engines:
    """What other engines than the main one declare; cases add keys of their own."""

    declared: tuple[DeclaredEngine, ...] = ()


@dataclass(frozen=True)
class Results:
    """One verification run, as results.json holds it.

    ``schema`` is the version of this form. ``level`` is quick,
    default or full; ``started`` ISO 8601 in UTC; ``seconds`` the wall time [s]; ``status`` the
    exit status: 0 holds, 1 a verdict failed, 3 an engine died, or a case that was asked for by
    name tested nothing (``untested_cases``). ``engine`` is null when none could
    be run, ``engines`` when none were compared. ``baseline`` is where the accepted values lie,
    empty without them, ``baseline_sha256`` their digest; ``scripts`` maps the name of each script
    that ran to its SHA-256. ``strict`` says that what is not tested counts as a failure.
    """

    level: str
    started: str
    seconds: Number
    platform: str
    harness_version: str
    status: int
    engine: Provenance | None
    checks: tuple[Check, ...]
    schema: int = SCHEMA
    cases: tuple[str, ...] = ()
    strict: bool = False
    engine_errors: tuple[str, ...] = ()
    untested_cases: tuple[str, ...] = ()
    baseline: str = ""
    baseline_sha256: str = ""
    headlines: tuple[Row, ...] = ()
    divergences: tuple[DivergenceRow, ...] = ()
    engines: Engines | None = None
    scripts: Mapping[str, str] = field(default_factory=dict)


def read_published(record: Any) -> Results:
    """Return a run from its JSON value; keys that are not known are passed over.

    Raise pydantic.ValidationError for a value that is no run.
    """
    results: Results = adapter(Results).validate_python(record)
    return results


@dataclass(frozen=True, repr=False)
class Verification(Result):
    """The result of ``verify``.

    ``main`` are the findings of each case in the main engine, ``solvers`` those of the harness's
    own solvers, ``others`` those of other engines, by engine and case. ``checks`` are all of them
    with the rows against the baseline. ``untested_cases`` were asked for by name, and no engine
    tested anything of them. ``status`` is the exit status: 3 where there are such or an engine
    died, 1 when a verdict failed, else 0. ``scripts`` are the exact inputs that ran, by name,
    ``logs`` the engine's log of one run that finished for each script, by the same names;
    ``records`` what was held against the baseline, ``divergences`` the series that left the band
    about their reference, ``baseline`` where the accepted ones lie and ``baseline_sha256`` their
    digest. ``engines`` are the others. ``defects`` are the known ones that
    checks are marked with, each with the script that shows it. With ``strict`` what is not tested
    counts as a failure.
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
    solvers: Mapping[str, Findings] = field(default_factory=dict)
    others: Mapping[str, Mapping[str, Findings]] = field(default_factory=dict)
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

    ROWS: ClassVar = "checks"

    @property
    def status(self) -> int:
        """Return the exit status that the verdicts ask for."""
        if self.engine_errors or self.untested_cases:
            return 3
        counted = {Verdict.FAIL, Verdict.NOT_TESTED} if self.strict else {Verdict.FAIL}
        return 1 if any(check.verdict in counted for check in self.checks) else 0

    @property
    def headlines(self) -> tuple[Row, ...]:
        """Return the results that a report opens with."""
        return tuple(headline for finding in self.findings() for headline in finding.headlines)

    def findings(self) -> Iterator[Findings]:
        """Yield the findings of the main engine, then those of own solvers, case by case."""
        yield from self.main.values()
        yield from self.solvers.values()

    def of_case(self, case: str) -> dict[str, Findings]:
        """Return the findings of a case in engines other than the main one, by engine."""
        return {engine: by_case[case] for engine, by_case in self.others.items() if case in by_case}

    def summary(self) -> dict[str, str]:
        """Return the verdicts counted by kind, the headline, and who was verified."""
        headlines = [
            f"{h.name}: {value_text(h.value, h.uncertainty, h.unit)}" for h in self.headlines[:1]
        ]
        return {
            "verdicts": counted(self.checks),
            **({"headline": headlines[0]} if headlines else {}),
            "cases": f"{', '.join(self.cases)}; {self.level}",
            "engine": self.provenance.label if self.provenance else "none",
        }

    def draw(self) -> Figure:
        """Draw how much of its tolerance each row takes."""
        return beside_tolerances(self.checks)

    @property
    def results(self) -> Results:
        """Return everything but the series, as it is published."""
        computed: dict[str, Any] = {
            "engine": self.provenance,
            "divergences": tuple(
                DivergenceRow(**divergence.to_json()) for divergence in self.divergences
            ),
            "engines": Engines(self.engines) if self.engines else None,
            "scripts": {
                name: hashlib.sha256(text.encode()).hexdigest()
                for name, text in self.scripts.items()
            },
        }
        same = {f.name: getattr(self, f.name) for f in fields(Results) if hasattr(self, f.name)}
        return Results(**{**same, **computed})

    def to_json(self) -> dict[str, Any]:
        """Return the results with the keys of the cases as a JSON-ready mapping: results.json.

        What cases publish of other engines stands under ``engines``, their rows
        one after the other.
        """
        record: dict[str, Any] = to_json(self.results)
        for findings in self.findings():
            record |= findings.published
        for findings in (f for by_case in self.others.values() for f in by_case.values()):
            for name, rows in findings.published.items():
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
