"""Markdown as pages, and links that lead to pages of the site."""

import pytest

from harness.report.markdown import document, tables
from harness.report.render import Site

TEXT = """# A title

See [the other](sub/other.md#part-2), [data](data.csv), [home](https://example.org), [gone](no.md).

## Part, *one*

| case | verdict | value |
|---|---|--:|
| a | known defect | 1 |

## Part 2

| case | far |
|---|---|
| b | <b> |
"""


@pytest.fixture
def site(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "README.md").write_text(TEXT)
    (tmp_path / "data.csv").write_text("a\n")
    (tmp_path / "sub" / "other.md").write_text("# Other\n\n## Part 2\n\n[back](../README.md)\n")
    page = '<html><head></head><body class="x"><a href="../sub/">up</a></body></html>'
    (tmp_path / "sub" / "page.html").write_text(page)
    (tmp_path / "sub" / "page.md").write_text("[never rendered](../README.md)")
    (tmp_path / "sub" / "README.md").write_text("# Sub\n\n[page](page.md)\n")
    built = Site(tmp_path, (("Start", "index.html"), ("Sub", "sub/index.html")))
    built.add_file("README.md")
    return built


def test_markdown_becomes_a_page_with_places_badges_and_named_cells():
    shown = document(TEXT)
    assert shown.title == "A title"
    assert shown.headings == (("part-one", "Part, one"), ("part-2", "Part 2"))
    assert "<h1" not in shown.body
    assert '<span class="badge known-defect">known defect</span>' in shown.body
    assert '<td data-n="value" class="n">1</td>' in shown.body
    assert "&lt;b&gt;" in shown.body


def test_tables_are_read_by_their_headings():
    assert tables(TEXT) == {
        "Part, one": [{"case": "a", "verdict": "known defect", "value": "1"}],
        "Part 2": [{"case": "b", "far": "<b>"}],
    }


def test_links_lead_to_pages_and_what_is_linked_comes_along(site):
    page = site.pages["index.html"]
    assert 'href="sub/other.html#part-2"' in page
    assert 'href="data.csv"' in page
    assert 'href="https://example.org"' in page
    assert sorted(site.pages) == ["index.html", "sub/other.html"]
    assert sorted(site.files) == ["data.csv"]
    assert 'href="../index.html"' in site.pages["sub/other.html"]


def test_a_link_to_nothing_is_left_as_its_words_and_named(site):
    assert site.unlinked == [("index.html", "no.md")]
    assert "gone" in site.pages["index.html"]
    assert "no.md" not in site.pages["index.html"]


def test_a_finished_page_stands_for_its_markdown_under_the_same_navigation(site):
    site.add_file("sub")
    page = site.pages["sub/page.html"]
    assert "never rendered" not in page
    assert '<body class="x">\n<header class="site"><nav aria-label="Site">' in page
    assert '<a href="../sub/index.html">Sub</a>' in page
    assert 'href="../style.css"' in page
    assert '<a href="index.html">up</a>' in page  # a folder has a page that a disk shows


def test_a_link_out_of_the_root_is_not_followed(tmp_path):
    (tmp_path / "secret.txt").write_text("secret")
    (tmp_path / "root").mkdir()
    (tmp_path / "root" / "README.md").write_text("# R\n\n[s](../secret.txt)\n")
    built = Site(tmp_path / "root", ())
    built.add_file("README.md")
    assert built.files == {}
    assert built.unlinked == [("index.html", "../secret.txt")]
