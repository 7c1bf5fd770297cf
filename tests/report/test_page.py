"""The report of a run: every row and failure is in it, escaped, offline; causes and matrices."""

import base64
import gzip
import json
import re
from dataclasses import replace

import pytest
from markdown_it import MarkdownIt

from harness.report.content import Section, Table
from harness.report.page import COLUMNS, causes, divided_setups, entries_of, report_files
from harness.report.render import matrix
from harness.results.rows import Verdict, rows_of, table
from tests.report.conftest import ANGLE, DEFECTS, HOSTILE, Page, rows


def unpacked(html):
    """Return the packed rows of a page, a tuple of texts each."""
    text = json.loads(re.search(r'id="packed">(.*?)</script>', html)[1])
    return list(zip(*json.loads(gzip.decompress(base64.b64decode(text))), strict=True))


@pytest.fixture(scope="module")
def files(run, sections):
    return report_files(run, sections, defects=DEFECTS)


@pytest.fixture(scope="module")
def page(files):
    return Page(files["report.html"])


def test_a_page_has_every_row_once_with_its_numbers_note_and_log(files, run):
    lines = unpacked(files["report.html"])
    assert len(lines) == len(run.rows)
    for row in rows_of(run.rows):
        key = (row.verdict, row.engine, row.quantity, row.setup.split("\x1b")[0])
        (line,) = [t for t in lines if key[:2] == (t[0], t[3]) and all(w in t[1] for w in key[2:])]
        assert row.value != row.value or f"{row.value:.8g}" == line[COLUMNS.index("value")]
        assert row.log in line
        assert row.note.split("\x1b")[0] in "".join(line)
    assert "\x1b" not in str(lines)


def test_a_page_of_thousands_of_rows_is_small_and_shows_the_gravest_without_a_script(run):
    passed = [replace(ANGLE, verdict=Verdict.PASS, setup=f"{n} steps") for n in range(2000)]
    rows = table([*passed, replace(ANGLE, verdict=Verdict.FAIL, setup="bad")])
    scripts = dict.fromkeys([f"toy/slope: a = {n}" for n in range(400)], "run 0\n" * 1000)
    html = report_files(replace(run, rows=rows, scripts=scripts), [])["report.html"]
    assert len(html) < 250_000
    assert len(unpacked(html)) == 2001
    lines = re.findall(r'<tr id="row-\d+">.*?</tr>', html, re.DOTALL)
    assert len(lines) == 25
    assert Page(lines[0]).text.startswith("fail slope: bad: critical_angle")


def test_every_failure_is_on_both_pages_with_reason_and_command(page, files, run):
    for row in rows_of(run.rows):
        if row.verdict is Verdict.FAIL:
            assert row.name.replace("|", "") in page.text.replace("|", "")
            assert row.setup.replace("|", r"\|") in files["report.md"]
    assert "ERROR: lost atoms" in page.text
    assert "dem-harness verify --only 'slope/clipped | 50 steps/critical_angle' --engines toy" in (
        page.text
    )
    full = replace(rows_of(run.rows)[0], verdict=Verdict.FAIL, level="full")
    (cause,) = causes(entries_of(table([full])), {})
    assert cause.command.startswith("dem-harness verify --full --only ")
    for text in (page.text, files["report.md"]):
        assert "Walls have no friction. Releases from 2023." in text
        assert "its walls mix no materials" in text


def test_nothing_of_a_page_comes_from_an_address_and_text_stays_text(page, files):
    assert all(source.startswith("data:") for source in page.values("src"))
    assert [attrs.get("id", "") for tag, attrs in page.tags if tag == "script"] == ["packed", ""]
    assert not [name for _, attributes in page.tags for name in attributes if name[:2] == "on"]
    for name in ("report.html", "report.md"):
        assert "\x1b" not in files[name]
    assert "<script>alert(1)" not in files["report.html"]
    shown = MarkdownIt("commonmark", {"html": False}).enable("table").render(files["report.md"])
    assert "<script>" not in shown
    images = Page(shown).values("src")
    assert images == ["figures/angle.svg", "figures/angle-2.svg"]  # http://h/x.png is text
    assert set(images) <= set(files)
    assert "figures/bad.svg" not in files
    assert "ZeroDivisionError: no rows" in page.text


def test_runs_with_one_row_or_none_and_empty_tables_have_a_page(run):
    bare = replace(run, rows=run.rows.iloc[:1], changes=None, scripts={}, logs={})
    files = report_files(bare, [Section("Nothing", tables=(Table("Empty", run.rows.iloc[:0]),))])
    assert "All verdicts hold" in files["report.html"]
    assert set(files) == {"report.html", "report.md"}
    none = report_files(replace(bare, rows=run.rows.iloc[:0]), [])
    assert "Nothing was judged" in none["report.html"]
    assert unpacked(none["report.html"]) == []


# ---- causes and matrices


