import re

import pytest

from harness.report.gallery import Picture
from harness.reproduction.movies import Movie
from harness.reproduction.page import findings_text, html_page, markdown
from harness.theory.incline import critical_angle

SVG = '<svg width="400pt" viewBox="0 0 400 200" />'
PICTURE = Picture("fig-04-velocity-series", "Figure 4", "It agrees.", SVG, b"")
FILM = Movie("two-particles", "Two particles", "They exchange.", b"GIF", b"PNG", b"dump")


def test_findings_have_the_numbers_of_the_run(reproduction):
    text = findings_text(reproduction)
    assert "| 0.5 | 6.25 | 15.08 | 10.500 ± 0.003 | 10.500 ± 0.003 |" in text
    assert "moves by +0.25 deg; the readings say -3.96 and +4.88" in text
    assert "95 % of the fall" in text
    assert "{{" not in text
    assert "nan" not in text


def test_findings_follow_the_tables(reproduction):
    assert f"crosses theory at f = {10 ** ((critical_angle() - 10.14) / 0.03):.0f} " in (
        findings_text(reproduction)
    )
    reproduction.findings.mfix["euler_deg"] += 0.1
    assert "crosses theory" not in findings_text(reproduction)


def test_markdown_holds_ledger_figures_and_movies(reproduction):
    text = markdown(reproduction, [PICTURE], [FILM], "../..")
    assert "| Background, eq. (6) | theta/4 \\| in the sine | reproduced with a c" in text
    assert "Correction: theta/2." in text
    assert "[test_shock](../../tests/theory/test_shock.py)" in text
    assert "![Figure 4](figures/fig-04-velocity-series.svg)" in text
    assert "movies/two-particles.gif" in text
    assert "dumps/two-particles.dump.gz" in text
    assert "A figure of others." in text


@pytest.mark.parametrize("key", ["eq-6", "fig-12"])
def test_page_has_every_row(reproduction, key):
    page = html_page(reproduction, [PICTURE], [FILM], "../..")
    assert f'id="{key}"' in page
    assert 'data-status="reproduced with a correction"' in page
    assert ">Two readings of the restitution</h3>" in page


def test_page_asks_for_nothing_from_outside(reproduction):
    page = html_page(reproduction, [PICTURE], [FILM], "../..")
    assert not re.findall(r'(?:src|href)="(?:https?:)?//', page)
