import re

from harness.report.gallery import Picture
from harness.reproduction.page import html_page, markdown
from harness.theory.incline import critical_angle

SVG = '<svg width="400pt" viewBox="0 0 400 200" />'
PICTURE = Picture("fig-04-velocity-series", "Figure 4", "It agrees.", SVG, b"")


def test_findings_have_the_numbers_of_the_run(reproduction):
    text = markdown(reproduction, [PICTURE], "../..")
    assert "| 0.5 | 6.25 | 15.08 | 10.500 ± 0.003 | 10.500 ± 0.003 |" in text
    assert "95 % of the fall" in text
    assert f"theory at f = {10 ** ((critical_angle() - 10.14) / 0.03):.0f} " in text
    assert not re.search(r"\bnan\b", text)
    reproduction.findings.mfix["euler_deg"] += 0.1
    assert "crosses theory" not in markdown(reproduction, [PICTURE], "../..")


def test_both_pages_have_every_row_and_ask_for_nothing_from_outside(reproduction):
    text = markdown(reproduction, [PICTURE], "../..")
    assert "[test_shock](../../tests/theory/test_shock.py)" in text
    assert "(figures/fig-04-velocity-series.svg)" in text
    page = html_page(reproduction, [PICTURE], "../..")
    for row in reproduction.ledger.statements:
        assert f"| {row.source.where} |" in text
        assert f'id="{row.source.key}"' in page
    assert not re.findall(r'(?:src|href)="(?:https?:)?//', page)
