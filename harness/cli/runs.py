"""Commands ``verify``, ``run`` and ``sweep``: options, a call each, and what is printed of it."""

from __future__ import annotations

import hashlib
from collections import Counter
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Group, Parameter

from harness import workflows
from harness.cli import options, output
from harness.cli.options import EngineOptions, opener
from harness.errors import HarnessError, RequestError
from harness.files import committed, text_writer

if TYPE_CHECKING:
    from harness.results.rows import Level
    from harness.workflows.sweeps import Sweep

TO_LOOK_AT = ("fail", "known defect", "fixed", "not tested", "finding")  # verdicts
MOST_ROWS = 20  # of a verdict that are printed
PACKAGES = ("jinja2", "matplotlib", "numba", "numpy", "pandas", "pydantic", "scipy")
FILM = Group("Film", sort_key=2)


# ---- verify


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class VerifyOptions:
    """What is verified, and where the report goes."""

    quick: bool = False
    """The checks that take seconds."""
    full: bool = False
    """All checks, those of minutes and more among them."""
    cases: options.Cases = None
    engines: Annotated[str, Parameter(metavar="all|NAME[,NAME...]")] = "lammps"
    """These engines and no others; `all` is every installed engine."""
    only: options.Only = ""
    output: options.Folder = None
    """Folder for the report; must not hold anything yet. [default: reports/runs/ and the date]"""
    known_defects: options.File = None
    """More known defects than the committed ones, TOML as in inputs/known-defects.toml."""
    strict: bool = False
    """Exit status 1 also where a row was not tested."""
    png: bool = False
    """Write every figure as PNG too, not only as SVG."""
    verbose: bool = False
    """Print every row, not only those to look at."""

    @property
    def level(self) -> Level:
        """Return the level. Raise RequestError for two of them."""
        if self.quick and self.full:
            raise RequestError("--quick and --full: give one of them only")
        return "quick" if self.quick else "full" if self.full else "default"

    def request(self) -> dict[str, Any]:
        """Return what decides the rows and pages of a verification, as its arguments."""
        names = ("level", "cases", "engines", "only", "strict", "known_defects", "png")
        return {name: getattr(self, name) for name in names}


def verify(
    choice: VerifyOptions = VerifyOptions(),
    engines: EngineOptions = EngineOptions(),
    *,
    json: options.Json = False,
) -> int:
    """Hold engines against theory, one another and the accepted run, and write a report.

    The report has report.html, report.md, rows.csv, junit.xml, figures and the scripts that ran.
    What was verified before, with the same engines, code and platform, is not verified again: its
    report is written once more. An interrupted verification goes on where it stopped.
    """
    from harness.engines.process import cores
    from harness.results.rows import ENGINE_FAILURES
    from harness.store.cache import keep_verification, kept_verification

    with output.output_folder(choice.output) as folder:
        entries, key, record = engines.entries(), _key(choice, engines), None
        if entries and key and not engines.fresh:
            record = kept_verification(entries, key, folder)
        more: dict[str, Any] = {"folder": str(folder), "cached": record is not None}
        if record is None:
            work, instead = f"level {choice.level}", "--quick, or fewer cases"
            with opener(engines, "verify", json) as opening:
                record = workflows.verify(
                    **choice.request(),
                    output=folder,
                    open_engine=opening.opened,
                    processes=1 if opening.executor else cores(),
                    check_duration=partial(engines.check_seconds, work=work, instead=instead),
                    progress=opening.progress,
                ).to_json()
            if entries and key and record["status"] in (0, 1):
                keep_verification(entries, key, folder, record)
            more |= opening.runs()
    record = {**record, **more}
    died = [row for row in record["rows"] if row["failure"] in ENGINE_FAILURES]
    if record["status"] == HarnessError.exit_status and not json:
        output.tell(f"{output.name_of(died[0])}: {died[0]['note']}" if died else record["headline"])
        reasons = {row["engine"]: row["note"] for row in record["rows"]}
        for name in (name for name, version in record["engines"].items() if not version):
            output.tell(f"engine {name!r} could not be run: {reasons[name]}")
    most = len(record["rows"]) if choice.verbose else MOST_ROWS
    return output.show(record, json, _lines_to_print(record, choice.verbose), most)


