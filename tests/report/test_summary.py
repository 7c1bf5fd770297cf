"""The head of report.md is what a pull request shows, and the whole fits into a comment."""

from dataclasses import replace

from harness.comparison.verdicts import Verdict
from harness.report.page import LIMIT, report_markdown, shortened
from harness.report.text import headline


def test_verdicts_and_failures_come_before_all_else(verification):
    text = report_markdown(verification, [])
    assert text.splitlines()[2] == "**Failed: 1 analytic, 1 cross-code**"
    told = "- critical angle: expected 10.2078 deg; toy 10.2070 ± 0.0004 deg (step to 0)"
    assert told in text.splitlines()
    head = text[: text.index("## Verdicts")]
    for said in ("analytic ", "angle \\| fails", "a run that hung", "out of time: 5 s"):
        assert said in head
    assert "not tested: " in head
    assert "laws differ" not in head


def test_however_many_rows_it_fits_into_a_comment(verification):
    wordy = [replace(check, note="n" * 900, name="x" * 300) for check in verification.checks]
    text = report_markdown(replace(verification, checks=tuple(wordy * 400)), [])
    assert len(text) < LIMIT
    assert "more rows are left out; results.csv has every check." in text
    assert "## Provenance" in text


def test_the_longest_tables_are_cut_and_what_is_left_out_is_counted():
    def table(rows):
        return "\n".join(["| a |", "|---|", *(f"| {n} |" for n in range(rows))])

    text = f"# T\n\n{table(1000)}\n\nwords\n\n{table(5)}\n"
    assert shortened(text, 100_000) == text
    cut = shortened(text, 3_000)
    assert len(cut) < 3_000
    assert table(5) in cut
    kept = cut[: cut.index("more rows")].count("| ") - 1
    assert f"{1000 - kept} more rows are left out" in cut
    words = shortened("one\n\n" + "two " * 1000, 500)
    assert words == "one\n\nThe rest is in report.html.\n"


def test_text_opens_no_tag_and_mentions_nobody(verification):
    check = replace(verification.checks[1], name="<script> @somebody\nnew | row \x1b[31mred")
    text = report_markdown(replace(verification, checks=(check,)), [])
    assert "<script>" not in text
    assert "@somebody" not in text
    assert "&lt;script> @\u200bsomebody new \\| row red |" in text


def test_the_headline_counts_known_defects_and_what_was_not_tested(verification):
    holds, other = verification.checks[0], verification.checks[1]
    defect = replace(other, verdict=Verdict.KNOWN_DEFECT)
    untested = replace(other, verdict=Verdict.NOT_TESTED)
    text = headline([holds, defect, defect, untested])
    assert text == "All verdicts hold; 2 known defects, 1 not tested"
    assert headline([holds]) == "All verdicts hold"
    assert headline([untested], ["oblique", "spin"]) == "Nothing was tested in oblique, spin"
    text = headline([holds, untested], ["spin"])
    assert text == "Nothing was tested in spin; all other verdicts hold; 1 not tested"
