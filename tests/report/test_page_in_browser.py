"""The report page in a browser, on a phone and on a desk: offline, sorted, filtered, accessible."""

from dataclasses import replace

import pytest

from harness.report.page import report_files
from harness.results.rows import table
from tests.report.conftest import DEFECTS, rows


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
