"""What a report says of a contact case: formula, limits, figures, and how to run each again."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from harness.cases.contact_base.study import Climbed, Evidence
from harness.report.sections import Drawing, Section, Table

if TYPE_CHECKING:
    from harness.cases.contact_base.contact_case import ContactCase

HEAD = ("submodel", "system", "quantity", "limit", "uncertainty", "expected", "by", "order")


def sections_of(case: ContactCase[Any], evidence: Evidence) -> Sequence[Section]:
    """Return one section with the limits of a case in an engine, and a run of each to copy."""
    rows = tuple(row for one in evidence.climbed for row in _rows(one))
    limits = Table(
        f"Limits of {case.name}",
        f"Limits of a small step in {evidence.who}, beside what the law asks for.",
        HEAD,
        rows,
        frozenset({3, 4, 5, 7}),
    )
    commands = Table(
        f"Runs of {case.name}",
        "The coarsest run of each: its law, and the command that repeats it.",
        ("submodel", "system", "law", "run it again"),
        tuple(_run(case, one) for one in evidence.climbed),
        prose=frozenset({2, 3}),
    )
    title = f"Contact: {case.name}"
    drawings = tuple(case.drawings(evidence)) if evidence.climbed else ()
    return (Section(title, (case.summary, case.formula), (), (limits, commands), drawings),)


def errors_drawn(case: ContactCase[Any], evidence: Evidence) -> Drawing:
    """Return the figure of the errors of a case's first quantity."""
    from harness.cases.contact_base.figures import errors_over_step

    quantity = case.quantities[0].name
    return Drawing(
        f"{case.name}-errors",
        f"{case.name}: error over the step",
        f"How far {quantity} is from what the law asks for, over the steps of a contact.",
        lambda: errors_over_step(evidence.climbed, quantity, evidence.who),
    )


def _run(case: ContactCase[Any], one: Climbed) -> tuple[str, str, str, str]:
    law = one.trial.parameters.law.model_dump(exclude_none=True, exclude_defaults=True)
    told = ", ".join(f"{name} = {value}" for name, value in law.items()) or "the default"
    settings = " ".join(f"--set {name}={value}" for name, value in _changes(case, one))
    command = f"dem-harness run {case.name} {settings}"
    return one.trial.submodel, one.trial.system, told, command


def _changes(case: ContactCase[Any], one: Climbed) -> Iterator[tuple[str, Any]]:
    """Yield what a trial changes of the default parameters."""
    base = dict(case.default)
    for name, value in one.trial.parameters:
        if value is not None and base[name] != value:
            yield name, str(value).lower() if isinstance(value, bool) else value


def _rows(one: Climbed) -> Iterator[tuple[str, ...]]:
    for name, expected in one.references.items():
        reached = one.limits.get(name)
        if reached is None:
            continue
        yield (
            one.trial.submodel,
            one.trial.system,
            name,
            f"{reached.value:.9g}",
            f"{reached.uncertainty:.1e}",
            f"{expected.value:.9g}",
            expected.kind,
            f"{reached.order:.2f}",
        )
