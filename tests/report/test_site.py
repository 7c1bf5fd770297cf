"""The site: every link leads to a file of it, no address is another host's, the board is whole."""

from dataclasses import replace
from urllib.parse import unquote, urlsplit

import pytest

from harness.errors import RequestError
from harness.report.site import LIST, site
from harness.results.rows import Kind, Row, Verdict, table
from harness.store.runs import Meta, Run, rows_text, write_run
from tests.report.conftest import Page

ROW = Row(case="drop", setup="wall", quantity="speed", engine="lammps", value=1.0, expected=1.0,
          tolerance=1e-9, kind=Kind.ANALYTIC, verdict=Verdict.PASS)  # fmt: skip
ACCEPTED = {
    "lammps/22 Jul 2025": [ROW, replace(ROW, setup="pair")],
    "lammps/2 Aug 2023": [replace(ROW, verdict=Verdict.NOT_TESTED)],
    "toy/5": [replace(ROW, engine="toy", verdict=Verdict.KNOWN_DEFECT, defect="no-friction")],
}
FILES = {
    "README.md": "# The harness\n\nSee [reports](reports), [the case](docs/case.md#part-2), "
    "[a host](https://example.org), [gone](none.md) and [a folder](inputs).\n"
    "![a badge](https://example.org/badge.svg) ![a plot](docs/plot.svg)\n",
    "docs/case.md": "# A case\n\n## Part 2\n\n| case | verdict |\n|---|---|\n"
    "| <b>drop</b> | known defect |\n\n"
    "[back](../README.md), [data](data.csv), [up](../../outside.md)\n",
    "docs/data.csv": "a\n",
    "docs/plot.svg": "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 1 1'/>",
    "inputs/known-defects.toml": '[defect.no-friction]\nengine = "toy"\nsince = "2 Aug 2023"\n'
    'cause = "walls have no friction"\nupstream = "not reported"\n'
    'script = "reports/defects/no-friction/in.toy"\n',
    "reports/README.md": "# Reports\n\n[example](example/report.md)\n",
    "reports/example/report.md": "# Not rendered\n\n![a figure](figures/angle.svg)\n",
    "reports/example/report.html": "<!doctype html><title>made by verify</title>"
    "<a href='figures/angle.svg'>angle</a>",
    "reports/example/figures/angle.svg": "<svg xmlns='http://www.w3.org/2000/svg'/>",
    "reports/defects/no-friction/in.toy": "run <0>\n",
    "reports/runs/mine/report.md": "# Of this machine\n",
}


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    root = tmp_path_factory.mktemp("project")
    files = dict(FILES)
    for name, rows in ACCEPTED.items():
        accepted = table([replace(row, version=name.split("/")[1]) for row in rows])
        files[f"reports/accepted/{name}/rows.csv"] = rows_text(accepted)
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return root


@pytest.fixture(scope="module")
def built(project, tmp_path_factory):
    return site(tmp_path_factory.mktemp("site") / "below" / "an-address", project=project)


def test_every_link_of_every_page_leads_to_a_file_and_an_id_of_the_site(built):
    for address in built.pages:
        page = built.folder / address
        for parts in map(urlsplit, Page(page.read_text()).values("href", "src")):
            target = page.parent / unquote(parts.path or page.name)
            assert parts.scheme or target.resolve().is_relative_to(built.folder.resolve())
            assert parts.scheme or target.is_file(), f"{address}: {parts}"
            assert not parts.fragment or parts.fragment in Page(target.read_text()).values("id")
    assert built.unlinked == [("README.md", "none.md"), ("docs/case.md", "../../outside.md")]
    example = built.folder / "reports/example"
    assert "made by verify" in (example / "report.html").read_text()
    assert (example / "figures/angle.svg").is_file()
    assert not (built.folder / "reports/runs").exists()


def test_the_board_counts_the_verdicts_and_known_defects_have_cause_releases_and_script(built):
    codes, releases = built.start.read_text().split("<h2>")[1:3]
    assert "2 pass" in codes
    assert "not tested" not in codes  # of the older release
    assert "1 known defect" in codes
    assert releases.index("2 Aug 2023") < releases.index("22 Jul 2025")
    assert "1 not tested" in releases
    page = (built.folder / "defects.html").read_text()
    assert "Walls have no friction. Releases from 2 Aug 2023." in page
    assert "run &lt;0&gt;" in page


def test_runs_join_the_site_and_a_site_is_replaced(project, tmp_path):
    meta = Meta(level="quick", cases=("drop",), engines={"lammps": "1"}, started="2030-01-01T00:00")
    run = Run(table([replace(ROW, verdict=Verdict.FAIL)]), meta)
    write_run(run, tmp_path / "monday", {"report.html": "<p>monday</p>"})
    site(tmp_path / "site", project=project)
    (tmp_path / "site" / "old.html").touch()
    built = site(tmp_path / "site", [tmp_path / "monday"], project=project)
    assert not (built.folder / "old.html").exists()
    assert (built.folder / LIST).is_file()
    assert (built.folder / "runs/monday/report.html").read_text() == "<p>monday</p>"
    assert "Failed: 1 analytic" in built.start.read_text()


def test_other_files_a_folder_that_is_no_run_and_nothing_to_show_are_refused(project, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("mine")
    with pytest.raises(RequestError, match="has other files"):
        site(tmp_path / "mine", project=project)
    with pytest.raises(RequestError, match=r"run\.json"):
        site(tmp_path / "site", [project], project=project)
    with pytest.raises(RequestError, match="lies in the run"):
        site(project / "reports" / "site", [project], project=project)
    with pytest.raises(RequestError, match="no committed reports"):
        site(tmp_path / "site", project=tmp_path)
    assert not (tmp_path / "site").exists()


@pytest.mark.parametrize("width", [390, 1400])
def test_pages_fit_their_screen_and_axe_finds_nothing(browser, barriers, built, width):
    page = browser.new_page(viewport={"width": width, "height": 844})
    for address in ("index.html", "defects.html", "docs/case.html"):
        page.goto((built.folder / address).as_uri())
        assert page.evaluate("document.documentElement.scrollWidth") == width
        assert barriers(page) == []
    page.close()
