import html
import json
import re
from itertools import islice

import pandas as pd
import pytest

from harness.errors import RequestError
from harness.report import folder as report_folder
from harness.report.folder import write
from harness.report.gallery import pictures
from harness.report.target import check_folder


@pytest.fixture(scope="module")
def target(verification, tmp_path_factory):
    folder = tmp_path_factory.mktemp("reports") / "run"
    write(verification, folder)
    return folder


def test_the_folder_is_complete(verification, target):
    record = json.loads((target / "results.json").read_text())
    assert record["status"] == verification.status
    assert len(record["checks"]) == len(verification.checks)
    assert len(pd.read_csv(target / "results.csv")) == len(verification.checks)
    for name in verification.scripts:
        assert (target / "scripts" / name).read_text() == verification.scripts[name]
    figures = {path.stem for path in (target / "figures").glob("*.svg")}
    assert "critical-angle-extrapolation" in figures
    assert figures == {path.stem for path in (target / "figures").glob("*.png")}
    linked = re.findall(r"\(figures/(.+?)\.svg\)", (target / "report.md").read_text())
    assert set(linked) == figures


def test_the_page_is_self_contained(verification, target):
    page = (target / "report.html").read_text()
    assert "http" not in re.sub(r'src="data:image/svg\+xml,[^"]+"', "", page)
    assert not re.search(r'src="(?!data:)', page)
    for check in verification.checks:
        assert html.escape(check.name) in page


def test_every_link_of_the_page_leads_to_a_file_or_a_place_in_it(target):
    page = (target / "report.html").read_text()
    links = set(re.findall(r'href="(?!data:)([^"]+)"', page))
    assert {"figures", "scripts", "logs"} <= {link.partition("/")[0] for link in links}
    for link in links:
        if link.startswith("#"):
            assert f'id="{link[1:]}"' in page
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
    assert (target / "logs" / "incline-plastic.in.log").is_file()


def test_figures_are_the_same_file_twice(verification, target):
    for picture in islice(pictures(verification), 5):
        assert picture.svg == (target / "figures" / f"{picture.name}.svg").read_text()
        assert picture.png == (target / "figures" / f"{picture.name}.png").read_bytes()


def test_a_folder_that_holds_something_is_refused_and_kept(verification, tmp_path):
    (tmp_path / "kept.txt").write_text("mine")
    with pytest.raises(RequestError, match="holds something already"):
        write(verification, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["kept.txt"]


def test_a_file_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RequestError, match="is a file"):
        check_folder(tmp_path / "file")


def test_a_folder_that_cannot_be_made_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RequestError, match="cannot be written"):
        check_folder(tmp_path / "file" / "below")


@pytest.mark.parametrize("stop", [KeyboardInterrupt, OSError])
def test_nothing_half_written_is_left(verification, tmp_path, monkeypatch, stop):
    def interrupted(*_):
        raise stop

    monkeypatch.setattr(report_folder, "pictures", lambda _: [])
    monkeypatch.setattr(report_folder, "html_page", interrupted)
    with pytest.raises(stop):
        write(verification, tmp_path / "run")
    assert list(tmp_path.iterdir()) == []
