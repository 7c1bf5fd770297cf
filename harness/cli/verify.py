"""``dem-harness verify``: options, the verification or a kept one, and what is printed of it."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from harness.cli.options import (
    Cases,
    EngineOptions,
    File,
    Folder,
    Force,
    Json,
    Only,
    duration_check,
    opener,
)
from harness.cli.output import output_folder, print_wrapped, show, tell
from harness.errors import RequestError
from harness.results.rows import KEY, row_name

if TYPE_CHECKING:
    from harness.results.rows import Level

Record = Mapping[str, Any]
MOST_PRINTED = {"fail": 20, "known defect": 10, "fixed": 10, "not tested": 10, "finding": 5}
PACKAGES = ("jinja2", "matplotlib", "numba", "numpy", "pandas", "pydantic", "scipy")


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class VerifyOptions:
    """What is verified, and where the report goes."""

    quick: bool = False
    """The checks that take seconds."""
    full: bool = False
    """All checks, those of minutes and more among them."""
    cases: Cases = None
    engines: Annotated[str, Parameter(metavar="all|NAME[,NAME...]")] = "lammps"
    """These engines and no others; `all` is every installed engine."""
    only: Only = ""
    output: Folder = None
    """Folder for the report; must not hold anything yet. [default: reports/runs/ and the date]"""
    known_defects: File = None
    """More known defects than the committed ones, TOML as in inputs/known-defects.toml."""
    strict: bool = False
    """Exit status 1 also where a row was not tested."""
    png: bool = False
    """Write every figure as PNG too, not only as SVG."""
    verbose: bool = False
    """Print every row, not only those to look at."""
    force: Force = False

    @property
    def level(self) -> Level:
        """Return the level. Raise RequestError for two of them."""
        if self.quick and self.full:
            raise RequestError("--quick and --full: give one of them only")
        return "quick" if self.quick else "full" if self.full else "default"


def verify(
    choice: VerifyOptions = VerifyOptions(),
    engines: EngineOptions = EngineOptions(),
    *,
    json: Json = False,
) -> int:
    """Hold engines against theory, one another and the accepted run, and write a report.

    Prints what failed, known defects, what was not tested, and the verdicts by kind. The folder has
    report.html, report.md, rows.csv, junit.xml, figures and the scripts that ran.

    A verification that was made before, with the same engines, code and platform, is not made
    again: its report is written once more. An interrupted one goes on where it stopped.

    For example:

        dem-harness verify --quick --output mine

        dem-harness verify --engines lammps,liggghts --cases contacts
    """
    folder = output_folder(choice.output)
    record = verified(choice, engines, folder, quiet=json)
    if not json:
        _print(record, folder, verbose=choice.verbose)
    return show(record, json, {})


def verified(
    choice: VerifyOptions, engines: EngineOptions, folder: Path, *, quiet: bool = False
) -> dict[str, Any]:
    """Verify, or take what was verified before; write the report and return its record."""
    from harness.store.cache import keep_verification, kept_verification

    entries, key = engines.entries(), _key(choice, engines)
    if entries is not None and key is not None and not engines.fresh:
        kept = kept_verification(entries, key, folder)
        if kept is not None:
            return {**kept, "folder": str(folder), "cached": True}
    # imported late: a kept verification must not wait for pandas
    from harness.workflows import verify as verify_engines

    names = ("cases", "engines", "only", "strict", "known_defects", "png")
    instead = "--quick, or fewer cases"
    with opener(engines, "verify", quiet) as opening:
        record = verify_engines(
            choice.level,
            **{name: getattr(choice, name) for name in names},
            output=folder,
            open_engine=opening.opened,
            check_duration=duration_check(choice.force, f"level {choice.level}", instead),
            progress=opening.progress,
        ).to_json()
    if entries is not None and key is not None and record["status"] in (0, 1):
        keep_verification(entries, key, folder, record)
    return {**record, "folder": str(folder), "cached": False, **opening.runs()}


def details(row: Record) -> Iterator[str]:
    """Yield numbers, class of failure and note of a row, a line each."""
    if row["value"] is not None:
        text = f"{row['value']:.8g}"
        if row["expected"] is not None:
            text += f", expected {row['expected']:.8g}"
        text = f"{text} {row['unit'] if row['unit'] != '1' else ''}".rstrip()
        if row["difference"] is not None and row["tolerance"] is not None:
            text += f"; difference {row['difference']:.2g}, tolerance {row['tolerance']:.2g}"
        yield text
    yield from filter(None, (row["failure"], row["note"]))


def name_of(row: Record) -> str:
    """Return the name of a row for people."""
    return row_name(*(row[name] for name in KEY))


def _key(choice: VerifyOptions, engines: EngineOptions) -> str | None:
    """Return the key of a verification; None where an engine has no fingerprint.

    Raise RequestError for options that contradict one another, and for unknown names.
    """
    from harness.cases.registry import selected_names
    from harness.engines.registry import fingerprint_of
    from harness.files import committed
    from harness.store.cache import digest_of_tree, key_of, machine, source_digest, versions
    from harness.workflows.settings import selected_engines

    level, cases = choice.level, choice.cases if choice.cases or not choice.only else "all"
    names, chosen = selected_engines(choice.engines), selected_names(cases)
    engines.check(names, "--engines")
    if choice.known_defects is not None and not choice.known_defects.is_file():
        raise RequestError(f"--known-defects {choice.known_defects}: there is no such file")
    prints = {name: fingerprint_of(name, engines.opening(name)) for name in names}
    if None in prints.values():
        return None
    defects = choice.known_defects.read_bytes() if choice.known_defects else b""
    return key_of(
        {
            "verification": level,
            "cases": chosen,
            "engines": {name: dict(facts or {}) for name, facts in prints.items()},
            "named": [choice.cases, choice.engines],
            "flags": [choice.only, choice.strict, choice.png],
            "defects": hashlib.sha256(defects).hexdigest(),
            "accepted": digest_of_tree(committed("reports/accepted")),
            "machine": machine(),
            "packages": versions(*PACKAGES),
            "source": source_digest(),
        }
    )


def _print(record: Record, folder: Path, *, verbose: bool) -> None:
    rows: Sequence[Record] = record["rows"]
    others = [row["verdict"] for row in rows if row["verdict"] not in MOST_PRINTED]
    for verdict in (*MOST_PRINTED, *(dict.fromkeys(others) if verbose else ())):
        chosen = [row for row in rows if row["verdict"] == verdict]
        most = len(chosen) if verbose else MOST_PRINTED[verdict]
        for row in chosen[:most]:
            kind = "" if row["kind"] == verdict else f" ({row['kind']})"
            print_wrapped(f"{verdict}: {name_of(row)}{kind}")
            for text in details(row) if verdict != "pass" else ():
                print_wrapped(text, indent=4)
        if len(chosen) > most:
            print_wrapped(f"and {len(chosen) - most} more {verdict}: --verbose prints all")
    moved = [row for row in record["regressions"] if row["verdict_after"] != "fail"]
    for change in moved[: MOST_PRINTED["fail"]]:
        print_wrapped(f"against the accepted run, {change['change']}: {name_of(change)}")
    for kind in dict.fromkeys(row["kind"] for row in rows):
        counts = Counter(row["verdict"] for row in rows if row["kind"] == kind)
        print_wrapped(f"{kind}: {', '.join(f'{n} {verdict}' for verdict, n in counts.items())}")
    print_wrapped(record["headline"])
    again = " (kept from an earlier run)" if record["cached"] else ""
    print(f"report{again}: {folder / 'report.html'}")
    if record["status"] == 3:
        died = [f"{name_of(r)}: {r['note']}" for r in rows if r["failure"] == "engine error"]
        tell((died or [record["headline"]])[0])
