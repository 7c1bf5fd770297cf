"""The pages in a real headless Chromium: what they load, show first, sort and enlarge."""

import io
import json
import re
import shutil
from dataclasses import replace

import pypdf
import pytest

from harness.comparison.run_diff import diff_runs
from harness.comparison.verification import read_published
from harness.report.folder import write_diff
from harness.report.gallery import draw_sections
from harness.report.page import report_page
from harness.report.plain import finite
from harness.report.sections import engines_section

DESK, PHONE = (1280, 800), (390, 844)
SIZES = pytest.mark.parametrize("size", [DESK, PHONE], ids=["desk", "phone"])
LOOKS = pytest.mark.parametrize(
    ("size", "scheme"),
    [
        pytest.param(DESK, "dark", id="desk-dark"),
        pytest.param(PHONE, "light", id="phone-light"),
        # each size and each scheme is above once
        pytest.param(DESK, "light", id="desk-light", marks=pytest.mark.slow),
        pytest.param(PHONE, "dark", id="phone-dark", marks=pytest.mark.slow),
    ],
)
OTHER_PAGES = [pytest.param(name, marks=pytest.mark.slow) for name in ("engines", "diff")]
PAGES = pytest.mark.parametrize("name", ["report", *OTHER_PAGES])
FIGURES = 6
A4_WIDTH = 710
"""Pixels of CSS between the margins of a sheet."""

NAMES = "rows => rows.map((row) => row.querySelector('.what').innerText.trim().split('\\n')[0])"
VALUES = "rows => rows.map((row) => row.cells[3].textContent.trim())"


@pytest.fixture(scope="module")
def pages(verification, declared, sections, tmp_path_factory):
    """Write a report with many rows, one that holds, one of engines, and two runs side by side."""
    folder = tmp_path_factory.mktemp("pages")
    many = [replace(verification.checks[0], name=f"row {n}", value=10.2 - n) for n in range(60)]
    found = replace(verification, checks=(*verification.checks, *many))
    holding = [check for check in verification.checks if check.verdict in ("pass", "finding")]
    shown = draw_sections(sections)
    engines = draw_sections([engines_section(declared)])
    runs = {
        "report": (found, shown),
        "holds": (replace(found, checks=tuple(holding * 3)), shown),
        "engines": (replace(found, engines=declared), [*engines, *shown]),
    }
    for name, (run, drawn) in runs.items():
        (folder / f"{name}.html").write_text(report_page(run, drawn))
    (folder / "run" / "figures").mkdir(parents=True)
    for picture in shown[0].pictures:
        (folder / "run" / "figures" / f"{picture.name}.svg").write_text(picture.svg)
    before, after = (
        read_published(json.loads(json.dumps(finite(run.to_json()))))
        for run in (found, verification)
    )
    write_diff(diff_runs(before, after), folder / "run", folder / "run", folder / "two")
    shutil.copy(folder / "two" / "diff.html", folder)
    return folder


@pytest.fixture
def look(browser, pages):
    """Return a function that opens a page; whatever it asks for or complains of is kept."""
    contexts = []

    def open_page(
        name="report", size=DESK, scheme="light", scripts=True, fragment="", unfold=False
    ):
        context = browser.new_context(
            viewport=dict(zip(("width", "height"), size, strict=True)),
            color_scheme=scheme,
            java_script_enabled=scripts,
            reduced_motion="reduce",
        )
        contexts.append(context)
        page = context.new_page()
        page.asked, page.complaints = [], []
        page.on("request", lambda request: page.asked.append(request.url))
        page.on("console", lambda message: page.complaints.append(message.text))
        page.on("pageerror", lambda error: page.complaints.append(str(error)))
        page.goto((pages / f"{name}.html").as_uri() + fragment)
        if unfold and page.locator(".fold").count():
            page.locator(".fold > summary").click()
        return page

    yield open_page
    for context in contexts:
        context.close()


def bottom(page, selector):
    found = page.locator(selector).first.bounding_box()
    return found["y"] + found["height"]


def names(page):
    """Return the names of the checks that are shown, in order."""
    return page.locator(".checks tbody tr:not([hidden])").evaluate_all(NAMES)


@PAGES
@SIZES
def test_nothing_is_asked_for_and_nothing_complained_of(look, pages, name, size):
    page = look(name, size)
    page.keyboard.press("End")
    page.wait_for_load_state("networkidle")
    assert {url for url in page.asked if not url.startswith("data:")} == {
        (pages / f"{name}.html").as_uri()
    }
    assert page.complaints == []


@PAGES
@SIZES
@pytest.mark.parametrize("scripts", [True, False], ids=["scripts", "no-scripts"])
def test_no_page_is_wider_than_the_screen(look, name, size, scripts):
    page = look(name, size, scripts=scripts)
    if scripts:
        assert page.evaluate("document.documentElement.scrollWidth") == size[0]
    for selector in ("main", ".hero", ".table", ".files, figure"):
        for found in page.locator(selector).all():
            place = found.bounding_box()
            assert place is None or place["x"] + place["width"] <= size[0]


