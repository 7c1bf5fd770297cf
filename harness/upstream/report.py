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
    counts = [f"- **{release}**: {text}." for release, text in runs.told().items()]
    wrong = [o for o in runs.outcomes if "pass" not in (_recorded(o), _law(o)) or _fails(o)]
    parts = [
        HEAD,
        "\n".join(counts),
        "## What fails, and why",
        _table([_row(o) for o in wrong]) if wrong else "Nothing fails.",
        "## All tests",
        _table([_row(o) for o in runs.outcomes]),
    ]
    return "\n\n".join(part.strip() for part in parts) + "\n"


def _recorded(outcome: Outcome) -> str:
    return str(outcome.record()["recorded"])


def _law(outcome: Outcome) -> str:
    return str(outcome.record()["law"])


def _fails(outcome: Outcome) -> bool:
    return bool({_recorded(outcome), _law(outcome)} & {"fail", "known defect"})


COLUMNS = ("test", "release", "recorded", "law", "difference", "step", "upstream allows", "why")


def _row(outcome: Outcome) -> tuple[str, ...]:
    record = outcome.record()
    hidden = ", **hidden**" if record["hidden_by_tolerance"] else ""
    why = outcome.defect or ("" if not _fails(outcome) and _law(outcome) == "pass" else outcome.why)
    return (
        outcome.test,
        outcome.release,
        _recorded(outcome),
        _law(outcome) + hidden,
        _number(outcome.law_difference),
        _number(outcome.step_error),
        _number(outcome.tolerance),
        why or ("" if _law(outcome) == "pass" else str(record["why"])),
    )


def _number(value: float) -> str:
    return f"{value:.2g}" if value == value else "-"


def _table(rows: Sequence[Iterable[str]]) -> str:
    lines = [COLUMNS, ("---",) * 4 + ("--:",) * 3 + ("---",), *rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', '/') for cell in row)} |" for row in lines)
