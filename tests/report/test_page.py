"""The report of a run: it holds every row and every failure, escaped, without scripts, offline."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import pandas as pd
import pytest
from markdown_it import MarkdownIt

from harness.report.causes import causes, entries_of
from harness.report.content import Section, Table
from harness.report.matrix import divided_setups, matrix, worst_verdicts
from harness.report.page import report_files
from harness.results.rows import Kind, Row, Verdict, rows_of, table
from tests.report.conftest import DEFECTS, HOSTILE


class Page(HTMLParser):
    """The tags of a page with their attributes, its text, and ids that links lead to."""

    def __init__(self, html):
        super().__init__()
        self.tags, self.words = [], []
        self.feed(html)
        self.text = " ".join(" ".join(self.words).split())

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        if self.tags and self.tags[-1][0] not in ("style", "script"):
            self.words.append(data)

    def values(self, name):
        return [attributes[name] for _, attributes in self.tags if attributes.get(name)]


@pytest.fixture(scope="module")
def files(run, sections):
    return report_files(run, sections, defects=DEFECTS)


@pytest.fixture(scope="module")
def page(files):
    return Page(files["report.html"])


def test_a_page_has_every_row_once_with_its_numbers(page, files, run):
    ids = [one for one in page.values("id") if one.startswith("row-")]
    assert len(ids) == len(set(ids)) == len(run.rows)
    lines = re.findall(r'<tr id="row-\d+">.*?</tr>', files["report.html"], re.DOTALL)
    texts = [Page(line).text for line in lines]
    for row in rows_of(run.rows):
        found = [text for text in texts if row.quantity in text and row.engine in text
                 and text.startswith(row.verdict)]  # fmt: skip
        assert any(row.value != row.value or f"{row.value:.8g}" in text for text in found), row.name


def test_every_failure_is_on_both_pages_with_reason_log_and_command(page, files, run):
    for row in rows_of(run.rows):
        if row.verdict is Verdict.FAIL:
            assert row.name.replace("|", "") in page.text.replace("|", "")
            assert row.setup.replace("|", r"\|") in files["report.md"]
    assert "ERROR: lost atoms" in page.text
    assert "dem-harness verify --only 'slope/clipped | 50 steps/critical_angle' --engines toy" in (
        page.text
    )


def test_a_known_defect_has_its_cause_and_releases_and_untested_rows_their_reasons(page, files):
    for text in (page.text, files["report.md"]):
        assert "Walls have no friction. Releases from 2023." in text
        assert "its walls mix no materials" in text


def test_scripts_are_linked_by_the_names_of_their_files_and_a_page_does_not_grow_with_them(run):
    names = [f"toy/slope: a = {n}" for n in range(1000)]
    many = replace(run, scripts=dict.fromkeys(names, "run 0\n" * 1000), logs={})
    html = report_files(many, [])["report.html"]
    assert 'href="scripts/toy/slope-a-=-0"' in html
    assert "all 1000 scripts" in html
    assert len(html) < 200_000


def test_nothing_of_a_page_comes_from_an_address_and_text_stays_text(page, files):
    assert all(source.startswith("data:") for source in page.values("src"))
    assert [tag for tag, _ in page.tags].count("script") == 1
    assert not [name for _, attributes in page.tags for name in attributes if name[:2] == "on"]
    for name in ("report.html", "report.md"):
        assert "\x1b" not in files[name]
    assert "<script>alert(1)" not in files["report.html"]
    shown = MarkdownIt("commonmark", {"html": False}).enable("table").render(files["report.md"])
    assert "<script>" not in shown
    assert "http://h/x.png" not in [a["src"] for t, a in Page(shown).tags if t == "img"]


def test_figures_are_files_with_names_of_their_own_and_a_broken_one_is_named(files, page):
    assert {"figures/angle.svg", "figures/angle-2.svg"} <= set(files)
    assert "figures/bad.svg" not in files
    assert "ZeroDivisionError: no rows" in page.text
    assert "ZeroDivisionError: no rows" in files["report.md"]
    assert "![The angle again](figures/angle-2.svg)" in files["report.md"]


def test_the_first_screen_has_the_answer_the_verdicts_and_what_is_not_tested(page, run):
    top = page.text[: page.text.index("Causes", 300)]
    for text in (run.headline, "10.20690 ± 0.00004 deg", "So θ_c = 10.2 deg.", "2 not tested"):
        assert text in top


def test_a_run_without_changes_text_or_scripts_has_a_page(run):
    bare = replace(run, rows=run.rows.iloc[:1], changes=None, scripts={}, logs={})
    files = report_files(bare, [Section("Nothing", tables=(Table("Empty", run.rows.iloc[:0]),))])
    assert "All verdicts hold" in files["report.html"]
    assert set(files) == {"report.html", "report.md"}


# ---- causes and matrices


def test_rows_of_one_defect_are_one_cause_and_failures_differ_by_engine_and_class(run):
    entries = entries_of(run.rows)
    found = causes(entries, DEFECTS)
    assert [cause.verdict for cause in found] == ["fail", "fail", "known defect", "not tested"]
    apart = [entry for entry in entries if entry.row.verdict in
             ("fail", "known defect", "fixed", "not tested")]  # fmt: skip
    assert sorted(e.id for cause in found for e in cause.entries) == sorted(e.id for e in apart)
    assert dict(found[-1].reasons)["its walls mix no materials"] == 1


def test_used_is_the_part_of_the_tolerance():
    row = Row(case="a", setup="", quantity="x", engine="e", value=3.0, expected=1.0, tolerance=4.0,
              kind=Kind.ANALYTIC, verdict=Verdict.PASS)  # fmt: skip
    (entry,) = entries_of(table([row]))
    assert (entry.used, entry.percent) == (0.5, "50 %")
    (exact,) = entries_of(table([replace(row, tolerance=0.0, value=1.0)]))
    assert exact.used == 0.0
    (without,) = entries_of(table([replace(row, tolerance=0.0)]))
    assert without.percent == ""


def test_a_matrix_counts_verdicts_and_names_the_gravest(run):
    counted = matrix(run.rows, "case", "engine")
    assert [badge.text for badge in counted.loc["slope", "other"]] == [
        "1 fail", "2 not tested", "1 pass",
    ]  # fmt: skip
    total = sum(int(badge.text.split()[0]) for cell in counted.loc["slope"] for badge in cell)
    assert total == len(run.rows)
    worst = worst_verdicts(run.rows, ("case", "setup"), "engine")
    assert worst.loc[("slope", "wall"), "toy"] == "known defect"
    assert worst.loc[("slope", "hangs"), "toy"] == ""
    assert ("slope", "plastic, 50 steps") not in divided_setups(run.rows).index


def test_an_empty_table_is_shown(run):
    files = report_files(replace(run, rows=run.rows.iloc[:0], changes=None), [])
    assert "Nothing was judged" in files["report.html"]
    assert isinstance(run.rows, pd.DataFrame)
    assert HOSTILE not in files["report.html"]