@SIZES
def test_the_first_screen_has_outcome_headlines_failures_and_where_they_are(look, size):
    page = look(size=size)
    for selector in (".outcome b", ".headlines", ".kinds", "#causes"):
        assert bottom(page, selector) <= size[1]
    said = page.locator(".hero").inner_text()
    for text in ("Failed: 1 analytic, 1 cross-code", "61 hold", "toy 10.2070 ± 0.0004 deg"):
        assert text in said
    listed = page.locator(".causes").inner_text()
    assert "angle | fails" in listed
    assert "out of time" in listed


@SIZES
def test_a_run_that_holds_has_its_verdicts_on_the_first_screen_and_its_rows_folded(look, size):
    page = look("holds", size)
    assert "All verdicts hold" in page.locator(".outcome").inner_text()
    assert bottom(page, ".kinds tbody tr") <= size[1]
    assert page.locator("#causes").count() == 0
    assert not page.locator(".checks tbody tr").first.is_visible()
    page.locator(".fold > summary").click()
    assert page.locator(".checks tbody tr").first.is_visible()


def test_what_fails_is_grouped_by_its_cause_and_leads_to_its_row(look):
    page = look()
    causes = page.locator(".cause")
    assert [one.get_attribute("class").split()[2] for one in causes.all()] == [
        *("fail", "fail", "not-tested"),
    ]
    page.locator(".cause a", has_text="angle | fails").click()
    row = page.locator(".checks tbody tr", has_text="angle | fails")
    assert row.is_visible()


def test_failures_are_the_first_rows_and_open(look):
    page = look(unfold=True)
    first = page.locator(".checks tbody tr").first
    assert first.get_attribute("data-verdict") == "fail"
    assert first.locator(".in").is_visible()
    assert not page.locator(".checks tbody tr[data-verdict=pass] .in").first.is_visible()


@pytest.mark.parametrize(
    ("presses", "direction", "first"),
    [(1, "ascending", "row 59"), (2, "descending", "angle | fails")],
)
def test_a_head_sorts_by_its_numbers(look, presses, direction, first):
    page = look(unfold=True)
    head = page.locator(".checks th", has_text="value")
    for _ in range(presses):
        head.get_by_role("button").focus()
        page.keyboard.press("Enter")
    assert head.get_attribute("aria-sort") == direction
    assert page.locator("th[aria-sort]").count() == 1
    assert names(page)[0].startswith(first)
    values = page.locator(".checks tbody tr").evaluate_all(VALUES)
    numbers = [float(value) for value in values if value != "-"]
    assert numbers == sorted(numbers, reverse=direction == "descending")
    assert values[-2:] == ["-", "-"]  # what is missing is last, both ways


def test_a_third_press_brings_the_first_order_back(look):
    page = look(unfold=True)
    before = names(page)
    for _ in range(3):
        page.locator(".checks th", has_text="value").get_by_role("button").click()
    assert page.locator("th[aria-sort]").count() == 0
    assert names(page) == before


def test_the_filters_work_together_and_say_how_many(look):
    page = look(unfold=True)
    assert page.locator("output").inner_text() == "65 of 65 checks"
    assert len(names(page)) == 25
    page.get_by_role("button", name="Show all 65").click()
    assert len(names(page)) == 65
    page.get_by_label("Filter by text").fill("row 1")
    assert len(names(page)) == 15  # row 1, 10 to 19, 21, 31, 41, 51
    page.get_by_label("Filter by kind").select_option("cross-code")
    assert names(page) == []
    page.get_by_label("Filter by text").fill("")
    page.get_by_label("Filter by verdict").select_option("not tested")
    assert names(page) == ["no engine"]
    assert page.locator("output").inner_text() == "1 of 65 checks"


def test_a_phone_sorts_by_a_list(look):
    page = look(size=PHONE, unfold=True)
    page.get_by_label("Sort", exact=True).select_option("value, rising")
    assert names(page)[0] == "row 59"


def test_a_link_to_a_row_that_is_not_shown_shows_it(look):
    page = look(fragment="#check-60")
    row = page.locator("#check-60")
    assert row.is_visible()
    assert 0 <= row.bounding_box()["y"] < DESK[1]


def test_without_scripts_every_row_is_there_and_no_dead_control(look):
    page = look(scripts=False, unfold=True)
    assert page.locator(".checks tbody tr").count() >= 65
    assert page.locator("#check-65").is_visible()
    assert not page.locator(".filters").is_visible()
    assert not page.locator(".more").is_visible()


@SIZES
def test_a_figure_opens_large_zooms_and_closes_by_keyboard(look, size):
    page = look(size=size)
    dialog, image = page.locator("dialog"), page.locator("dialog img")
    link = page.locator("a.paper").first
    link.focus()
    page.keyboard.press("Enter")
    assert dialog.is_visible()
    fitted = image.bounding_box()
    assert fitted["width"] >= 0.9 * size[0] or fitted["height"] >= 0.7 * size[1]
    assert fitted["width"] <= size[0]
    page.keyboard.press("+")
    assert image.bounding_box()["width"] > 1.4 * fitted["width"]
    title = dialog.locator("b").inner_text()
    page.keyboard.press("ArrowRight")
    assert dialog.locator("b").inner_text() != title
    page.keyboard.press("Escape")
    assert not dialog.is_visible()
    assert page.evaluate("document.activeElement.matches('a.paper')")


