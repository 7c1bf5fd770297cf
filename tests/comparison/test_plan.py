from harness.comparison.verdicts import (
    Kind,
    Planned,
    Tolerance,
    Triage,
    Verdict,
    judge,
    judge_plan,
    missing_from,
    not_tested,
)

WIDTH = Tolerance("", 0.0, 0.0, "exact")


def row(name, kind=Kind.ANALYTIC):
    return judge(name, kind, 1.0, 1.0, WIDTH)


def test_a_plan_of_which_all_is_there_is_one_row_that_counts():
    rows = [row("a: x"), row("a: y"), not_tested("b", Kind.CROSS_CODE, "refused")]
    (count,) = judge_plan("rows", rows, [Planned("a"), Planned("b")])
    assert (count.verdict, count.value, count.expected) == (Verdict.PASS, 3.0, 2.0)


def test_a_check_that_no_run_left_is_a_failure_of_its_name():
    rows = [row("a: x"), row("a: z")]
    count, lost = judge_plan("rows", rows, [Planned("a: x"), Planned("b: y")])
    assert (count.verdict, count.note) == (Verdict.FAIL, "missing: b: y")
    assert (lost.name, lost.verdict, lost.triage) == ("b: y", Verdict.FAIL, Triage.MISSING)


def test_a_row_is_of_one_check_and_as_many_are_needed_as_are_planned():
    rows = [row("time, the worst of 5")]
    planned = [Planned("time, the worst of")] * 2
    assert missing_from(rows, planned) == planned[:1]
    assert missing_from([*rows, row("time, the worst of 10")], planned) == []


def test_the_longest_name_takes_its_row_first():
    rows = [row("a: x"), row("a")]
    assert missing_from(rows, [Planned("a"), Planned("a: x")]) == []


def test_an_invariance_does_not_stand_for_a_value():
    moved = row("spin, floor: linear, code: turned", Kind.INVARIANCE)
    planned = [Planned("spin, floor: linear, code"), Planned("spin, floor: linear, code", True)]
    assert missing_from([moved], planned) == planned[:1]
