"""Defects of releases that are known, with their cause and the size that this predicts.

A failure in a cell that a defect names is *known defect* where it has the size that the cause
predicts: shown, counted apart, never a pass. Another size is a failure, which names law, prediction
and value. A cell of a defect that holds in a release that is said to have it is *fixed*.

A defect of one of two releases moves the recorded run against the baseline, also where the limit of
a small step holds: by what both runs, step by step with the defects of each, differ. Another size
stays a failure.
"""

from __future__ import annotations

import math
import operator
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from functools import reduce
from typing import Literal, Self, get_args

from pydantic import Field, model_validator

from harness.comparison.regression import BaselineRecord, name_in_cell, row_name
from harness.comparison.verdicts import Check, PredictedSize, Triage, Verdict
from harness.observables.provenance import release_of
from harness.parameters.base import Parameters
from harness.parameters.rules import Rules

Formula = str | float | bool
"""A number, a word, or a formula of the coefficients of a law, as ``2 * damping_coefficient``."""

UNRECORDED = 1e-9
"""Sizes up to which a quantity has no value in a record."""

AGAIN = ("", "continued with a setup")
"""What a run in another release is: its values, and the same run made again."""


class Prediction(Parameters):
    """What the cause of a defect makes of a run: data from which a case computes values.

    ``law`` are coefficients that the engine takes instead of those that it was given, ``rules``
    rules of contacts (:class:`~harness.parameters.rules.Rules`) by which it computes:
    words, numbers, or formulas of the law's coefficients and the ``radius``. ``scheme`` are
    departures of its steps (:class:`~harness.solvers.pair.stepping.Departures`). Of two runs that
    an invariance compares both have it, or the one that ``of`` names. ``bound`` names how large
    a difference of two runs may be, of :mod:`harness.cases.contact.predictions`, where the
    cause fixes no number; ``undetermined`` says why it does not. ``error`` is a part of the
    message of a run that fails.
    """

    law: dict[str, Formula] = Field(default_factory=dict)
    rules: dict[str, Formula] = Field(default_factory=dict)
    scheme: dict[str, Formula] = Field(default_factory=dict)
    of: Literal["both", "run", "other run"] = "both"
    bound: str = ""
    undetermined: str = ""
    error: str = ""

    @model_validator(mode="after")
    def _says_something(self) -> Self:
        if not (self.law or self.rules or self.scheme or self.bound or self.error):
            raise ValueError("needs one of law, rules, scheme, bound, error")
        return self

    def __or__(self, other: Prediction) -> Prediction:
        """Return what two defects of one cell make of it together; the first has precedence."""
        return Prediction(
            law={**other.law, **self.law},
            rules={**other.rules, **self.rules},
            scheme={**other.scheme, **self.scheme},
            of=self.of,
            bound=self.bound or other.bound,
            undetermined=self.undetermined or other.undetermined,
            error=self.error or other.error,
        )


class KnownDefect(Parameters):
    """A defect: in which cells of which engine, from which release to which, why, of what size.

    ``cases``, ``submodels`` and ``systems`` are those of cells, with ``*`` and ``?``; ``since``
    and ``until`` the first and the last release that are known to have it, empty for no bound.
    ``invariances`` are those that it breaks, empty for one that makes values wrong. ``kind`` is
    another for a limitation that the engine's manual states. ``upstream`` is what the engine's
    developers wrote of it: manual, pull request, commit, release note; or "not reported".
    """

    name: str
    engine: str
    cases: tuple[str, ...] = Field(min_length=1)
    submodels: tuple[str, ...] = Field(min_length=1)
    systems: tuple[str, ...] = ("*",)
    invariances: tuple[str, ...] = ("",)
    kind: Literal["defect", "documented limitation"] = "defect"
    cause: str = Field(min_length=20)
    predicts: Prediction
    since: str = ""
    until: str = ""
    upstream: str = Field(min_length=5)
    script: str = ""

    def concerns(self, check: Check, versions: Mapping[str, str]) -> bool:
        """Return whether a check stands in a cell of the defect, in a release that has it."""
        cell = check.cell
        if cell is None:
            return False
        patterns = (self.cases, self.submodels, self.systems, (self.engine,), self.invariances)
        for name, allowed in zip(cell.place, patterns, strict=True):
            if not any(fnmatchcase(name, pattern) for pattern in allowed):
                return False
        here, last = release_of(versions.get(cell.engine, "")), release_of(self.until)
        if last and not here:
            return False  # a version that cannot be read is not known to have it
        return here >= release_of(self.since) and (not last or here[: len(last)] <= last)

    @property
    def note(self) -> str:
        """Return what a report says of it in a line."""
        pointer = f"; {self.script} shows it" if self.script else ""
        word = "known defect" if self.kind == "defect" else self.kind
        return f"{word} {self.name}: {self.cause}; upstream: {self.upstream}{pointer}"


