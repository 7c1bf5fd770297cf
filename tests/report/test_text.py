from harness.report.gallery import pictures
from harness.report.templating import number
from harness.report.text import angle_rows, markdown, summary


def test_kinds_stand_apart_and_rows_are_whole(verification):
    text = markdown(verification, [])
    titles = [line for line in text.splitlines() if line.startswith("## ")]
    assert titles[:3] == [
        "## Analytic: against a closed form",
        "## Cross-code: against another code or route, same law",
        "## Findings: differences between models, reported and not judged",
    ]
    assert "angle \\| fails" in text
    assert "out of time: 5 s" in text


def test_the_summary_counts_what_was_judged_kind_by_kind(verification):
    assert summary(verification)[:2] == [
        "**Failed: 1 analytic, 1 cross-code.**",
        "analytic 1 of 2 hold; cross-code 0 of 1 hold, 1 not tested; finding 1 reported.",
    ]


def test_missing_numbers_are_a_dash():
    assert number(float("nan")) == "-"
    assert number(-1.8e-15, 2) == "-1.8e-15"


def test_every_contact_has_its_rows(verification):
    steps, rows = angle_rows(verification)
    assert steps == [50.0, 100.0]
    assert {row[0] for row in rows} == {"source", "clipped", "plastic"}


def test_no_evidence_no_figures(verification):
    from dataclasses import replace

    from harness.comparison.evidence import InclineEvidence, TowerEvidence

    bare = replace(
        verification, incline=InclineEvidence(closed_form_deg=10.2), tower=TowerEvidence()
    )
    assert list(pictures(bare)) == []
