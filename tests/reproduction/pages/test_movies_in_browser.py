"""Movies of the page in a browser: still until started, and for those who want no motion."""

import shutil

import pytest

from harness.reproduction.movies import Film
from harness.reproduction.pages.page import html_page

FILM = Film("two-particles", "Two particles", "They exchange.", b"", b"", b"")


@pytest.fixture(scope="module")
def browser():
    sync_api = pytest.importorskip("playwright.sync_api")
    names = ("chromium", "chromium-browser", "google-chrome")
    path = next(filter(None, map(shutil.which, names)), None)
    if path is None:
        pytest.skip(f"no browser on PATH ({', '.join(names)}); Debian's package is chromium")
    with sync_api.sync_playwright() as started:
        chromium = started.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield chromium
        chromium.close()


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
