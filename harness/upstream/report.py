"""The page of upstream's tests: what passes in which release, what a tolerance hides."""

from __future__ import annotations

from harness.report.render import markdown_page
from harness.report.sections import Table
from harness.upstream.runs import Outcome, UpstreamRuns


def report(runs: UpstreamRuns) -> str:
    """Return the page of runs as Markdown."""
    wrong = tuple(_wrong(outcome) for outcome in runs.outcomes if _fails(outcome))
    return markdown_page(
        "upstream.md.j2",
        "LAMMPS's own granular tests",
        "harness.upstream",
        counts=runs.summary(),
        wrong=Table("What fails", "", WRONG, wrong),
        tests=_matrix(runs),
        untested=Table("Not tested", "", ("release", "why", "tests"), tuple(_untested(runs))),
    )


WRONG = ("test", "release", "recorded", "law", "difference", "step", "upstream allows", "why")


def _fails(outcome: Outcome) -> bool:
    record = outcome.to_json()
    return bool({record["recorded"], record["law"]} & {"fail", "known defect"})


def _wrong(outcome: Outcome) -> tuple[str, ...]:
    record = outcome.to_json()
    hidden = ", **hidden**" if record["hidden_by_tolerance"] else ""
    failed = [check.note for check in outcome.checks if check.verdict == "fail"]
    return (
        outcome.test,
        outcome.release,
        str(record["recorded"]),
        f"{record['law']}{hidden}",
        _number(outcome.law_difference),
        _number(outcome.step_error),
        _number(outcome.tolerance),
        outcome.defect or "; ".join(dict.fromkeys(failed)),
    )


def _matrix(runs: UpstreamRuns) -> Table:
    releases = list(dict.fromkeys(outcome.release for outcome in runs.outcomes))
    cells = {(o.test, o.release): _short(o) for o in runs.outcomes}
    tests = dict.fromkeys(outcome.test for outcome in runs.outcomes)
    rows = ((test, *(cells.get((test, release), "-") for release in releases)) for test in tests)
    return Table("All tests", "", ("test", *releases), tuple(rows))


def _short(outcome: Outcome) -> str:
    record = outcome.to_json()
    words = {"not tested": "-", "none": "-"}
    return " / ".join(
        words.get(str(record[name]), str(record[name])) for name in ("recorded", "law")
    )


def _untested(runs: UpstreamRuns) -> list[tuple[str, str, str]]:
    reasons: dict[tuple[str, str], list[str]] = {}
    for outcome in runs.outcomes:
        for check in outcome.checks:
            if check.verdict == "not tested":
                why = check.note.partition(" (src")[0].partition("undecided: ")
                text = "undecided: its step is too coarse" if why[1] else why[0]
                tests = reasons.setdefault((outcome.release, text), [])
                tests += [outcome.test] if outcome.test not in tests else []
    return [(release, why, str(len(tests))) for (release, why), tests in reasons.items()]


def _number(value: float) -> str:
    return f"{value:.2g}" if value == value else "-"
