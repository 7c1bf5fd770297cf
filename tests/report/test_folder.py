import html
import json
import re
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

from harness.errors import RequestError
from harness.files import check_folder, check_writable
from harness.report import folder as report_folder
from harness.report.folder import write
from harness.report.gallery import draw_sections
from harness.report.sections import Drawing, Section
from tests.report.conftest import DIVERGED, draw

FIGURES = {"one", "two", "broad", "odd", "four-rows", "extra"}


@pytest.fixture(scope="module")
def target(verification, sections, tmp_path_factory):
    folder = tmp_path_factory.mktemp("reports") / "run"
    write(verification, folder, sections)
    return folder


def test_the_folder_is_complete(verification, target):
    record = json.loads((target / "results.json").read_text())
    assert record["status"] == verification.status
    assert len(record["checks"]) == len(verification.checks)
    assert len(pd.read_csv(target / "results.csv")) == len(verification.checks)
    for name in verification.scripts:
        assert (target / "scripts" / name).read_text() == verification.scripts[name]
    assert {path.name for path in (target / "figures").iterdir()} == {f"{n}.svg" for n in FIGURES}
    linked = re.findall(r"\(figures/(.+?)\.svg\)", (target / "report.md").read_text())
    assert set(linked) == FIGURES


def test_the_page_is_self_contained(verification, target):
    page = (target / "report.html").read_text()
    assert "http" not in re.sub(r'src="data:image/svg\+xml,[^"]+"', "", page)
    assert not re.search(r'src="(?!data:)', page)
    for check in verification.checks:
        assert html.escape(check.name) in page


def links_of(folder):
    page = (folder / "report.html").read_text()
    return page, set(re.findall(r'href="(?!data:)([^"]+)"', page))


def test_every_link_of_the_page_leads_to_a_file_or_a_place_in_it(target):
    page, links = links_of(target)
    assert {"figures", "scripts", "logs"} <= {link.partition("/")[0] for link in links}
    for link in links:
        if link.startswith("#"):
            assert page.count(f'id="{link[1:]}"') == 1
        else:
            assert (target / link).is_file()


def test_the_log_of_a_failed_run_is_found_from_its_row(verification, target):
    (died,) = (check for check in verification.checks if check.engine_died)
    assert (target / "logs" / died.log_name).read_text() == died.log
    rows = json.loads((target / "results.json").read_text())["checks"]
    assert [row["log"] for row in rows if row["engine_died"]] == [died.log_name]
    page = (target / "report.html").read_text()
    assert f'href="logs/{died.log_name}"' in page
    assert html.escape("Step 1 <&> 2") in page
    assert (target / "logs" / "slope.in.log").is_file()


def test_figures_are_the_same_file_twice(sections, target):
    drawn = draw_sections(sections)
    assert len(drawn[0].pictures) == 5
    for picture in drawn[0].pictures:
        assert picture.svg == (target / "figures" / f"{picture.name}.svg").read_text()
        assert not (target / "figures" / f"{picture.name}.png").exists()


def test_figures_are_written_as_png_where_that_is_asked_for(verification, sections, tmp_path):
    write(verification, tmp_path / "run", sections[:1], png=True)
    figures = tmp_path / "run" / "figures"
    names = {path.stem for path in figures.glob("*.svg")}
    assert names == {path.stem for path in figures.glob("*.png")} != set()
    assert all(path.read_bytes()[:4] == b"\x89PNG" for path in figures.glob("*.png"))


def test_figures_of_one_name_are_told_apart_and_a_broken_one_is_named():
    section = Section(
        "Two",
        drawings=(
            Drawing("../same", "A", "a", draw()),
            Drawing("same", "B", "b", draw()),
            Drawing("broken", "Broken", "c", lambda: 1 / 0),
        ),
    )
    (drawn,) = draw_sections([section])
    assert [picture.name for picture in drawn.pictures] == ["same", "same-2"]
    assert drawn.failures == (
        "Figure 'Broken' could not be drawn: ZeroDivisionError: division by zero",
    )


def test_series_that_diverged_and_other_engines_have_their_sections(
    verification, declared, tmp_path
):
    found = replace(verification, divergences=(DIVERGED,), engines=declared)
    write(found, tmp_path / "run")
    page, text = ((tmp_path / "run" / n).read_text() for n in ("report.html", "report.md"))
    assert (tmp_path / "run" / "figures" / "divergence-1.svg").is_file()
    for title in ("Where series diverge", "Engines beside one another"):
        assert f">{title}</h2>" in page
        assert f"## {title}" in text
    for said in ("missing: no three here", "did not qualify: free fall"):
        assert said in page
        assert said in text
    assert "It &lt;always&gt; clips. It counts m/2." in page


def test_hostile_names_stay_text_and_files_stay_below_the_folder(hostile, tmp_path):
    write(hostile, tmp_path / "run", [Section("<script>x</script>", ("<script>y</script>",))])
    assert [path.name for path in tmp_path.iterdir()] == ["run"]
    assert (tmp_path / "run" / "scripts" / "up" / "s-.in").is_file()
    page, links = links_of(tmp_path / "run")
    own = page.count("<script>")
    assert own == 1  # the page's own
    for link in links:
        assert link.startswith("#") or (tmp_path / "run" / link).is_file()
    text = (tmp_path / "run" / "report.md").read_text()
    assert "alert(1)" in text
    for dangerous in ("<script", "![x]", "\x1b", "\x07", "@you", " `a`"):
        assert dangerous not in text, dangerous


def test_a_folder_that_holds_something_is_refused_and_kept(verification, tmp_path):
    (tmp_path / "kept.txt").write_text("mine")
    with pytest.raises(RequestError, match="holds something already"):
        write(verification, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["kept.txt"]


def test_a_folder_that_cannot_be_made_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RequestError, match="cannot be written"):
        check_folder(tmp_path / "file" / "below")


def test_the_root_of_all_folders_is_refused():
    with pytest.raises(RequestError, match=r"^--output /: is the root"):
        check_writable(Path("/"))


@pytest.mark.parametrize("stop", [KeyboardInterrupt, OSError])
def test_nothing_half_written_is_left(verification, tmp_path, monkeypatch, stop):
    def interrupted(*_):
        raise stop

    monkeypatch.setattr(report_folder, "report_page", interrupted)
    with pytest.raises(stop):
        write(verification, tmp_path / "run")
    assert list(tmp_path.iterdir()) == []