def defect_of(check: Check) -> str:
    """Return the name of the known defect that a check was marked with; empty without one."""
    return check.cell.defect if check.cell is not None else ""


def mark_known_defects(
    checks: Iterable[Check], defects: Sequence[KnownDefect], versions: Mapping[str, str]
) -> tuple[Check, ...]:
    """Return the checks, failures of the size that a defect predicts and cells without it marked.

    ``versions`` are those of the engines by name. A defect is gone where every judged check of a
    cell holds, none is undecided (not tested, with a value), and one is not as predicted.
    """
    checks = tuple(checks)
    failing = {
        c.cell.place
        for c in checks
        if c.cell
        and (
            c.verdict is Verdict.FAIL
            or (c.verdict is Verdict.NOT_TESTED and not math.isnan(c.value))
        )
    }
    return tuple(_marked(check, defects, versions, failing) for check in checks)


def _marked(
    check: Check,
    defects: Sequence[KnownDefect],
    versions: Mapping[str, str],
    failing: set[tuple[str, str, str, str, str]],
) -> Check:
    bare = replace(check, predict=None)
    here = [defect for defect in defects if defect.concerns(check, versions)]
    undecided = check.verdict is Verdict.NOT_TESTED and not math.isnan(check.value)
    if not here or check.cell is None or not (check.judged or undecided):
        return bare
    holds = check.verdict is Verdict.PASS
    if holds and check.cell.place in failing:
        return bare
    ended = [defect for defect in here if _failed_as_predicted(check, defect)]
    sized = [defect for defect in here if not defect.predicts.error]
    if ended:
        here, expected, sentence, predicted = ended, None, "", True
    elif sized:
        value = replace(check, cell=replace(check.cell, invariance=""))
        beneath = [d for d in defects if check.cell.invariance and d.concerns(value, versions)]
        here = sized
        expected, sentence = _size(check, sized, [d for d in beneath if not d.predicts.error])
        predicted = expected is not None and expected.includes(check.value)
    else:
        message = here[0].predicts.error
        expected, sentence, predicted = (
            None,
            f"{here[0].name} predicts a run that ends: {message}",
            False,
        )
    # what is undecided against the law is decided against a prediction that excludes the law
    if undecided and not (predicted and expected and not expected.includes(check.expected)):
        return bare
    note = "; ".join(filter(None, (*(defect.note for defect in here), sentence, check.note)))
    if holds:
        if predicted or (sized and expected is None):
            return bare
        note = f"no longer there: {note}"
        verdict = Verdict.FIXED
    elif not predicted:
        return replace(bare, note="; ".join(filter(None, (sentence, check.note))))
    else:
        verdict = Verdict.KNOWN_DEFECT
    # the first is named: the others stand in the note
    marked = replace(bare, cell=replace(check.cell, defect=here[0].name), note=note)
    return replace(marked, verdict=verdict, engine_died=check.engine_died and holds)


def _failed_as_predicted(check: Check, defect: KnownDefect) -> bool:
    message = defect.predicts.error
    return bool(message) and math.isnan(check.value) and message in check.note


def _size(
    check: Check, defects: Sequence[KnownDefect], beneath: Sequence[KnownDefect]
) -> tuple[PredictedSize | None, str]:
    """Return what defects predict of a check, and a sentence with it and the value.

    Those ``beneath`` make the values of the runs wrong that an invariance compares.
    """
    names = " and ".join(defect.name for defect in defects)
    verb = "predicts" if len(defects) == 1 else "predict"
    together, under = merged(defects), merged(beneath)
    if together is None or check.predict is None:
        return None, f"what {names} {verb} of this row cannot be computed"
    try:
        size = check.predict(together, under)
    except (ArithmeticError, ValueError) as error:
        return None, f"what {names} {verb} of this row cannot be computed: {error}"
    return size, (
        f"{names} {verb} {size}, the law asks for {check.expected:.6g}, "
        f"the engine left {check.value:.6g}"
    )


def merged(defects: Sequence[KnownDefect]) -> Prediction | None:
    """Return what defects of one cell make of it together; None of none."""
    return reduce(operator.or_, (defect.predicts for defect in defects)) if defects else None


def moved_by_defects(
    rows: Sequence[Check],
    judged: Iterable[Check],
    records: Mapping[str, BaselineRecord],
    defects: Sequence[KnownDefect],
    versions: Mapping[str, str],
) -> tuple[Check, ...]:
    """Return rows against the baseline, failures of the size that defects predict marked.

    ``judged`` are the checks of the run with what predicts their sizes, ``records`` those of the
    baseline by name, and ``versions`` the engines' that ran.
    """
    of_rows = {}
    for check in judged:
        if check.cell is not None and not check.cell.invariance and hasattr(check.predict, "moved"):
            quantity = check.name.rpartition(": ")[2]
            of_rows[row_name(name_in_cell(check.cell), quantity)] = (check, quantity)
    marked = []
    for row in rows:
        moved = row.verdict is Verdict.FAIL and not row.triage.startswith(Triage.WRONG_INPUT)
        if moved and row.name in of_rows:
            check, quantity = of_rows[row.name]
            assert check.cell is not None
            record = records[name_in_cell(check.cell)]
            row = _marked_move(row, check, quantity, record, defects, versions)
        marked.append(row)
    return tuple(marked)


