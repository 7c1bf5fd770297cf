import math

import pytest

from harness.observables.row import Row
from harness.report.plain import markdown_text, one_line, printable, safe_path
from harness.report.text import headline_lines, summary, value_text


def test_the_summary_counts_what_was_judged_kind_by_kind_and_tells_the_headlines(verification):
    assert summary(verification) == [
        "Failed: 1 analytic, 1 cross-code.",
        "analytic 1 of 2 hold; cross-code 0 of 1 hold, 1 not tested; finding 1 reported.",
        "critical angle: expected 10.2078 deg; toy 10.2070 ± 0.0004 deg (step to 0)",
    ]


@pytest.mark.parametrize(
    ("value", "uncertainty", "said"),
    [
        (10.206981, 0.00042, "10.2070 ± 0.0004 deg"),
        (10.206981, 0.00012, "10.20698 ± 0.00012 deg"),
        (10.206981, 0.00099, "10.2070 ± 0.0010 deg"),
        (1234.5, 20.0, "1234 ± 20 deg"),
        (10.206981, 0.0, "10.206981 deg"),
        (10.206981, math.nan, "10.206981 deg"),
        (math.nan, 0.1, "- deg"),
        (1.0, 3e-300, "1 deg"),
    ],
)
def test_a_value_goes_to_the_first_digit_of_its_uncertainty(value, uncertainty, said):
    assert value_text(value, uncertainty, "deg") == said


def test_the_engine_of_a_headline_is_who_measured_it():
    (line,) = headline_lines([Row("restitution", 0.51, 0.02, "", 0.5, "my code")])
    assert line == "restitution: expected 0.50; my code 0.51 ± 0.02"


@pytest.mark.parametrize(
    ("text", "left"),
    [
        ("\x1b[31mred\x1b[0m", "red"),
        ("\x1b]0;title\x07text", "text"),
        ("\x1b]8;;http://h\x1b\\link\x1b]8;;\x1b\\", "link"),
        ("bell \x07, back \x08, \x9b31m", "bell ?, back ?, ?31m"),
        ("a\tb\r\nc", "a\tb\nc"),
        ("turned \u202ebox", "turned ?box"),
        ("half \udc80", "half ?"),
    ],
)
def test_nothing_of_an_engine_moves_the_cursor(text, left):
    assert printable(text) == left


def test_text_in_markdown_stays_text():
    assert markdown_text("a & <b> [c](d) *e* `f` | g\nh") == (
        "a &amp; &lt;b> \\[c\\](d) \\*e\\* \\`f\\` \\| g h"
    )
    assert one_line(" a\n\nb ") == "a b"


@pytest.mark.parametrize(
    ("name", "path"),
    [
        ("incline.in", "incline.in"),
        ("code/case.py", "code/case.py"),
        ("../../etc/passwd", "etc/passwd"),
        ("/abs/./x", "abs/x"),
        ("a b?c#d", "a-b-c-d"),
        ("...", "unnamed"),
        ("", "unnamed"),
        ("x" * 300, "x" * 100),
    ],
)
def test_a_path_stays_below_its_folder(name, path):
    assert safe_path(name) == path
