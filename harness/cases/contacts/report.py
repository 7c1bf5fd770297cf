"""The pages of the contact cases: matrices of laws and systems, codes by laws, conventions.

All of it is read from the rows of a verification; the reference alone runs for a report.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from itertools import product
from typing import TYPE_CHECKING, Any, cast

import pandas as pd

from harness.cases.bench import OWN, Bench
from harness.cases.checks import ROUND_OFF
from harness.model.conventions import Rules
from harness.report.content import Section, Table

if TYPE_CHECKING:
    from harness.cases.contacts.contact_case import ContactCase, Trial

    Codes = Mapping[str, Bench]

MATRIX = (
    "Largest difference from the reference at equal steps, in parts of the scale of a quantity. An "
    "empty cell was not run, or the code has no such contact."
)
BY_LAWS = (
    "Quantities within the tolerance, and the worst of them in parts of its scale; those beyond "
    "are known defects or failures, by the rows of the setup. Rows without a value are not "
    "counted. An empty cell: the code does not have the law."
)
CONVENTIONS = (
    "Where codes follow one law and differ: the value of a convention, its formula with the codes "
    "that have it, and the quantity that it moves most, in parts of its scale, by the reference "
    "with and without it. The formula ends in the size: h and h^2 of first and second order in the "
    "step, d/r of the overlap over the radius, 1 as large as the quantity. A slip of d/r adds up "
    "as two spheres turn about one another. What moves no quantity of these cases by more than "
    f"{ROUND_OFF:g} of its scale is left out. Sources: the manuals and public sources of the "
    "codes; a scene for each in tests/solvers/reference."
)


def sections(case: ContactCase[Any], benches: Codes) -> list[Section]:
    """Return the section of a case, after the overview of all for the first that was run."""
    codes = codes_by_title(benches)
    cases = [each for each in contact_cases() if any(b.rows[each.name] for b in codes.values())]
    before = [overview(cases, codes)] if case is next(iter(cases), None) else []
    return [*before, case_section(case, codes)]


def codes_by_title(benches: Codes) -> Codes:
    """Return the benches of engines by their title, by their name where engines share a title."""
    codes = {name: bench for name, bench in benches.items() if name != OWN}
    count = Counter(bench.engine.title for bench in codes.values())
    return {
        bench.engine.title if count[bench.engine.title] == 1 else name: bench
        for name, bench in codes.items()
    }


def contact_cases() -> Iterator[ContactCase[Any]]:
    """Yield the contact cases of this package."""
    from harness.cases.registry import GROUPS, get_case

    for name, home in GROUPS["contacts"].items():
        if home.startswith(__package__ or ""):
            yield cast("ContactCase[Any]", get_case(name))


def overview(cases: list[ContactCase[Any]], codes: Codes) -> Section:
    """Return codes by laws, and the conventions in which codes differ."""
    text = (
        "A code runs a scene once. The reference, a program written from the literature, takes the "
        "same steps by the conventions that the code declares, so that what differs is round-off "
        f"or a fault: a row passes within {ROUND_OFF:g} of the scale of its quantity."
    )
    tables = (
        Table("Codes by laws", codes_by_laws(cases, codes), BY_LAWS),
        Table("Conventions", conventions(cases, codes), CONVENTIONS),
    )
    return Section("DEM codes at equal steps", text, tables)


def case_section(case: ContactCase[Any], codes: Codes) -> Section:
    """Return the matrix of a case for each code that has run its checks."""
    tables = []
    for code, bench in codes.items():
        rows: dict[str, dict[str, str]] = {}
        for trial, sizes in differences([case], bench):
            rows.setdefault(trial.law, {"law": trial.law})[trial.system] = f"{max(sizes):.1e}"
        if rows:
            frame = pd.DataFrame(list(rows.values())).fillna("")
            tables.append(Table(f"{case.name}: {code}", frame, MATRIX))
    return Section(f"Contact: {case.name}", f"{case.summary} {case.formula}", tuple(tables))


def differences(
    cases: Iterable[ContactCase[Any]], bench: Bench
) -> Iterator[tuple[Trial, list[float]]]:
    """Yield the trials that a code has run, and how far each quantity is from the reference.

    In parts of its scale.
    """
    for case in cases:
        sizes: dict[str, list[float]] = {}
        names = {quantity.name for quantity in case.quantities}
        for row in bench.rows[case.name]:
            if row.quantity in names and not row.check and math.isfinite(row.difference):
                size = abs(row.difference) / row.tolerance * ROUND_OFF
                sizes.setdefault(row.setup, []).append(size)
        for trial in case.trials:
            if trial.setup in sizes:
                yield trial, sizes[trial.setup]


def codes_by_laws(cases: Iterable[ContactCase[Any]], codes: Codes) -> pd.DataFrame:
    """Return rows within the tolerance, the worst of them, and rows beyond, by law and code."""
    sizes: dict[str, dict[str, list[float]]] = {"all laws": {}}
    for code, bench in codes.items():
        for trial, more in differences(cases, bench):
            for law in ("all laws", trial.law):
                sizes.setdefault(law, {}).setdefault(code, []).extend(more)
    rows = [{"law": law, **{c: _cell(s) for c, s in by.items()}} for law, by in sizes.items()]
    return pd.DataFrame(rows).fillna("")


def _cell(sizes: list[float]) -> str:
    within = [size for size in sizes if size <= ROUND_OFF]
    beyond = len(sizes) - len(within)
    texts = [f"{len(within)} rows, {max(within):.0e}"] if within else []
    return "; ".join([*texts, *([f"{beyond} beyond"] if beyond else [])])


def conventions(cases: Iterable[ContactCase[Any]], codes: Codes) -> pd.DataFrame:
    """Return each convention of a code that moves a run, and the quantity that it moves most."""
    largest: dict[tuple[str, str, str], tuple[float, str]] = {}
    for case, (code, bench) in product(cases, codes.items()):
        for (name, value), (size, most) in bench.notes.get(case.name, {}).items():
            key = (name, code, value)
            largest[key] = max(largest.get(key, (0.0, "")), (size, most))
    rows = [
        {
            "convention": name,
            "code": code,
            "value": value,
            "formula": (Rules.model_fields[name].description or "").removeprefix("[-] "),
            "moves": f"{size:.0e}",
            "most": most,
        }
        for (name, code, value), (size, most) in sorted(largest.items())
    ]
    columns = ["convention", "code", "value", "formula", "moves", "most"]
    return pd.DataFrame(rows, columns=columns)


def moved_by_conventions(
    case: ContactCase[Any], bench: Bench
) -> dict[tuple[str, str], tuple[float, str]]:
    """Return how much each convention of a code moves the runs of a case, and what most.

    By the name and value of a convention that moves a quantity by more than round-off.
    """
    largest: dict[tuple[str, str], tuple[float, str]] = {}
    for trial, _ in differences([case], bench):
        rules = bench.rules(trial.scene)
        for name, value in rules.changed.items():
            field = Rules.model_fields[name]
            size, quantity = trial.moved(bench, rules.replace(**{name: field.default}))
            if size > largest.get((name, str(value)), (ROUND_OFF, ""))[0]:
                largest[name, str(value)] = size, f"{quantity} of {case.name}, {trial.setup}"
    return largest