def _marked_move(
    row: Check,
    check: Check,
    quantity: str,
    record: BaselineRecord,
    defects: Sequence[KnownDefect],
    versions: Mapping[str, str],
) -> Check:
    here = _of_runs(check, defects, versions)
    there = _of_runs(check, defects, {record.engine: record.engine_version})
    apart = [defect for defect in (*here, *there) if (defect in here) is not (defect in there)]
    recorded = record.quantities.get(quantity)
    if not apart or recorded is None:
        return row
    there_is_none = math.isnan(row.value)
    difference = (0.0 if there_is_none else row.value) - recorded.value
    width = UNRECORDED if there_is_none else 2.0 * row.tolerance
    try:
        size = check.predict.moved(merged(here), merged(there), width)  # type: ignore[union-attr]
    except (ArithmeticError, ValueError) as error:
        return replace(row, note=f"{row.note}; what defects predict cannot be computed: {error}")
    names = " and ".join(
        f"{defect.name} ({'here' if defect in here else 'there'})" for defect in apart
    )
    sentence = f"{names} predict a difference of {size}, it is {difference:.6g}"
    note = "; ".join(filter(None, (*(defect.note for defect in apart), sentence, row.note)))
    if not size.includes(difference):
        return replace(row, note="; ".join(filter(None, (sentence, row.note))))
    return replace(row, verdict=Verdict.KNOWN_DEFECT, note=note, triage="")


def _of_runs(
    check: Check, defects: Sequence[KnownDefect], versions: Mapping[str, str]
) -> list[KnownDefect]:
    assert check.cell is not None
    runs = [replace(check, cell=replace(check.cell, invariance=name)) for name in AGAIN]
    return [
        defect
        for defect in defects
        if (defect.predicts.law or defect.predicts.rules or defect.predicts.scheme)
        and any(defect.concerns(run, versions) for run in runs)
    ]


SECONDS = 60.0
"""Of integrations for all rows that fail; what is left then says so."""

HOLDS, ALONE, NONE, SPENT = (
    "holds under {}",
    "this value alone holds under {}; other quantities of the contact do not",
    "no single rule of the harness reproduces it",
    "not searched for a rule that reproduces it: {:g} s of integrations are spent",
)


def with_single_rules(checks: Sequence[Check], raw: Sequence[Check]) -> tuple[Check, ...]:
    """Return the checks; the note of a failure says which single rule reproduces its value.

    ``raw`` are the same rows as their cases left them, which can still compute a prediction. A rule
    reproduces a row where the row would hold under it, within its own tolerance, and every other
    value of the same contact too.
    """
    end = time.monotonic() + SECONDS
    contacts: dict[tuple[str, ...], list[Check]] = {}
    for row in raw:
        if row.predict is not None and row.judged and row.cell and not row.cell.invariance:
            contacts.setdefault(row.cell.place, []).append(row)
    noted = []
    for check, row in zip(checks, raw, strict=True):
        if check.verdict is Verdict.FAIL and row.cell and row in contacts.get(row.cell.place, ()):
            spent = time.monotonic() > end
            others = contacts[row.cell.place]
            note = SPENT.format(SECONDS) if spent else _reproduced(row, others)
            check = replace(check, note="; ".join(filter(None, (check.note, note))))
        noted.append(check)
    return tuple(noted)


def _reproduced(row: Check, contact: Sequence[Check]) -> str:
    """Return the sentence on a row; ``contact`` are all rows of its contact."""
    alone = {words: rule for words, rule in _rules() if _holds(row, rule)}
    if not alone:
        return NONE
    full = [words for words, rule in alone.items() if all(_holds(check, rule) for check in contact)]
    return (HOLDS if full else ALONE).format(", or under ".join(full or alone))


def _rules() -> Iterator[tuple[str, Prediction]]:
    """Yield each word of each rule, as ``wall_lever = height``; factors are no choice of a code."""
    for name, field in Rules.model_fields.items():
        for word in get_args(field.annotation):
            yield f"{name} = {word}", Prediction(rules={name: word})


def _holds(row: Check, rule: Prediction) -> bool:
    """Return whether a row would hold under a rule; one under which it has no value does not."""
    try:
        return row.predict is not None and row.predict(rule, None).includes(row.value)
    except (ArithmeticError, ValueError):
        return False
