"""The pages of the contact cases: the matrix of laws and systems, codes, conventions, defects.

Only what a verification has run is shown: nothing runs for a report, but the reference.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import pandas as pd

from harness.cases.bench import OWN, Bench
from harness.errors import EngineError
from harness.report.content import Section, Table

if TYPE_CHECKING:
    from harness.cases.contacts.contact_case import ContactCase, Trial


class Difference(NamedTuple):
    """A trial in an engine: the number of quantities, and the largest difference [scale]."""

    trial: Trial
    quantities: int
    worst: float


def case_section(case: ContactCase[Any], benches: Mapping[str, Bench]) -> Section:
    """Return the matrix of a case for each engine that has run its checks."""
    tables = [
        Table(
            f"{case.name}: {bench.engine.title}",
            matrix(differences(case, bench)),
            "Largest difference from the reference at equal steps, in parts of the scale of a "
            "quantity. An empty cell was not run, or the code states no such contact.",
        )
        for name, bench in benches.items()
        if name != OWN
    ]
    shown = tuple(table for table in tables if not table.frame.empty)
    return Section(f"Contact: {case.name}", f"{case.summary} {case.formula}", shown)


def differences(case: ContactCase[Any], bench: Bench) -> list[Difference]:
    """Return the trials of a case that an engine has run, without those that failed."""
    return [found for trial in case.trials() if (found := _difference(case, trial, bench))]


def _difference(case: ContactCase[Any], trial: Trial, bench: Bench) -> Difference | None:
    job = case.job(trial.parameters)
    if not bench.has_run([job]):
        return None
    try:
        found = case.differences(trial.parameters, bench)
    except EngineError:
        return None
    return Difference(trial, len(found), max(found.values(), default=0.0))


def matrix(rows: list[Difference]) -> pd.DataFrame:
    """Return the largest difference by law and system."""
    cells = [(row.trial.law, row.trial.system, f"{row.worst:.1e}") for row in rows]
    frame = pd.DataFrame(cells, columns=["law", "system", "difference"])
    if frame.empty:
        return frame
    table = frame.pivot_table(
        index="law", columns="system", values="difference", aggfunc="first", sort=False
    )
    return table.fillna("").reset_index()


def all_differences(bench: Bench) -> Iterator[tuple[ContactCase[Any], Difference]]:
    """Yield the trials of all contact cases that an engine has run."""
    from harness.cases.contacts.contact_case import ContactCase
    from harness.cases.registry import GROUPS, get_case

    for name in GROUPS["contacts"]:
        case = get_case(name)
        if isinstance(case, ContactCase):
            yield from ((case, row) for row in differences(case, bench))
