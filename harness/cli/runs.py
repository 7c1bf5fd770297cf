"""Commands ``verify``, ``run`` and ``sweep``: options, a call each, and what is printed of it."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Group, Parameter

from harness.cli.options import (
    ENGINE,
    Cases,
    EngineOptions,
    File,
    Folder,
    Force,
    Json,
    MaybeWhole,
    Name,
    Only,
    Settings,
    duration_check,
    opener,
)
from harness.cli.output import (
    check_target,
    output_folder,
    print_frame,
    print_wrapped,
    show,
    tell,
    write_all,
)
from harness.errors import HarnessError, RequestError
from harness.results.rows import KEY, row_name

if TYPE_CHECKING:
    from harness.results.rows import Level
    from harness.workflows.sweeps import Sweep

Record = Mapping[str, Any]
MOST_PRINTED = {"fail": 20, "known defect": 10, "fixed": 10, "not tested": 10, "finding": 5}
PACKAGES = ("jinja2", "matplotlib", "numba", "numpy", "pandas", "pydantic", "scipy")
FILM = Group("Film", sort_key=2)
PICTURES = 120


# ---- verify


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
    with output_folder(choice.output) as folder:
        record = _verified(choice, engines, folder, json)
    if not json:
        _print_verification(record, folder, verbose=choice.verbose)
    return show(record, json, {})


def _verified(
    choice: VerifyOptions, engines: EngineOptions, folder: Path, quiet: bool
) -> dict[str, Any]:
    """Verify, or take what was verified before; write the report and return its record."""
    from harness.store.cache import keep_verification, kept_verification

    entries, key, record = engines.entries(), _key(choice, engines), None
    if entries is not None and key is not None and not engines.fresh:
        record = kept_verification(entries, key, folder)
    more: dict[str, Any] = {"folder": str(folder), "cached": record is not None}
    if record is None:
        # imported late: a kept verification must not wait for pandas
        from harness.workflows import verify as verify_engines

        names = ("cases", "engines", "only", "strict", "known_defects", "png")
        work, instead = f"level {choice.level}", "--quick, or fewer cases"
        with opener(engines, "verify", quiet) as opening:
            record = verify_engines(
                choice.level,
                **{name: getattr(choice, name) for name in names},
                output=folder,
                open_engine=opening.opened,
                check_duration=duration_check(choice.force, work, instead),
                progress=opening.progress,
            ).to_json()
        if entries is not None and key is not None and record["status"] in (0, 1):
            keep_verification(entries, key, folder, record)
        more |= opening.runs()
    return {**record, **more}


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


def _print_verification(record: Record, folder: Path, *, verbose: bool) -> None:
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


# ---- run and sweep


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """What is run and written."""

    settings: Settings = None
    """A parameter of the case, in SI units and degrees, or `preset=NAME`; repeat it for several."""
    quantity: Annotated[str, Parameter(metavar="NAMES")] = ""
    """Quantities to measure and show, with commas between. One such as critical_angle_deg takes
    several runs. [default: all that a run measures]"""
    engine: Annotated[Name, Parameter(group=ENGINE)] = None
    """An engine that `dem-harness engines` lists, `module:Class` of your own, or a solver that
    `dem-harness cases` lists. [default: lammps, or a solver where it cannot]"""
    script: File = None
    """Write the plain script of the run, for the code itself, to this file."""
    profile: File = None
    """Write the profile of the run over the height, or its curves over time, to this CSV file, of a
    case that has one."""
    film: Annotated[File, Parameter(group=FILM)] = None
    """Write a film of the motion to this file: .gif, or .mp4 where ffmpeg is on the path. A .png is
    one picture of it."""
    frames: Annotated[MaybeWhole, Parameter(group=FILM)] = None
    """Pictures of the film, 20 a second. [default: 120]"""
    force: Force = False

    def check(self) -> None:
        """Raise RequestError, before anything is run, for files that cannot be written."""
        check_target(self.profile, "--profile", (".csv",))
        check_target(self.script, "--script")
        if self.frames is not None and self.film is None:
            raise RequestError(f"--frames {self.frames}: goes with --film only")
        if self.film is not None:
            from harness.report.figures import check_film

            check_film(self.film, PICTURES if self.frames is None else self.frames)


def run(
    case: str,
    /,
    choice: RunOptions = RunOptions(),
    engines: EngineOptions = EngineOptions(),
    *,
    json: Json = False,
) -> int:
    """Run a case once: its parameters, what it measures, and what is expected.

    The reference of a quantity is its value at equal steps where the reference can run the case,
    else the closed form. The limit is that of small steps.

    For example:

        dem-harness run tower --set height=2 --set speed=4

        dem-harness run layers-flow --set angle=16 --profile profile.csv

        dem-harness run columns --set n=8 --quantity critical_angle_deg --engine reference

    Parameters
    ----------
    case
        A case that `dem-harness cases` lists.
    """
    import pandas as pd

    from harness.cases.registry import get_case
    from harness.engines.registry import named_values
    from harness.files import text_writer
    from harness.workflows import run as run_case
    from harness.workflows.runs import runner_name

    choice.check()
    pictures = PICTURES if choice.frames is None else choice.frames
    name = runner_name(get_case(case), choice.engine)
    engines.check([name], "--engine")
    with opener(engines, "run", json) as opening:
        result = run_case(
            case,
            named_values(choice.settings or (), "--set"),
            name,
            quantities=choice.quantity,
            open_engine=opening.qualified,
            profile=choice.profile is not None,
            script=choice.script is not None,
            film_frames=pictures if choice.film is not None else 0,
            check_duration=duration_check(choice.force, f"case {case!r} with these values"),
            progress=opening.progress,
        )
    profile = partial(pd.DataFrame(dict(result.profile)).to_csv, index=False)
    write_all({("--profile", choice.profile): profile,
               ("--script", choice.script): text_writer(result.script)})  # fmt: skip
    if choice.film is not None and result.discs is not None:
        from harness.report.figures import write_film

        write_film(result.discs, choice.film, pictures)
    return opening.answer(result.to_json(), json, result.summary())


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class SweepOptions:
    """What is swept, in which engines, and where the table goes."""

    over: Annotated[list[str] | None, Parameter(metavar="NAME=VALUES")] = None
    """A parameter and its values, in SI units and degrees: a list `1,2,5`, a range
    `FIRST:LAST:COUNT` of evenly spaced numbers, a range `FIRST:LAST:logCOUNT` evenly spaced in the
    logarithm, or several with commas between. Repeat it for all combinations."""
    settings: Settings = None
    """A parameter that is the same in every run; repeat it for several."""
    engines: Annotated[str, Parameter(metavar="NAMES", group=ENGINE)] = ""
    """Engines that `dem-harness engines` lists and solvers of the case, with commas between, or
    `all`. [default: as of `run`]"""
    quantity: Annotated[str, Parameter(metavar="NAMES")] = ""
    """Quantities to measure, with commas between, the first in the figure. Of one such as
    critical_angle_deg a value takes several runs. [default: all that a run measures]"""
    output: Folder = None
    """Where table and figure are written; the same sweep goes on there. [default:
    reports/runs/DATE-sweep]"""
    reference: Annotated[Path | None, Parameter(metavar="FILE.csv")] = None
    """Your measured points for the figure: a CSV table with the columns of rows.csv, the first
    parameter of --over and the first quantity. A column `uncertainty_QUANTITY` or
    `uncertainty_UNIT` gives error bars."""
    force: Force = False


def sweep(
    target: str,
    /,
    choice: SweepOptions = SweepOptions(),
    engines: EngineOptions = EngineOptions(),
    *,
    json: Json = False,
) -> int:
    """Run a case over values of its parameters and over engines: one tidy row a run.

    Runs that were made before are not made again, and a sweep that was killed goes on. A run that
    fails is a row with the reason, and so are values that the case refuses together.

    For example:

        dem-harness sweep tower --over height=1,2,5:20:4 --engines exact,lammps --output mine

        dem-harness sweep oblique --set preset=kharaz --over angle=5:85:9 --reference measured.csv

        dem-harness sweep inputs/sweeps/step-and-stiffness.toml --dask tcp://head:8786

    Parameters
    ----------
    target
        A case that `dem-harness cases` lists, or a file, FILE.toml, that describes a sweep.
    """
    from harness.engines.registry import named_values
    from harness.workflows import sweep as run_sweep

    def check(planned: Sweep) -> None:
        engines.check(planned.engines, "--engines")
        work = f"{len(planned.rows)} runs of case {planned.case.name!r}"
        duration_check(choice.force, work)(planned.seconds())

    with (
        nullcontext(choice.output) if choice.output else output_folder(None, "-sweep") as folder,
        opener(engines, "sweep", json) as opening,
    ):
        result = run_sweep(
            target,
            named_values(choice.over or (), "--over"),
            fixed=named_values(choice.settings or (), "--set"),
            engines=choice.engines,
            quantities=choice.quantity,
            output=folder,
            reference=choice.reference,
            open_engine=opening.qualified,
            executor=opening.executor,
            check=check,
            progress=opening.progress,
        )
    unqualified = {name: reason for name, reason in opening.failures.items() if reason}
    notes = [f"engine {name!r} did not qualify: {why}" for name, why in unqualified.items()]
    if not (folder / "figure.svg").is_file():
        notes.append(f"no figure: no run that is done measured {next(iter(result.columns))}")
    if not json:
        _print_sweep(result)
        for note in (*notes, f"--output {folder}: is written"):
            tell(note)
    more = {"output": str(folder), "notes": notes}
    show({**result.to_json(), **opening.runs(), **more}, json, {})
    ended = result.count("done") + result.count("undecided")
    failed = result.count("failed") or not ended or unqualified
    return HarnessError.exit_status if failed else 0


def _print_sweep(result: Sweep) -> None:
    frame = result.to_frame()
    columns = [name for name in result.columns.values() if frame[name].notna().any()]
    swept = [name for name in result.request.swept if name in frame]
    print_frame(frame[["engine", *swept, *columns, "status"]], rest="rows.csv has all")
    for reason, count in frame.loc[frame["reason"] != "", "reason"].value_counts().items():
        tell(f"{count} of {len(frame)} runs: {reason}")
    for engine, why in result.missing.items():
        tell(f"engine {engine!r} is left out: {why}")
