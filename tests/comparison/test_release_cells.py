"""Cells of the matrix release by release: what does not hold, and which defect it is."""

from dataclasses import replace

import pytest

from harness.comparison.known_defects import KnownDefect, defect_of, mark_known_defects
from harness.comparison.releases import (
    Column,
    cell_rows,
    defects_of,
    reasons_of_records,
    release_matrix,
)
from harness.comparison.verdicts import (
    Cell,
    Kind,
    PredictedSize,
    Tolerance,
    finding,
    judge,
    not_tested,
)
from harness.observables.provenance import Provenance
from harness.report.folder import markdown

WIDTH = Tolerance("", 1e-6, 0.0, "a millionth, for a test")
DEFECT = KnownDefect(
    name="lost-friction",
    engine="toy",
    cases=("slide",),
    submodels=("spring",),
    cause="the spring is multiplied by a length that it has none of",
    predicts={"rules": {"factor": 1.2}},
    upstream="not reported",
    since="1 Mar 2023",
    until="1 Mar 2025",
)


def check(submodel, error, system="wall"):
    row = judge(f"slide: {submodel}, {system}", Kind.ANALYTIC, 0.5 + error, 0.5, WIDTH)
    size = PredictedSize(((0.6 - 1e-6, 0.6 + 1e-6),))
    return replace(row, cell=Cell("slide", submodel, system, "toy"), predict=lambda *_: size)


def release(version, error):
    missing = not_tested("slide: new", Kind.ANALYTIC, "not in this release")
    missing = replace(missing, cell=Cell("slide", "new", "wall", "toy"))
    found = (check("spring", error), check("spring", 0.0), check("dashpot", 0.0), missing)
    return mark_known_defects(found, (DEFECT,), {"toy": version})


RELEASES = (release("1 Jan 2022", 0.0), release("1 Jan 2024", 0.1), release("1 Jan 2025", 0.0))


def test_a_defect_is_counted_by_name_where_it_is_found():
    assert defects_of(RELEASES) == {"lost-friction": [0, 1, 0]}
    assert [defect_of(one[0]) for one in RELEASES] == ["", "lost-friction", "lost-friction"]


def test_cells_that_hold_everywhere_are_left_out():
    spring, new = (
        {row.submodel: row for row in cell_rows(RELEASES)}[name] for name in ("spring", "new")
    )
    assert len(cell_rows(RELEASES)) == 2
    assert spring.verdicts == ("pass", "known defect", "fixed")
    assert spring.defects == ("lost-friction",)
    assert new.verdicts == ("not tested",) * 3


def test_a_cell_says_why_it_was_not_tested_where_it_was_not():
    missing = not_tested("slide: new", Kind.ANALYTIC, "toy 1 has no new: toy 2 has it")
    alone = not_tested("slide: new", Kind.INVARIANCE, "the run as it stands is missing")
    place = Cell("slide", "new", "wall", "toy")
    first = [replace(missing, cell=place), replace(alone, cell=replace(place, invariance="all"))]
    held = replace(untested(Kind.INVARIANCE), cell=replace(place, invariance="turned"))
    second = [replace(check("new", 0.0), cell=place), held]
    (row,) = cell_rows([first, second, first[1:], []])
    assert row.verdicts == ("not tested", "pass", "not tested", "")
    assert row.reasons == (missing.note, "", alone.note, "")
    assert row.to_json()["reasons"] == [*row.reasons]
    assert reasons_of_records(first) == {"toy/slide-new-wall": missing.note}
    assert reasons_of_records(second) == reasons_of_records(first[1:]) == {}


def untested(kind, reason="no width follows"):
    row = not_tested("slide: spring", kind, reason)
    return replace(row, cell=replace(check("spring", 0.0).cell, invariance="turned"))


@pytest.mark.parametrize(
    ("rows", "verdict"),
    [
        ((untested(Kind.INVARIANCE), check("spring", 0.0)), "pass"),
        ((untested(Kind.INVARIANCE), check("spring", 0.1)), "fail"),
        ((untested(Kind.INVARIANCE), release("1 Jan 2024", 0.1)[0]), "known defect"),
        ((untested(Kind.INVARIANCE),), "not tested"),
        ((untested(Kind.INVARIANCE), finding("slide", 1.0, 0.5, "", "")), "not tested"),
        ((untested(Kind.ANALYTIC), check("spring", 0.0)), "not tested"),
    ],
)
def test_an_invariance_that_was_not_tested_decides_no_cell_with_judged_rows(rows, verdict):
    other = (check("spring", 0.1),)
    for one in (rows, rows[::-1]):
        (row,) = cell_rows(
            [[replace(r, cell=other[0].cell) if r.cell is None else r for r in one], other]
        )
        assert row.verdicts == (verdict, "fail")


def test_a_failure_that_no_defect_explains_is_status_1_and_the_page_names_all():
    columns = [
        Column(name, Provenance("toy", name), checks=checks)
        for name, checks in zip(("1", "2", "3"), RELEASES, strict=True)
    ]
    found = release_matrix("quick", "here", columns, {}, "TOY", "contacts")
    assert found.status == 0
    assert found.to_json()["known_defects"] == {"lost-friction": [0, 1, 0]}
    page = markdown(found)
    assert "| slide | spring | wall | pass | known defect | fixed | lost-friction |" in page
    assert page.count("| not in this release | 1 | slide |") == 3
    failing = [replace(columns[0], checks=(check("spring", 0.1),)), *columns[1:]]
    assert release_matrix("quick", "here", failing, {}, "TOY").status == 1