def test_rows_of_one_defect_are_one_cause_and_failures_differ_by_engine_and_class(run):
    entries = entries_of(run.rows)
    groups = causes(entries, DEFECTS)
    assert [cause.verdict for cause in groups] == ["fail", "fail", "known defect", "not tested"]
    judged = [entry.number for entry in entries if entry.row.verdict not in
              ("pass", "finding", "recorded")]  # fmt: skip
    assert sorted(entry.number for cause in groups for entry in cause.entries) == judged
    assert dict(groups[-1].reasons)["its walls mix no materials"] == 1
    several = replace(entries[0].row, verdict=Verdict.KNOWN_DEFECT,
                      defect="walls-without-friction, soft")  # fmt: skip
    soft = {"cause": "springs are soft", "upstream": "issue 13", "script": "in.soft"}
    (cause,) = causes(entries_of(table([several])), {**DEFECTS, "soft": soft})
    assert cause.sentences[0].endswith(" Springs are soft.")
    assert "Upstream: issue 13." in cause.sentences
    assert cause.command.splitlines()[1] == "dem-harness defect soft"
    hides = {"soft": {**soft, "undetermined": "the order is not known"}}
    (cause,) = causes(entries_of(table([replace(several, defect="soft")])), hides)
    assert cause.sentences[-1].startswith("Not computed, so that other faults may hide here: the")
    used = {(3.0, 4.0): "50 %", (1.0, 0.0): "0 %", (3.0, 0.0): "", (1e6, 1.0): "> 1e4 %"}
    for (value, tolerance), percent in used.items():
        row = replace(ANGLE, value=value, expected=1.0, tolerance=tolerance, verdict=Verdict.PASS)
        assert entries_of(table([row]))[0].used == percent


def test_a_matrix_counts_verdicts_and_names_the_gravest(run):
    counted = matrix(run.rows, "case", "engine")
    assert [badge.text for badge in counted.loc["slope", "other"]] == [
        "1 fail", "2 not tested", "1 pass",
    ]  # fmt: skip
    total = sum(int(badge.text.split()[0]) for cell in counted.loc["slope"] for badge in cell)
    assert total == len(run.rows)
    divided = divided_setups(run.rows)
    assert divided.loc[("slope", "wall"), "toy"] == "known defect"
    assert divided.loc[("slope", "hangs"), "toy"] == ""
    assert ("slope", "plastic, 50 steps") not in divided.index
    assert HOSTILE not in divided.index.unique("setup")


# ---- in a browser, on a phone and on a desk


@pytest.fixture(scope="module")
def path(run, sections, tmp_path_factory):
    many = [replace(rows()[0], setup=f"{n} steps", value=10.2 - n / 7) for n in range(60)]
    page = tmp_path_factory.mktemp("page") / "report.html"
    more = replace(run, rows=table([*rows(), *many]))
    page.write_text(report_files(more, sections, defects=DEFECTS)["report.html"])
    return page


@pytest.mark.parametrize(("width", "scheme"), [(390, "light"), (1400, "dark")])
def test_a_page_fits_its_screen_sorts_and_filters_offline_and_axe_finds_nothing(
    browser, barriers, path, width, scheme
):
    with browser.new_context(
        viewport={"width": width, "height": 844}, color_scheme=scheme, reduced_motion="reduce"
    ) as context:
        page = context.new_page()
        requests, errors = [], []
        page.on("request", lambda request: requests.append(request.url))
        page.on("console", lambda message: errors.append(message.text))
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto(path.as_uri())
        assert page.locator(".outcome b").is_visible()
        assert page.evaluate("document.documentElement.scrollWidth") == width
        page.locator("details").evaluate_all("all => all.forEach((one) => { one.open = true; })")
        assert page.locator("output").inner_text() == "69 of 69 rows"
        shown = page.locator(".rows tbody tr")
        assert shown.count() == 25
        assert shown.first.locator("td").first.inner_text() == "fail"
        assert barriers(page) == []

        page.get_by_label("Sort by").select_option(label="value")
        assert "59 steps" in shown.first.inner_text()
        page.get_by_label("Filter by verdict").select_option("not tested")
        assert shown.count() == 2
        page.get_by_label("Filter by text").fill("mix no materials")
        assert shown.count() == 1

        page.get_by_role("button", name="Enlarge: The angle", exact=True).click()
        assert page.locator("dialog img").is_visible()
        assert barriers(page) == []
        page.keyboard.press("Escape")

        page.get_by_role("link", name="1 row", exact=True).first.click()  # filtered away
        page.locator(".rows tbody tr", has_text="clipped").wait_for(timeout=5000)
        assert shown.count() == 1
        page.locator(".cause.fail li a").first.click()
        page.locator("tr.target").wait_for(timeout=5000)
        page.get_by_role("button", name="Show all 69").click()
        assert shown.count() == 25
        assert [url for url in requests if not url.startswith("data:")] == [path.as_uri()]
        assert errors == []
