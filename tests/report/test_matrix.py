"""The matrix of cases and submodels: a mark for each system, the worst of its checks."""

from dataclasses import replace

from harness.comparison.verdicts import Cell, Kind, Tolerance, Verdict, judge
from harness.report.matrix import matrices
from harness.report.page import report_markdown, report_page

WIDTH = Tolerance("", 1e-6, 0.0, "a millionth, for a test")


def check(case, submodel, system, error, verdict=None):
    row = judge(f"{case}: {submodel}: speed", Kind.ANALYTIC, 0.5 + error, 0.5, WIDTH)
    row = replace(row, cell=Cell(case, submodel, system, "toy", 1.01, 0.99, 1.03))
    return replace(row, verdict=verdict) if verdict else row


CHECKS = (
    check("slide", "spring", "wall", 1e-9),
    check("slide", "spring", "wall", -3e-8),
    check("slide", "spring", "two spheres", 2e-9),
    check("roll", "spring", "wall", 1e-3, Verdict.KNOWN_DEFECT),
    check("roll", "spring", "wall", 1e-9),
    check("roll", "<old>", "wall", 1e-3),
)


def test_a_mark_is_the_worst_check_of_its_system():
    (matrix,) = matrices([(row, f"check-{n}") for n, row in enumerate(CHECKS)])
    assert (matrix.head, matrix.columns) == ("submodel", ("roll", "slide"))
    marks = matrix.rows["spring"]["slide"]
    assert [(m.cell.system, m.text, m.place) for m in marks] == [
        ("two spheres", "2e-09", "check-2"),
        ("wall", "3e-08", "check-1"),
    ]
    assert marks[1].title.startswith("wall, speed: 0.49999997 against 0.5")
    assert marks[1].title.endswith("order 1.01 (0.99 to 1.03)")
    assert [m.text for m in matrix.rows["spring"]["roll"]] == ["defect"]
    assert [m.text for m in matrix.rows["<old>"]["roll"]] == ["fail"]
    assert "slide" not in matrix.rows["<old>"]


def test_a_quantity_that_was_not_tested_hides_no_other_and_untested_systems_are_one_mark():
    untold = check("slide", "spring", "wall", 0.0, Verdict.NOT_TESTED)
    other = check("slide", "spring", "two spheres", 0.0, Verdict.NOT_TESTED)
    (matrix,) = matrices([(row, "") for row in (untold, CHECKS[1], other)])
    assert [m.text for m in matrix.rows["spring"]["slide"]] == ["not tested", "3e-08"]
    (matrix,) = matrices([(row, "") for row in (untold, other)])
    assert [m.text for m in matrix.rows["spring"]["slide"]] == ["not tested"]


def test_the_error_of_what_has_a_unit_is_relative():
    millionth = Tolerance("N", 0.0, 1e-6, "a millionth, for a test")
    force = judge("slide: force", Kind.ANALYTIC, 40.00002, 40.0, millionth)
    force = replace(force, cell=CHECKS[0].cell)
    (matrix,) = matrices([(force, "")])
    assert [m.text for m in matrix.rows["spring"]["slide"]] == ["5e-07"]
    none = replace(force, expected=0.0, value=2e-9, verdict=Verdict.PASS)
    (matrix,) = matrices([(none, "")])
    assert [m.text for m in matrix.rows["spring"]["slide"]] == ["2e-09"]


def test_invariances_share_the_mark_of_their_system():
    turned = check("slide", "spring", "wall", 1e-3)
    turned = replace(turned, cell=replace(turned.cell, invariance="turned"))
    (matrix,) = matrices([(row, "") for row in (*CHECKS[:3], turned)])
    marks = matrix.rows["spring"]["slide"]
    assert [(m.cell.system, m.text) for m in marks] == [("two spheres", "2e-09"), ("wall", "fail")]
    assert marks[1].title.startswith("wall, turned: ")
    known = replace(turned, verdict=Verdict.KNOWN_DEFECT)
    (matrix,) = matrices([(row, "") for row in (*CHECKS[:3], known)])
    assert [m.text for m in matrix.rows["spring"]["slide"]] == ["2e-09", "3e-08"]


def test_several_engines_stand_side_by_side_above_the_matrix_of_each():
    other = check("slide", "spring", "wall", 5e-8)
    other = replace(other, cell=replace(other.cell, engine="doll"))
    placed = [(row, f"check-{n}") for n, row in enumerate((*CHECKS, other))]
    whole, *each = matrices(placed)
    assert [one.title for one in each] == ["toy", "doll"]
    assert whole.columns == ("toy", "doll")
    assert list(whole.rows) == ["roll: <old>", "roll: spring", "slide: spring"]
    row = whole.rows["slide: spring"]
    assert {name: [m.text for m in marks] for name, marks in row.items()} == {
        "toy": ["2e-09", "3e-08"],
        "doll": ["5e-08"],
    }
    assert "doll" not in whole.rows["roll: spring"]


def test_page_and_markdown_show_it_and_have_none_without_cells(verification):
    assert 'id="matrix"' not in report_page(verification, [])
    assert "Cases and submodels" not in report_markdown(verification, [])
    found = replace(verification, checks=(*verification.checks, *CHECKS))
    page = report_page(found, [])
    assert '<span>wall</span> <span class="badge known-defect">defect</span></a>' in page
    assert "&lt;old&gt;" in page
    assert "<old>" not in page
    assert "| spring | defect | 2e-09, 3e-08 |" in report_markdown(found, [])
