"""The site of the committed reports: whole, linked, offline, readable; and of runs."""

import json
import posixpath
import re
from dataclasses import replace
from html.parser import HTMLParser
from urllib.parse import unquote

import pytest

from harness.comparison.verdicts import Kind, Tolerance, judge
from harness.errors import RequestError
from harness.store.baseline import known_defects
from harness.workflows import site
from tests.published_run import RUN


class Links(HTMLParser):
    """What a page links to and loads, and the places in it."""

    def __init__(self, text):
        super().__init__()
        self.links, self.loaded, self.places, self.navigations = [], [], set(), []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.places |= {values.get("id")}
        if tag == "a":
            self.links.append(values.get("href") or "")
        elif tag == "nav":
            self.navigations.append(values.get("aria-label"))
        self.loaded += [values["src"]] if "src" in values else []
        if tag == "link":
            self.loaded.append(values["href"])


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    return site(tmp_path_factory.mktemp("site") / "below" / "an-address")


@pytest.fixture(scope="module")
def links(built):
    return {page: Links((built.folder / page).read_text("utf-8")) for page in built.pages}


@pytest.mark.slow
def test_every_link_leads_to_a_file_of_the_site_and_every_place_is_there(built, links):
    for page, found in links.items():
        for link in [*found.links, *found.loaded]:
            if re.match(r"[a-z]+:", link):
                continue
            target, _, place = link.partition("#")
            path = posixpath.normpath(posixpath.join(posixpath.dirname(page), unquote(target)))
            path = path if target else page
            assert not path.startswith(".."), f"{page}: {link} leads out of the site"
            assert (built.folder / path).is_file(), f"{page}: {link} leads nowhere"
            if place:
                assert place in links[path].places, f"{page}: {link}: no such place"


@pytest.mark.slow
def test_every_page_has_the_navigation_and_loads_nothing_from_a_network(built, links):
    style = (built.folder / "style.css").read_text()
    assert "url(" not in style
    assert "@import" not in style
    for page, found in links.items():
        assert found.navigations[0] == "Site", page
        for one in found.loaded:
            assert not re.match(r"[a-z]+:|//", one) or one.startswith("data:"), f"{page}: {one}"


@pytest.mark.slow
def test_every_known_defect_has_a_page_and_its_script(built):
    for defect in known_defects():
        folder = built.folder / posixpath.dirname(defect.script)
        assert f'<h2 id="{defect.name}">' in (folder / "index.html").read_text()
        assert (built.folder / defect.script).is_file()


def run_folder(folder, value, day):
    """Return a run as verify leaves it, of one check with a value."""
    width = Tolerance("deg", 0.1, 0.0, "why")
    check = replace(judge("angle", Kind.ANALYTIC, value, 10.2, width), note="")
    record = RUN | {"checks": [check.to_json()], "started": f"2030-01-0{day}T00:00:00+00:00"}
    folder.mkdir()
    (folder / "results.json").write_text(json.dumps(record))
    (folder / "report.html").write_text("<html><head></head><body><p>run</p></body></html>")
    (folder / "scripts").mkdir()
    (folder / "scripts" / "a.in").write_text("units si\n")
    return folder


@pytest.fixture
def nothing_committed(tmp_path):
    """A project without reports."""
    (tmp_path / "project").mkdir()
    return tmp_path / "project"


def test_runs_join_the_site_and_the_step_at_which_a_value_moved_is_named(
    nothing_committed, tmp_path
):
    runs = [run_folder(tmp_path / f"run{n}", v, n) for n, v in enumerate((10.2, 10.2, 10.5), 1)]
    built = site(tmp_path / "site", runs, project=nothing_committed)
    assert "Site" in (built.folder / "runs" / "run1" / "report.html").read_text()
    assert (built.folder / "runs" / "run1" / "scripts" / "a.in").is_file()
    assert "run3: Failed: 1 analytic" in (built.folder / "index.html").read_text()
    moved = (built.folder / "moved" / "index.html").read_text()
    assert "run2, 2030-01-02 00:00 → run3, 2030-01-03 00:00: 1 moved" in moved
    assert "run1, 2030-01-01 00:00 → run2" not in moved
    assert (built.folder / "moved" / "moved-1.svg").is_file()
    found = {page: Links((built.folder / page).read_text()) for page in built.pages}
    assert "runs/run1/report.html" in found["index.html"].links


def test_runs_of_one_name_stand_beside_one_another(nothing_committed, tmp_path):
    (tmp_path / "other").mkdir()
    runs = [run_folder(tmp_path / "run", 10.2, 1), run_folder(tmp_path / "other" / "run", 10.2, 2)]
    built = site(tmp_path / "site", runs, project=nothing_committed)
    assert {"runs/run/report.html", "runs/run-2/report.html"} <= {*built.pages}


def test_a_site_is_replaced_and_nothing_else_is(nothing_committed, tmp_path):
    runs = [run_folder(tmp_path / "run", 10.2, 1)]
    built = site(tmp_path / "site", runs, project=nothing_committed)
    (built.folder / "index.html").write_text("old")
    site(tmp_path / "site", runs, project=nothing_committed)
    assert (built.folder / "index.html").read_text() != "old"
    (built.folder / "CNAME").write_text("mine")
    with pytest.raises(RequestError, match="CNAME, which no site wrote"):
        site(tmp_path / "site", runs, project=nothing_committed)
    assert (built.folder / "CNAME").read_text() == "mine"


@pytest.mark.parametrize("held", ["{", '{"files": 3}', "[]"])
def test_a_list_that_is_damaged_protects_what_is_there(nothing_committed, tmp_path, held):
    (tmp_path / "site").mkdir()
    (tmp_path / "site" / "site.json").write_text(held)
    with pytest.raises(RequestError, match="which no site wrote"):
        site(tmp_path / "site", [run_folder(tmp_path / "run", 10.2, 1)], project=nothing_committed)


def test_what_cannot_be_shown_is_refused_before_anything_is_written(nothing_committed, tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "file").write_text("")
    run = run_folder(tmp_path / "run", 10.2, 1)
    (run / "results.json").write_text("{")
    for output, runs, said in (
        (tmp_path / "site", [], "no reports are committed here"),
        (tmp_path / "site", [tmp_path / "empty"], "empty: is not a run"),
        (tmp_path / "site", [tmp_path / "absent"], "absent: is not a run"),
        (tmp_path / "site", [run], "is damaged, no JSON"),
        (tmp_path / "file", [run], "is a file"),
    ):
        with pytest.raises(RequestError, match=said):
            site(output, runs, project=nothing_committed)
    assert not (tmp_path / "site").exists()
