"""The cells of the matrix in Markdown: a row with value, reference, error and order for each."""

from dataclasses import replace

from harness.comparison.verdicts import Cell, Kind, Tolerance, Verdict, judge, not_tested
from harness.report.markdown import markdown_table
from harness.report.matrix import HEAD, values
from harness.report.page import report_markdown

WIDTH = Tolerance("N", 0.0, 1e-6, "a millionth, for a test")


def check(case, submodel, system, engine="toy", **told):
    row = judge(f"{case}, {system}: largest_force_N", Kind.ANALYTIC, 40.00002, 40.0, WIDTH)
    cell = Cell(case, submodel, system, engine, 1.01, 0.99, 1.03, **told)
    return replace(row, cell=cell)


def refused(system):
    row = not_tested("slide: belt | brace, toy", Kind.ANALYTIC, "it has no belt")
    return replace(row, cell=Cell("slide", "belt | brace", system, "toy"))


CHECKS = (
    check("slide", "spring", "wall"),
    replace(check("slide", "spring", "two spheres", defect="weak"), verdict=Verdict.KNOWN_DEFECT),
    refused("wall"),
    refused("two spheres"),
    check("roll", "spring", "wall"),
    check("slide", "spring", "wall", engine="doll"),
    check("slide", "spring", "wall", invariance="turned"),
)


def columns(line):
    return [part.strip() for part in line.replace("\\|", "/").strip("|").split("|")]


def test_a_row_has_value_reference_error_and_order():
    tables = values(CHECKS)
    assert [table.label for table in tables] == [
        "Values of slide, toy",
        "Values of roll, toy",
        "Values of slide, doll",
    ]
    written = markdown_table(tables[0], aligned=True)
    head, _, *rows = written.splitlines()
    assert columns(head) == [*HEAD]
    assert columns(rows[0]) == [
        *("spring", "wall", "largest force (N)", "40.00002", "40", "closed form"),
        *("2e-05", "4e-05", "1.01", "0.99 to 1.03", "pass"),
    ]
    assert columns(rows[1])[-1] == "known defect: weak"
    assert columns(rows[2])[:2] == ["belt / brace", "wall"]
    assert columns(rows[2])[-1] == "not tested: it has no belt"
    assert len(rows) == 3  # what cannot be stated in any system is said once


def test_the_report_lists_these_rows_once(verification):
    found = replace(verification, checks=(*verification.checks, *CHECKS))
    told = report_markdown(found, [])
    assert "6 rows stand with the cells of the matrix, below." in told
    assert told.count("| 40.00002 |") == len([c for c in CHECKS if c.value == 40.00002])
    assert values(verification.checks) == []
    assert "rows stand with" not in report_markdown(verification, [])
