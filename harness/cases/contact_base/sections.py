"""What a report says of a contact case: formulas, figures, and how to run each again."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from harness.cases.contact_base.evidence import Climbed, Evidence, Failed, Tried
from harness.cases.contact_base.formulas import formulas
from harness.cases.contact_base.reference import asked_for
from harness.cases.contact_base.scans import STEPS, Scanned
from harness.comparison.findings import Findings
from harness.parameters.contact_rules import Rules
from harness.report.sections import CellText, Drawing, Plot, Section, Table
from harness.shown import in_words

if TYPE_CHECKING:
    from harness.cases.contact_base.contact_case import ContactCase


def sections_of(
    case: ContactCase[Any], main: Findings, beside: Sequence[Findings] = ()
) -> Sequence[Section]:
    """Return one section with the figures of a case.

    Values, errors and runs are on pages of the matrix's cells, those of the engines ``beside``,
    too.
    """
    evidence: Evidence = main.evidence
    title = f"Contact: {case.name}"
    drawings = tuple(case.drawings(evidence)) if evidence.climbed and evidence.drawn else ()
    scans = [(one.evidence.who, one.evidence.scans) for one in beside if one.evidence]
    if any(found for _, found in scans):
        drawings = (codes_drawn(case, scans), *drawings)
    # the main engine may stand beside itself, with more submodels
    engines = {one.engine: one for one in (main, *beside) if one.evidence}
    cells = tuple(cell for one in engines.values() for cell in _cells(case, one))
    return (Section(title, (case.summary, case.formula), (), (), drawings, cells),)


def _cells(case: ContactCase[Any], found: Findings) -> Iterator[CellText]:
    """Yield what is told of each submodel, in all its systems in the order of the case."""
    evidence: Evidence = found.evidence
    systems = [*case.systems]
    by_submodel: dict[str, list[Tried]] = {}
    for one in evidence.tried:
        by_submodel.setdefault(one.trial.submodel, []).append(one)
    for name, cell in by_submodel.items():
        cell.sort(key=lambda one: systems.index(one.trial.system))
        failed = [one for one in cell if isinstance(one, Failed)]
        formula = Table(
            "The law",
            "n points to the first sphere, m* and R* are the reduced mass and radius.",
            ("part", "formula"),
            (*formulas(cell[0].finest.law), *_rules(case, cell)),
            prose=frozenset({1}),
        )
        yield CellText(
            case.name,
            name,
            found.engine,
            evidence.who,
            (
                case.summary,
                f"Expected: {case.formula}",
                *(f"{one.trial.system}: {evidence.who} {one.why}." for one in failed),
            ),
            (*_asked_of(case, failed), formula, _parameters(cell)),
            tuple(pair for one in cell for pair in _commands(case, one, found.engine)),
            partial(_plots, case, cell, evidence),
            frozenset(name for one in cell for name in _inputs(case, one)),
        )


def _commands(case: ContactCase[Any], one: Tried, engine: str) -> Iterator[tuple[str, str]]:
    """Yield what repeats a trial: by the harness, and by hand."""
    system = one.trial.system
    yield f"{system}: the case at its coarsest step", _again(case, one, engine)
    if one.command:
        which = "that failed" if isinstance(one, Failed) else "with the finest step"
        yield f"{system}: the run {which}", one.command


def _inputs(case: ContactCase[Any], one: Tried) -> tuple[str, str]:
    """Return the names of the scripts that state a trial: of all variants, or of its own."""
    job = case.job(one.trial.parameters)
    return job.template.name, f"{job.template.name}-{job.variant}"


def _asked_of(case: ContactCase[Any], failed: Sequence[Failed]) -> Iterator[Table]:
    """Yield a table of what is expected where an engine left nothing to hold against it."""
    units = {quantity.name: quantity.unit for quantity in case.quantities}
    rows = tuple(
        (
            one.trial.system,
            in_words(name, units[name]),
            f"{told.value:.9g}",
            units[name].removeprefix("1"),
            told.kind,
        )
        for one in failed
        for name, told in one.references.items()
        if math.isfinite(told.value)
    )
    if rows:
        yield Table(
            "What the law asks for",
            "Where the run left nothing to be held against it.",
            ("system", "quantity", "reference", "unit", "by"),
            rows,
            frozenset({2}),
        )


def _plots(case: ContactCase[Any], cell: Sequence[Tried], evidence: Evidence) -> Sequence[Plot]:
    """Return the plots of a submodel; without the curves of the law at level quick."""
    from harness.cases.contact_base.curves import errors_plot

    found = []
    for one in cell:
        found += [case.plot(one, evidence.who)] if evidence.drawn else []
        found += [errors_plot(case, one)] if isinstance(one, Climbed) else []
    return found


def _rules(case: ContactCase[Any], cell: Sequence[Tried]) -> Iterator[tuple[str, str]]:
    """Yield the rules of the engine that are not the default ones and matter, in any system."""
    told: dict[str, Any] = {}
    for one in cell:
        rules = asked_for(case.scene(one.finest), one.rules)
        told |= rules.model_dump(exclude_defaults=True)
    for name, value in told.items():
        meaning = (Rules.model_fields[name].description or "").partition("] ")[2]
        yield f"rule: {in_words(name)}", f"{in_words(str(value))} ({meaning})"


def _parameters(cell: Sequence[Tried]) -> Table:
    """Return what the first system is told, with units, and where the others differ."""
    rows = []
    for name, field in type(cell[0].finest).model_fields.items():
        values = [getattr(one.finest, name) for one in cell]
        if any(value is not None for value in values):
            unit, _, meaning = (field.description or "[-] ").removeprefix("[").partition("] ")
            told = [_told(value) for value in values]
            shown = (
                told[0]
                if len({*told}) == 1
                else "; ".join(
                    f"{one.trial.system}: {text}" for one, text in zip(cell, told, strict=True)
                )
            )
            rows.append((in_words(name), shown, "" if unit == "-" else unit, meaning))
    head = ("parameter", "value", "unit", "meaning")
    caption = "Of the run with the finest step; with --set NAME=VALUE, its words joined by _."
    return Table("Parameters", caption, head, tuple(rows), prose=frozenset({1, 3}))


def _told(value: Any) -> str:
    if value is None:
        return "none"
    return f"{value:.9g}" if isinstance(value, float) else str(value).lower()


def errors_drawn(case: ContactCase[Any], evidence: Evidence) -> Drawing:
    """Return the figure of the errors of a case's first quantity."""
    from harness.cases.contact_base.figures import errors_over_step
    from harness.report.figures.style import quantity

    first = next(one for one in case.quantities if one.name == (case.shown or one.name))
    words = in_words(first.name, first.unit)
    return Drawing(
        f"{case.name}-errors",
        f"{case.name}: error over the step",
        f"How far the {words} is from what the law asks for, over the steps of a contact; a panel "
        "for each family of submodels.",
        lambda: errors_over_step(
            evidence.climbed, first.name, quantity(words, first.unit), evidence.who
        ),
    )


def codes_drawn(case: ContactCase[Any], codes: Sequence[tuple[str, Sequence[Scanned]]]) -> Drawing:
    """Return the figure of a case with all codes, by their titles, on the reference curves."""
    from harness.cases.contact_base.figures import codes_over_parameter

    return Drawing(
        f"{case.name}-codes",
        f"{case.name}: all codes on the reference curve",
        "Lines: the law integrated, black under the default rules, in colour under a code's own; "
        f"marks: codes, {STEPS} steps a contact. Behind a name: how far it is at most from the law "
        "under its own rules, as a part of the largest value.",
        lambda: codes_over_parameter(case, codes),
    )


def _again(case: ContactCase[Any], one: Tried, engine: str) -> str:
    settings = " ".join(f"--set {name}={value}" for name, value in _changes(case, one))
    return f"dem-harness run {case.name} --engine {engine} {settings}"


def _changes(case: ContactCase[Any], one: Tried) -> Iterator[tuple[str, Any]]:
    """Yield what a trial changes of the default parameters."""
    base = dict(case.default)
    for name, value in one.trial.parameters:
        if value is not None and base[name] != value:
            yield name, str(value).lower() if isinstance(value, bool) else value
