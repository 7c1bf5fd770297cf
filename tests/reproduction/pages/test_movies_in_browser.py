"""Movies in a browser: still until started, paused on a frame; nothing that axe objects to."""

import numpy as np
import pytest

from harness.report.film import base64_uri, gif, png
from harness.reproduction.movies import Movie
from harness.reproduction.page import html_page

FILM = Movie("two-particles", "Two particles", "They exchange.", b"", b"", b"")


BAR = """c => c.getContext("2d").getImageData(0, 20, 60, 1).data
  .findIndex((value, at) => at % 4 == 0 && !value) / 4"""
"""The column of the first black pixel."""


def barred(frame):
    """Return a white picture with a black bar, a column further in each frame."""
    picture = np.full((40, 60, 3), 255, dtype=np.uint8)
    picture[:, frame] = 0
    return picture


@pytest.fixture
def opened(browser, reproduction, tmp_path):
    """Return a page with a film of 40 frames beside it."""
    film = gif(barred, 40)
    (tmp_path / "movies").mkdir()
    (tmp_path / "movies" / "two-particles.png").write_bytes(png(barred(0)))
    (tmp_path / "movies" / "two-particles.gif.js").write_text(
        f'filmData("{base64_uri(film, "image/gif")}");'
    )
    path = tmp_path / "report.html"
    path.write_text(html_page(reproduction, [], [FILM], "../.."), encoding="utf-8")
    page = browser.new_page()
    page.goto(path.as_uri())
    yield page
    page.close()


def test_a_movie_plays_pauses_on_a_frame_goes_on_and_stops(opened):
    image, play = opened.locator(".movies img"), opened.locator(".play")
    stop, canvas = opened.locator(".stop"), opened.locator(".movies canvas")
    assert image.get_attribute("src") == "movies/two-particles.png"
    assert play.get_attribute("aria-label") == "Play: Two particles"
    assert not stop.is_visible()
    play.click()
    opened.wait_for_function("document.querySelector('canvas')?.dataset.frame > 2")
    assert (image.is_visible(), play.inner_text(), stop.is_visible()) == (False, "Pause", True)
    play.click()
    frame = int(canvas.get_attribute("data-frame"))
    assert canvas.evaluate(BAR) == frame
    opened.wait_for_timeout(300)
    assert canvas.evaluate(BAR) == frame
    assert play.get_attribute("aria-label") == "Play: Two particles"
    play.click()
    opened.wait_for_function(f"document.querySelector('canvas').dataset.frame > {frame}")
    stop.click()
    assert (image.is_visible(), canvas.count(), stop.is_visible()) == (True, 0, False)
    play.click()
    opened.wait_for_selector(".movies canvas[data-frame]")


def test_who_wants_no_motion_gets_the_still_again(opened):
    opened.locator(".play").click()
    opened.wait_for_selector(".movies canvas[data-frame]")
    opened.emulate_media(reduced_motion="reduce")
    opened.wait_for_selector(".movies canvas", state="detached")
    assert opened.locator(".movies img").is_visible()
    assert opened.locator(".play").inner_text() == "Play"


def test_where_frames_cannot_be_decoded_the_gif_is_shown(opened):
    opened.evaluate("delete window.ImageDecoder")
    opened.locator(".play").click()
    opened.wait_for_selector('.movies img[src="movies/two-particles.gif"]', state="attached")
    assert not opened.locator(".play").is_visible()
    opened.locator(".stop").click()
    opened.wait_for_selector('.movies img[src$="movies/two-particles.png"]', state="attached")
    assert opened.locator(".play").is_visible()


@pytest.mark.parametrize(
    ("width", "scheme"),
    [
        (1300, "dark"),
        (390, "light"),
        # each width and each scheme is above once
        pytest.param(1300, "light", marks=pytest.mark.slow),
        pytest.param(390, "dark", marks=pytest.mark.slow),
    ],
)
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
