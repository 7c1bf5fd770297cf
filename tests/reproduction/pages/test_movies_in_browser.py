"""The page in a browser: movies still until started, and nothing that axe objects to."""

import pytest

from harness.reproduction.movies import Film
from harness.reproduction.pages.page import html_page

FILM = Film("two-particles", "Two particles", "They exchange.", b"", b"", b"")


def test_a_movie_is_still_until_it_is_started(browser, reproduction, tmp_path):
    path = tmp_path / "report.html"
    path.write_text(html_page(reproduction, [], [FILM], "../.."), encoding="utf-8")
    page = browser.new_page()
    page.goto(path.as_uri())
    image, button = page.locator(".movies img"), page.locator(".play")
    assert image.get_attribute("src") == "movies/two-particles.png"
    assert button.get_attribute("aria-label") == "Play: Two particles"
    button.click()
    assert image.get_attribute("src") == "movies/two-particles.gif"
    assert button.inner_text() == "Stop"
    page.emulate_media(reduced_motion="reduce")
    page.wait_for_selector('.movies img[src="movies/two-particles.png"]', state="attached")
    button.click()
    button.click()
    assert image.get_attribute("src") == "movies/two-particles.png"
    page.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1300, 390])
def test_axe_finds_nothing(browser, barriers, reproduction, tmp_path, width, scheme):
    path = tmp_path / "report.html"
    path.write_text(html_page(reproduction, [], [FILM], "../.."), encoding="utf-8")
    context = browser.new_context(viewport={"width": width, "height": 844}, color_scheme=scheme)
    page = context.new_page()
    page.goto(path.as_uri())
    assert barriers(page) == []
    context.close()


def test_on_paper_the_ledger_keeps_all_its_columns(browser, reproduction, tmp_path):
    path = tmp_path / "report.html"
    path.write_text(html_page(reproduction, [], [FILM], "../.."), encoding="utf-8")
    context = browser.new_context(viewport={"width": 710, "height": 1000}, color_scheme="dark")
    page = context.new_page()
    page.goto(path.as_uri())
    page.emulate_media(media="print", color_scheme="dark")
    last = page.locator(".ledger thead th").last.bounding_box()
    assert last["width"] > 20
    assert last["x"] + last["width"] <= 710
    assert not page.locator(".play").first.is_visible()
    context.close()