@PAGES
@LOOKS
def test_axe_finds_nothing(look, barriers, name, size, scheme):
    page = look(name, size, scheme)
    assert barriers(page) == []


def test_axe_finds_nothing_beside_a_large_figure_and_open_rows(look, barriers):
    page = look()
    page.locator("details").evaluate_all("all => all.forEach((one) => { one.open = true; })")
    assert barriers(page) == []
    page.locator("a.paper").first.click()
    assert barriers(page) == []


def test_a_row_is_read_out_as_one_of_a_table_on_a_phone_too(look):
    row = look(size=PHONE, unfold=True).locator(".checks").get_by_role("row").nth(1)
    assert row.get_by_role("cell").count() == 10


def test_dark_is_dark_but_for_the_figures(look):
    page = look(scheme="dark")
    colours = [
        page.locator(selector).first.evaluate("node => getComputedStyle(node).backgroundColor")
        for selector in ("body", "a.paper")
    ]
    page_sum, paper_sum = (sum(map(int, c.strip("rgb()").split(","))) for c in colours)
    assert page_sum < 120
    assert paper_sum == 3 * 255


@SIZES
def test_every_figure_is_drawn(look, size):
    page = look(size=size)
    drawn = page.evaluate(
        "async () => { const all = [...document.querySelectorAll('figure img')];"
        " await Promise.all(all.map((i) => i.decode()));"
        " return all.map((i) => i.naturalWidth > 100 && i.clientWidth > 250); }"
    )
    assert len(drawn) == FIGURES
    assert all(drawn)


def test_figures_stand_two_to_a_row_but_for_wide_and_tall_ones_and_leave_no_hole(look):
    page = look()
    places = {
        name: page.locator(f"#{name} img").bounding_box()
        for name in ("one", "two", "broad", "four-rows", "odd")
    }
    main = page.locator("main").bounding_box()["width"]
    assert places["one"]["y"] == places["two"]["y"]
    assert places["one"]["width"] < 0.5 * main < places["broad"]["width"]
    # a panel of a figure with four rows is as large as one that stands alone
    assert places["four-rows"]["width"] / 2 > 0.7 * places["one"]["width"]
    assert places["four-rows"]["height"] / 4 > 0.6 * places["one"]["height"]
    assert places["odd"]["width"] > 0.5 * main  # nothing is left to stand beside it


def test_wide_figures_of_two_runs_stand_one_above_the_other(look):
    page = look("diff")
    wide = page.locator(".pair", has=page.locator("img[alt='broad']")).locator("img").first
    assert wide.bounding_box()["width"] > 0.6 * DESK[0]


def test_the_words_of_a_figure_are_as_large_on_a_phone_as_a_page_needs(look):
    page = look(size=PHONE)
    for name in ("one", "broad", "four-rows"):
        image = page.locator(f"#{name} img")
        # the smallest words, of legends, are 8.7 pt, and a reader needs 8 pixels of them
        assert 8.7 * image.bounding_box()["width"] / float(image.get_attribute("width")) > 8
        assert page.locator(f"#{name} a").bounding_box()["width"] <= PHONE[0]


@pytest.mark.parametrize("width", [390, 740, 1280])
def test_a_figure_that_is_wider_than_its_place_says_so(look, width):
    page = look(size=(width, 844))
    for name in ("one", "broad", "four-rows"):
        scrolls, hint = page.locator(f"#{name} a").evaluate(
            "a => [a.scrollWidth > a.clientWidth, getComputedStyle(a, '::before').content]"
        )
        assert scrolls == ("Swipe" in hint), name


@pytest.mark.parametrize("scheme", [pytest.param("light", marks=pytest.mark.slow), "dark"])
@PAGES
def test_print_shows_every_column_dark_on_white(look, barriers, name, scheme):
    page = look(name, (A4_WIDTH, 1000), scheme)
    page.emulate_media(media="print", color_scheme=scheme)
    for head in page.locator(".checks thead th").all():
        place = head.bounding_box()
        assert place["width"] > 10
        assert place["x"] + place["width"] <= A4_WIDTH
    assert page.locator(".checks tbody tr:visible").count() >= 65
    assert page.evaluate("document.documentElement.scrollWidth") <= A4_WIDTH
    paper, ink = page.evaluate(
        "() => { const body = getComputedStyle(document.body);"
        " return [body.backgroundColor, body.color]; }"
    )
    assert paper == "rgb(255, 255, 255)"
    assert sum(map(int, ink.strip("rgb()").split(","))) < 120
    assert barriers(page) == []


def test_every_sheet_of_the_checks_has_their_head(look):
    sheets = pypdf.PdfReader(io.BytesIO(look().pdf(format="A4"))).pages
    said = [sheet.extract_text() for sheet in sheets]
    rows = [text for text in said if re.search(r"\brow \d+", text)]
    assert len(rows) > 1
    for text in rows:
        assert all(head in text for head in ("verdict", "expected", "uncertainty", "tolerance"))
