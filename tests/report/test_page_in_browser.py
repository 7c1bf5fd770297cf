"""The report page in a headless Chromium, on a phone and on a desk: self-contained, accessible."""

from dataclasses import replace

import pytest

from harness.comparison.verdicts import Cell
from harness.report.gallery import draw_sections
from harness.report.page import report_page
from harness.report.sections import engines_section


@pytest.fixture(scope="module")
def path(verification, declared, sections, tmp_path_factory):
    first = verification.checks[0]
    many = [replace(first, name=f"row {n}", value=10.2 - n) for n in range(60)]
    in_cell = replace(first, name="in a cell", cell=Cell("slide", "spring", "wall", "toy"))
    found = replace(verification, checks=(*verification.checks, *many, in_cell), engines=declared)
    page = tmp_path_factory.mktemp("page") / "report.html"
    page.write_text(report_page(found, draw_sections([engines_section(declared), *sections])))
    return page


@pytest.mark.parametrize(("width", "scheme"), [(390, "light"), (1400, "dark")])
def test_the_page_asks_for_nothing_fits_its_screen_and_axe_finds_nothing(
    browser, barriers, path, width, scheme
):
    with browser.new_context(
        viewport={"width": width, "height": 844}, color_scheme=scheme, reduced_motion="reduce"
    ) as context:
        page = context.new_page()
        asked, complaints = [], []
        page.on("request", lambda request: asked.append(request.url))
        page.on("console", lambda message: complaints.append(message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.goto(path.as_uri())
        assert page.locator(".outcome b").is_visible()
        assert page.evaluate("document.documentElement.scrollWidth") == width
        page.locator("details").evaluate_all("all => all.forEach((one) => { one.open = true; })")
        assert page.locator("output").inner_text() == "66 of 66 checks"
        assert page.locator(".checks tbody tr").first.get_attribute("data-verdict") == "fail"
        page.get_by_label("Filter by verdict").select_option("not tested")
        assert page.locator(".checks tbody tr:not([hidden])").count() == 1
        assert barriers(page) == []
        page.locator("a.paper").first.click()
        assert page.locator("dialog img").is_visible()
        assert barriers(page) == []
        assert [url for url in asked if not url.startswith("data:")] == [path.as_uri()]
        assert complaints == []