def _key(choice: VerifyOptions, engines: EngineOptions) -> str | None:
    """Return the key of a verification; None where an engine or a case has no fingerprint."""
    from harness.cases.registry import hidden_cases, homes, selected_names
    from harness.engines.registry import fingerprint_of
    from harness.store.cache import digest_of_tree, key_of, machine, source_digest, versions
    from harness.workflows.settings import selected_engines

    request, file = choice.request(), choice.known_defects
    defects = [committed("inputs/known-defects.toml"), *([file] if file else [])]
    names = selected_engines(choice.engines)
    cases = selected_names(choice.cases or ("all" if choice.only else None))
    engines.check(names, "--engines")
    if file is not None and not file.is_file():
        raise RequestError(f"--known-defects {file}: there is no such file")
    prints = {name: fingerprint_of(name, engines.opening(name)) for name in names}
    if None in prints.values() or set(cases) - homes().keys():
        return None
    return key_of(
        {
            **request,
            "known_defects": [hashlib.sha256(path.read_bytes()).hexdigest() for path in defects],
            "every case": [*cases, *hidden_cases()],
            "fingerprints": {name: dict(facts or {}) for name, facts in prints.items()},
            "accepted": digest_of_tree(committed("reports/accepted")),
            "machine": machine(),
            "packages": versions(*PACKAGES),
            "source": source_digest(),
        }
    )


def _lines_to_print(record: output.Record, is_verbose: bool) -> dict[str, Any]:
    rows, again = record["rows"], " (kept from an earlier run)" if record["cached"] else ""
    verdicts = [*TO_LOOK_AT, *(row["verdict"] for row in rows if is_verbose)]
    texts = {verdict: list[str]() for verdict in verdicts}
    for row in (row for row in rows if row["verdict"] in texts):
        details = "; ".join(output.row_details(row))
        texts[row["verdict"]].append(f"{output.name_of(row)} ({row['kind']}): {details}")
    moved = [change for change in record["regressions"] if change["verdict_after"] != "fail"]
    lines: dict[str, Any] = {
        **texts,
        "against the accepted run": [f"{row['change']}: {output.name_of(row)}" for row in moved],
    }
    for kind in dict.fromkeys(row["kind"] for row in rows):
        counts = Counter(row["verdict"] for row in rows if row["kind"] == kind)
        lines[f"{kind} rows"] = ", ".join(f"{n} {verdict}" for verdict, n in counts.items())
    place = f"{record['folder']}/report.html"
    return {**lines, "outcome": record["headline"], f"report{again}": place}


# ---- run and sweep


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """What is run and written."""

    settings: options.Settings = None
    """A parameter of the case, in SI units and degrees, or `preset=NAME`; repeat it for several."""
    quantity: Annotated[str, Parameter(metavar="NAMES")] = ""
    """Quantities to measure and show, with commas between. One such as critical_angle_deg takes
    several runs. [default: all that a run measures]"""
    engine: Annotated[options.Name, Parameter(group=options.ENGINE)] = None
    """An engine that `dem-harness engines` lists, `module:Class` of your own, or a solver that
    `dem-harness cases` lists. [default: lammps, or a solver where it cannot]"""
    script: options.File = None
    """Write the plain script of the run, for the code itself, to this file."""
    profile: options.File = None
    """Write the profile of the run over the height, or its curves over time, to this CSV file, of a
    case that has one."""
    film: Annotated[options.File, Parameter(group=FILM)] = None
    """Write a film of the motion to this file: .gif, or .mp4 where ffmpeg is on the path. A .png is
    one picture of it."""
    frames: Annotated[options.MaybeWhole, Parameter(group=FILM)] = None
    """Pictures of the film, 20 a second. [default: 120]"""

    def pictures(self) -> int:
        """Return the number of pictures, 0 without a film. Raise RequestError for a wrong one."""
        if self.film is None:
            if self.frames is not None:
                raise RequestError(f"--frames {self.frames}: goes with --film only")
            return 0
        from harness.report.figures import check_film

        pictures = 120 if self.frames is None else self.frames
        check_film(self.film, pictures)
        return pictures


