"""The page of upstream's tests: what passes in which release, what a tolerance hides."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from harness.upstream.runs import Outcome, UpstreamRuns

HEAD = """# LAMMPS's own granular tests

LAMMPS's `unittest/granular` runs a contact at one step and holds it against its own record, and
against a closed form to a relative tolerance. Here the same commands run in each release,
with newton on and off, and at steps divided by up to 16; the limit is held against the independent
integration of the contact law.

- **recorded**: the motion at the end of each segment is that of the record, to the test's epsilon.
- **law**: the limit of a small step is the integrated law, to 1e-6 of the largest speed (1e-4 where
  sliding or a dashpot begins or ends within a step).
- **step**: the error of the test's own step, over the largest speed.
- **hidden**: the law is wrong, and upstream's tolerance covers it.
- A failure of the size that [a known defect](../defects/README.md) predicts bears its name.
"""


def report(runs: UpstreamRuns) -> str:
    """Return the page of runs as Markdown."""
    counts = [f"- **{release}**: {text}." for release, text in runs.summary().items()]
    wrong = [_wrong(outcome) for outcome in runs.outcomes if _fails(outcome)]
    parts = [
        HEAD,
        "\n".join(counts),
        "## What fails, and why",
        _table(WRONG, wrong) if wrong else "Nothing fails.",
        "## All tests, by release",
        "Recorded / law; `-` where the release does not have what the test asks for, or where no "
        "scene of spheres and flat walls is read.",
        _matrix(runs),
        "## Not tested, and why",
        _untested(runs),
    ]
    return "\n\n".join(part.strip() for part in parts) + "\n"


WRONG = ("test", "release", "recorded", "law", "difference", "step", "upstream allows", "why")


def _fails(outcome: Outcome) -> bool:
    record = outcome.record()
    return bool({record["recorded"], record["law"]} & {"fail", "known defect"})


def _wrong(outcome: Outcome) -> tuple[str, ...]:
    record = outcome.record()
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


def _matrix(runs: UpstreamRuns) -> str:
    releases = list(dict.fromkeys(outcome.release for outcome in runs.outcomes))
    cells = {(o.test, o.release): _short(o) for o in runs.outcomes}
    tests = dict.fromkeys(outcome.test for outcome in runs.outcomes)
    rows = [(test, *(cells.get((test, release), "-") for release in releases)) for test in tests]
    return _table(("test", *releases), rows)


def _short(outcome: Outcome) -> str:
    record = outcome.record()
    words = {"not tested": "-", "none": "-"}
    return " / ".join(
        words.get(str(record[name]), str(record[name])) for name in ("recorded", "law")
    )


def _untested(runs: UpstreamRuns) -> str:
    reasons: dict[tuple[str, str], list[str]] = {}
    for outcome in runs.outcomes:
        for check in outcome.checks:
            if check.verdict == "not tested":
                why = check.note.partition(" (src")[0].partition("undecided: ")
                text = "undecided: its step is too coarse" if why[1] else why[0]
                tests = reasons.setdefault((outcome.release, text), [])
                tests += [outcome.test] if outcome.test not in tests else []
    rows = [(release, why, str(len(tests))) for (release, why), tests in reasons.items()]
    return _table(("release", "why", "tests"), rows) if rows else "All are tested."


def _number(value: float) -> str:
    return f"{value:.2g}" if value == value else "-"


def _table(head: Sequence[str], rows: Iterable[Iterable[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', '/') for cell in row)} |" for row in lines)
