"""The pages of the contact cases: matrices of laws and systems, codes, conventions, known defects.

Only runs of a verification are shown: nothing runs for a report, but the reference.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import pandas as pd

from harness.cases.bench import OWN, Bench
from harness.cases.checks import runs_at
from harness.cases.equal_steps import ROUND_OFF
from harness.errors import EngineError
from harness.model.conventions import Rules
from harness.report.content import Section, Table
from harness.store.committed import known_defects

if TYPE_CHECKING:
    from harness.cases.contacts.contact_case import ContactCase, Trial

Codes = Mapping[str, Bench]


class Difference(NamedTuple):
    """A trial in an engine: differences of its quantities from the reference [scale], by name."""

    trial: Trial
    of: Mapping[str, float]

    @property
    def worst(self) -> float:
        """Return the largest difference [scale]."""
        return max(self.of.values(), default=0.0)


def sections(case: ContactCase[Any], benches: Codes) -> list[Section]:
    """Return the section of a case, after the overview of all for the first that was run."""
    first = next((each for each in contact_cases() if each.listed), None)
    return [*([overview(benches)] if case is first else []), case_section(case, benches)]


def case_section(case: ContactCase[Any], benches: Codes) -> Section:
    """Return the matrix of a case for each code that has run its checks."""
    tables = []
    for code, bench in codes(benches).items():
        if not (frame := matrix(differences(case, bench))).empty:
            caption = (
                "Largest difference from the reference at equal steps, in parts of the scale of a "
                "quantity. An empty cell was not run, or the code states no such contact."
            )
            tables.append(Table(f"{case.name}: {code}", frame, caption))
    return Section(f"Contact: {case.name}", f"{case.summary} {case.formula}", tuple(tables))


def overview(benches: Codes) -> Section:
    """Return codes by laws, the conventions in which codes differ, known defects, and drawings."""
    found = {
        code: [row for case in contact_cases() for row in differences(case, bench)]
        for code, bench in codes(benches).items()
    }
    text = (
        "A code runs a scene once. The reference, a program written from the literature, takes the "
        "same steps by the conventions that the code declares, so that what differs is round-off "
        f"or a fault: a row passes within {ROUND_OFF:g} of the scale of its quantity.\n\n"
        + "\n".join(f"- {_headline(code, rows)}" for code, rows in found.items() if rows)
    )
    drawings = [drawing for case in contact_cases() for drawing in case.drawings(benches)]
    return Section(
        "DEM codes at equal steps",
        text,
        (
            Table("Codes by laws", codes_by_laws(found), BY_LAWS),
            Table("Conventions", conventions(benches, found), CONVENTIONS),
            Table("Known defects", defects(benches), DEFECTS),
        ),
        tuple(drawings),
    )


BY_LAWS = (
    "Quantities within the tolerance, and the worst of them in parts of its scale; those beyond "
    "are known defects or failures, by the rows of the setup. An empty cell: the code does not "
    "state the law."
)
CONVENTIONS = (
    "Where codes follow one law and differ: the value of a convention, its formula with the codes "
    "that have it, and the quantity that it moves most, in parts of its scale, by the reference "
    "with and without it. The formula ends in the size: h and h^2 of first and second order in the "
    "step, d/r of the overlap over the radius, 1 as large as the quantity. What moves no quantity "
    "of these cases is left out. Sources: the manuals and public sources of the codes; a scene for "
    "each in tests/solvers/reference."
)
DEFECTS = (
    "Each is a switch of the reference that reproduces the run, or is named with the reason why it "
    "has none. The script runs in the code alone, and prints what is expected and found."
)


def _headline(code: str, rows: list[Difference]) -> str:
    values = sorted(value for row in rows for value in row.of.values())
    within = [value for value in values if value <= ROUND_OFF]
    laws = len({row.trial.law for row in rows})
    return (
        f"{code}: {len(within)} of {len(values)} quantities in {len(rows)} contacts of {laws} laws "
        f"within {ROUND_OFF:g}, nine of ten of these within "
        f"{within[int(0.9 * (len(within) - 1))]:.0e}"
        if within
        else f"{code}: 0 of {len(values)} quantities within {ROUND_OFF:g}"
    )


def codes(benches: Codes) -> dict[str, Bench]:
    """Return the benches of engines by their titles with versions."""
    found = {}
    for name, bench in benches.items():
        if name != OWN:
            title, version = bench.engine.title, bench.engine.identify().engine_version
            found[version if version.startswith(title) else f"{title} {version}".strip()] = bench
    return found


def contact_cases() -> Iterator[ContactCase[Any]]:
    """Yield the contact cases of this package."""
    from harness.cases.registry import GROUPS, get_case

    for name, home in GROUPS["contacts"].items():
        if home.startswith(__package__ or ""):
            yield cast("ContactCase[Any]", get_case(name))


def differences(case: ContactCase[Any], bench: Bench) -> list[Difference]:
    """Return the trials of a case that a code has run to their ends."""
    found, level = list[Difference](), case.listed.get(bench.name)
    for trial in case.trials():
        if level is None or not runs_at(trial.level, level):
            continue  # no scene of others is made for a report
        try:
            run = trial.comparison
            if bench.has_run([run.job]):
                found.append(Difference(trial, run.differences(bench)))
        except EngineError:
            continue
    return found


def matrix(rows: Iterable[Difference]) -> pd.DataFrame:
    """Return the largest difference by law and system."""
    cells = [(row.trial.law, row.trial.system, f"{row.worst:.1e}") for row in rows]
    frame = pd.DataFrame(cells, columns=["law", "system", "difference"])
    if frame.empty:
        return frame
    table = frame.pivot_table(
        index="law", columns="system", values="difference", aggfunc="first", sort=False
    )
    return table.fillna("").reset_index().rename_axis(columns=None)


def codes_by_laws(found: Mapping[str, list[Difference]]) -> pd.DataFrame:
    """Return rows within the tolerance, the worst of them, and rows beyond, by law and code."""
    cells: dict[str, dict[str, list[float]]] = {}
    for code, rows in found.items():
        for row in rows:
            for law in (row.trial.law, "all laws"):
                cells.setdefault(law, {}).setdefault(code, []).extend(row.of.values())
    laws = sorted(cells, key=lambda law: law != "all laws")
    table = [
        {"law": law, **{code: _cell(cells[law].get(code, [])) for code in found}} for law in laws
    ]
    return pd.DataFrame(table, columns=["law", *found])


def _cell(values: list[float]) -> str:
    within = [value for value in values if value <= ROUND_OFF]
    beyond = len(values) - len(within)
    texts = [f"{len(within)} rows, {max(within):.0e}"] if within else []
    return "; ".join([*texts, *([f"{beyond} beyond"] if beyond else [])])


def conventions(benches: Codes, found: Mapping[str, list[Difference]]) -> pd.DataFrame:
    """Return each convention of a code that moves a run, and the quantity that it moves most."""
    table = []
    for code, bench in codes(benches).items():
        worst: dict[tuple[str, str], tuple[float, str]] = {}
        for row in found[code]:
            for field, word, size, name in _effects(row.trial, bench):
                if size > worst.get((field, word), (0.0, ""))[0]:
                    worst[field, word] = (
                        size,
                        f"{name} of {row.trial.case.name}, {row.trial.setup}",
                    )
        for (field, word), (size, where) in worst.items():
            formula = (Rules.model_fields[field].description or "").removeprefix("[-] ")
            table.append((field, code, word, formula, f"{size:.0e}", where))
    columns = ["convention", "code", "value", "formula", "moves", "most"]
    return pd.DataFrame(sorted(table), columns=columns)


def _effects(trial: Trial, bench: Bench) -> Iterator[tuple[str, str, float, str]]:
    """Yield conventions with their values, how far they move a quantity [scale], and its name."""
    run = trial.comparison
    rules = bench.rules(run.scene)
    for field, value in rules.changed.items():
        plain = rules.replace(**{field: Rules.model_fields[field].default})
        size, name = run.moved(rules, plain)
        yield field, str(value), size, name


def defects(benches: Codes) -> pd.DataFrame:
    """Return the known defects of the codes, with cause, releases and script."""
    names = {bench.name for name, bench in benches.items() if name != OWN}
    rows = [
        (d.engine, d.name, d.kind, _releases(d.since, d.until), d.cause, d.effect, d.upstream,
         d.script)
        for d in known_defects()
        if d.engine in names
    ]  # fmt: skip
    columns = ["code", "name", "kind", "releases", "cause", "effect", "upstream", "script"]
    return pd.DataFrame(rows, columns=columns)


def _releases(since: str, until: str) -> str:
    parts = ([f"from {since}"] if since else []) + ([f"to {until}"] if until else [])
    return " ".join(parts) or "all"