def run(
    case: str,
    /,
    choice: RunOptions = RunOptions(),
    engines: EngineOptions = EngineOptions(),
    *,
    json: options.Json = False,
) -> int:
    """Run a case once: its parameters, what it measures, and what is expected.

    The reference of a quantity is its value at equal steps where the reference can run the case,
    else the closed form. The limit is that of small steps.

    Parameters
    ----------
    case
        A case that `dem-harness cases` lists.
    """
    import pandas as pd

    from harness.cases.registry import get_case
    from harness.engines.registry import named_values
    from harness.workflows.runs import is_solver, runner_name

    output.check_target(choice.profile, "--profile", (".csv",))
    output.check_target(choice.script, "--script", (), choice.profile, choice.film)
    pictures, name = choice.pictures(), runner_name(get_case(case), choice.engine)
    engines.check([name], "--engine")
    if is_solver(get_case(case), name):
        engines.check_no_cluster(name)
    with opener(engines, "run", json) as opening:
        result = workflows.run(
            case,
            named_values(choice.settings or (), "--set"),
            name,
            quantities=choice.quantity,
            open_engine=opening.qualified,
            profile=choice.profile is not None,
            script=choice.script is not None,
            film_frames=pictures,
            check_duration=partial(engines.check_seconds, work=f"case {case!r} with these values"),
            progress=opening.progress,
        )
    if choice.film is not None and result.discs is not None:  # first: ffmpeg may fail
        from harness.report.figures import write_film

        write_film(result.discs, choice.film, pictures)
    profile = partial(pd.DataFrame(dict(result.profile)).to_csv, index=False)
    output.write_all({("--profile", choice.profile): profile,
               ("--script", choice.script): text_writer(result.script)})  # fmt: skip
    return opening.show(result.to_json(), json, result.summary())


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class SweepOptions:
    """What is swept, in which engines, and where the table goes."""

    over: Annotated[list[str] | None, Parameter(metavar="NAME=VALUES")] = None
    """A parameter and its values, in SI units and degrees: `1,2,5`, or ranges `FIRST:LAST:COUNT`
    (evenly spaced) and `FIRST:LAST:logCOUNT` (in the logarithm). Repeat it for all combinations."""
    settings: options.Settings = None
    """A parameter that is the same in every run; repeat it for several."""
    engines: Annotated[str, Parameter(metavar="NAMES", group=options.ENGINE)] = ""
    """Engines that `dem-harness engines` lists and solvers of the case, with commas between, or
    `all`. [default: as of `run`]"""
    quantity: Annotated[str, Parameter(metavar="NAMES")] = ""
    """Quantities to measure, with commas between, the first in the figure. Of one such as
    critical_angle_deg a value takes several runs. [default: all that a run measures]"""
    output: options.Folder = None
    """Where table and figure are written; the same sweep goes on there. [default:
    reports/runs/DATE-sweep]"""
    reference: Annotated[options.File, Parameter(metavar="FILE.csv")] = None
    """Your measured points for the figure: a CSV table with the first parameter of --over and the
    first quantity, as rows.csv names them; `uncertainty_QUANTITY` (or `_UNIT`) gives error bars."""


def sweep(
    target: str,
    /,
    choice: SweepOptions = SweepOptions(),
    engines: EngineOptions = EngineOptions(),
    *,
    json: options.Json = False,
) -> int:
    """Run a case over values of its parameters and over engines: one tidy row a run.

    Runs that were made before are not made again, and a sweep that was killed goes on. A run that
    fails is a row with the reason, and so are values that the case refuses together.

    Parameters
    ----------
    target
        A case that `dem-harness cases` lists, or a file, FILE.toml, that describes a sweep.
    """
    from harness.engines.registry import named_values

    def check(planned: Sweep) -> None:
        engines.check(planned.engines, "--engines")
        work = f"{len(planned.rows)} runs of case {planned.case.name!r}"
        engines.check_seconds(planned.seconds(), work)

    named = nullcontext(choice.output) if choice.output else output.output_folder(None, "-sweep")
    with named as folder, opener(engines, "sweep", json) as opening:
        result = workflows.sweep(
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
    reasons = Counter(row["reason"] for row in result.rows if row["reason"])
    lines = [f"{number} of {len(result.rows)} runs: {why}" for why, number in reasons.items()]
    lines += [f"engine {name!r} is left out: {why}" for name, why in result.missing.items()]
    notes = [f"engine {name!r} did not qualify: {why}" for name, why in unqualified.items()]
    if not (folder / "figure.svg").is_file():
        notes.append(f"no figure: no run that is done measured {next(iter(result.columns))}")
    for note in () if json else (*lines, *notes, f"--output {folder}: is written"):
        output.tell(note)
    columns = ("engine", *result.request.swept, *result.columns.values(), "status")
    more = {"output": str(folder), "notes": notes}
    text = {"runs": output.picked(result.rows, columns)}
    output.show({**result.to_json(), **opening.runs(), **more}, json, text)
    ended = result.count("done") + result.count("undecided")
    failed = result.count("failed") or not ended or unqualified
    return HarnessError.exit_status if failed else 0
