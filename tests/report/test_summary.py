from dataclasses import replace

from harness.comparison.verdicts import Verdict
from harness.report.folder import short_markdown
from harness.report.text import headline

COMMENT = 65_536
"""Characters that a comment on GitHub holds."""


def test_failures_come_first_and_all_else_is_folded(verification):
    text = short_markdown(verification)
    opened = text.index("<details>")
    for said in ("angle \\| fails", "a run that hung", "out of time: 5 s", "not installed"):
        assert text.index(said) < opened
    for said in ("angle &lt;holds>", "laws differ"):
        assert text.index(said) > opened
    assert text.count("<details>") == text.count("</details>")


def test_a_run_that_holds_has_no_table_of_failures(verification):
    text = short_markdown(replace(verification, checks=verification.checks[:1]))
    assert "All verdicts hold" in text
    assert "what happened" not in text


def test_however_many_rows_it_fits_into_a_comment(verification):
    wordy = [replace(check, note="n" * 900, name="x" * 300) for check in verification.checks]
    text = short_markdown(replace(verification, checks=tuple(wordy * 400)))
    assert len(text) < COMMENT
    assert "more, in report.html" in text


def test_text_opens_no_tag_and_mentions_nobody(verification):
    check = replace(verification.checks[1], name="<script> @somebody\nnew | row \x1b[31mred")
    text = short_markdown(replace(verification, checks=(check,)))
    assert "<script>" not in text
    assert "@somebody" not in text
    assert "&lt;script> @\u200bsomebody new \\| row red |" in text


def test_the_headlines_are_told_with_who_measured_them(verification):
    told = "- critical angle: expected 10.2078 deg; toy 10.2070 ± 0.0004 deg (step to 0)"
    assert told in short_markdown(verification).splitlines()


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
