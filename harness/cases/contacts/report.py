"""The pages of the contact cases: matrices of laws and systems, codes, conventions, known defects.

Only runs of a verification appear: nothing runs for a report, but the reference.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, cast

import pandas as pd

from harness.cases.bench import OWN, Bench
from harness.cases.checks import ROUND_OFF, runs_at
from harness.errors import EngineError
from harness.model.conventions import Rules
from harness.report.content import Section, Table
from harness.store.committed import known_defects

if TYPE_CHECKING:
    from harness.cases.contacts.contact_case import ContactCase, Trial

    Codes = Mapping[str, Bench]

COLUMNS = ("code", "case", "law", "system", "quantity", "difference")
MATRIX = (
    "Largest difference from the reference at equal steps, in parts of the scale of a quantity. An "
    "empty cell was not run, or the code has no such contact."
)
BY_LAWS = (
    "Quantities within the tolerance, and the worst of them in parts of its scale; those beyond "
    "are known defects or failures, by the rows of the setup. An empty cell: the code does not "
    "have the law."
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


def sections(case: ContactCase[Any], benches: Codes) -> list[Section]:
    """Return the section of a case, after the overview of all for the first that was run."""
    first = next((each for each in contact_cases() if each.listed), None)
    return [*([overview(benches)] if case is first else []), case_section(case, benches)]


def case_section(case: ContactCase[Any], benches: Codes) -> Section:
    """Return the matrix of a case for each code that has run its checks."""
    tables = []
    for code, rows in differences([case], codes(benches)).groupby("code", sort=False):
        frame = rows.pivot_table(
            index="law", columns="system", values="difference", aggfunc="max", sort=False
        )
        frame = frame.map("{:.1e}".format, na_action="ignore").fillna("")
        tables.append(
            Table(f"{case.name}: {code}", frame.reset_index().rename_axis(columns=None), MATRIX)
        )
    return Section(f"Contact: {case.name}", f"{case.summary} {case.formula}", tuple(tables))


def overview(benches: Codes) -> Section:
    """Return codes by laws, the conventions in which codes differ, known defects, and drawings."""
    cases = list(contact_cases())
    rows = differences(cases, codes(benches))
    text = (
        "A code runs a scene once. The reference, a program written from the literature, takes the "
        "same steps by the conventions that the code declares, so that what differs is round-off "
        f"or a fault: a row passes within {ROUND_OFF:g} of the scale of its quantity.\n\n"
        + "\n".join(f"- {_headline(str(code), each)}" for code, each in rows.groupby("code"))
    )
    tables = (
        Table("Codes by laws", codes_by_laws(rows), BY_LAWS),
        Table("Conventions", conventions(cases, codes(benches)), CONVENTIONS),
        Table("Known defects", defects(benches), DEFECTS),
    )
    drawings = [drawing for case in cases for drawing in case.drawings(benches)]
    return Section("DEM codes at equal steps", text, tables, tuple(drawings))


def codes(benches: Codes) -> dict[str, Bench]:
    """Return the benches of engines by their titles with versions."""
    titled = {}
    for bench in (bench for name, bench in benches.items() if name != OWN):
        title, version = bench.engine.title, bench.engine.identify().engine_version
        titled[version if version.startswith(title) else f"{title} {version}".strip()] = bench
    return titled


def contact_cases() -> Iterator[ContactCase[Any]]:
    """Yield the contact cases of this package."""
    from harness.cases.registry import GROUPS, get_case

    for name, home in GROUPS["contacts"].items():
        if home.startswith(__package__ or ""):
            yield cast("ContactCase[Any]", get_case(name))


def differences(cases: list[ContactCase[Any]], titled: Codes) -> pd.DataFrame:
    """Return the difference of each quantity that a code has run from the reference [scale]."""
    rows = [
        (code, trial.case.name, trial.law, trial.system, quantity, difference)
        for code, bench in titled.items()
        for trial in _run_trials(cases, bench)
        for quantity, difference in trial.differences(bench).items()
    ]
    return pd.DataFrame(rows, columns=[*COLUMNS])


def _run_trials(cases: list[ContactCase[Any]], bench: Bench) -> Iterator[Trial]:
    """Yield the trials that a code has run to their ends; no scene of others is made."""
    for case in cases:
        level = case.listed.get(bench.name)
        for trial in case.trials() if level else ():
            try:
                if runs_at(trial.level, level or "quick") and bench.has_run([trial.job]):
                    trial.differences(bench)
                    yield trial
            except EngineError:
                continue


def codes_by_laws(rows: pd.DataFrame) -> pd.DataFrame:
    """Return rows within the tolerance, the worst of them, and rows beyond, by law and code."""
    table = pd.concat([rows.assign(law="all laws"), rows]).pivot_table(
        index="law", columns="code", values="difference", aggfunc=_cell, sort=False
    )
    return table.fillna("").reset_index().rename_axis(columns=None)


def _cell(values: pd.Series[float]) -> str:
    within = values[values <= ROUND_OFF]
    beyond = len(values) - len(within)
    texts = [f"{len(within)} rows, {within.max():.0e}"] if len(within) else []
    return "; ".join([*texts, *([f"{beyond} beyond"] if beyond else [])])


def _headline(code: str, rows: pd.DataFrame) -> str:
    within = sorted(rows["difference"][rows["difference"] <= ROUND_OFF])
    laws, contacts = rows["law"].nunique(), len(rows.groupby(["case", "law", "system"]))
    text = f"{code}: {len(within)} of {len(rows)} quantities in {contacts} contacts of {laws} laws"
    nine_tenths = f"{within[int(0.9 * (len(within) - 1))]:.0e}" if within else "0"
    return f"{text} within {ROUND_OFF:g}, nine of ten of these within {nine_tenths}"


def conventions(cases: list[ContactCase[Any]], titled: Codes) -> pd.DataFrame:
    """Return each convention of a code that moves a run, and the quantity that it moves most."""
    rows = []
    for code, bench in titled.items():
        for trial in _run_trials(cases, bench):
            rules = bench.rules(trial.scene)
            for name, value in rules.changed.items():
                field = Rules.model_fields[name]
                size, quantity = trial.moved(rules, rules.replace(**{name: field.default}))
                formula = (field.description or "").removeprefix("[-] ")
                most = f"{quantity} of {trial.case.name}, {trial.setup}"
                rows.append((name, code, str(value), formula, size, most))
    columns = ["convention", "code", "value", "formula", "moves", "most"]
    table = pd.DataFrame(rows, columns=columns).query("moves > 0.0")
    table = table.loc[table.groupby(columns[:3])["moves"].idxmax()].sort_values(columns[:3])
    return table.assign(moves=table["moves"].map("{:.0e}".format)).reset_index(drop=True)


def defects(benches: Codes) -> pd.DataFrame:
    """Return the known defects of the codes, with cause, releases and script."""
    names = {bench.name for name, bench in benches.items() if name != OWN}
    columns = ["code", "name", "kind", "releases", "cause", "effect", "upstream", "script"]
    rows = []
    for d in known_defects():
        ends = [f"from {d.since}"] * bool(d.since) + [f"to {d.until}"] * bool(d.until)
        releases = " ".join(ends) or "all"
        if d.engine in names:
            rows.append(
                (d.engine, d.name, d.kind, releases, d.cause, d.effect, d.upstream, d.script)
            )
    return pd.DataFrame(rows, columns=columns)
