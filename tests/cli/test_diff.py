import json
import shutil

import pytest

from harness.comparison.verdicts import Kind, Tolerance, judge
from harness.report.folder import write_diff
from harness.workflows import diff
from tests.published_run import RUN

FIGURE = '<svg viewBox="0 0 72 36" xmlns="http://www.w3.org/2000/svg"><path d="M 0 0"/></svg>'


def check(value):
    return judge("angle", Kind.ANALYTIC, value, 10.2, Tolerance("deg", 0.1, 0.0, "why")).to_json()


@pytest.fixture
def runs(tmp_path):
    """Two runs as verify leaves them: the second is off, its script and one figure are changed."""
    record = RUN | {"checks": [check(10.2)]}
    for name in ("one", "two"):
        folder = tmp_path / name
        for below in ("figures", "scripts"):
            (folder / below).mkdir(parents=True)
        (folder / "results.json").write_text(json.dumps(record))
        (folder / "scripts" / "tower.in").write_text(f"units si\ntimestep {name}\n")
        (folder / "figures" / "same.svg").write_text(FIGURE)
        (folder / "figures" / "other.svg").write_text(
            FIGURE.replace("M 0 0", f"M {ord(name[0])} 1")
        )
        record["checks"] = [check(10.5)]
    (tmp_path / "two" / "figures" / "new.svg").write_text(FIGURE)
    return tmp_path / "one", tmp_path / "two"


def test_exit_status_and_json(runs, harness, answer):
    one, two = map(str, runs)
    found = answer("diff", one, two, status=1)
    assert found["counts"]["worse"] == 1
    assert found["rows"][0]["moved_in_tolerances"] == pytest.approx(3.0)
    assert answer("diff", two, one)["counts"]["better"] == 1
    assert "pass -> fail" in harness("diff", one, two, status=1).stdout
    assert "Nothing" not in harness("diff", one, one).stderr


def test_what_is_no_run_is_status_2_and_leaves_nothing(runs, harness, tmp_path):
    (runs[1] / "results.json").write_text("{")
    said = harness("diff", str(runs[0]), str(runs[1]), "--output", "page", status=2).stderr
    assert str(runs[1] / "results.json") in said
    assert not (tmp_path / "page").exists()
    assert "holds something" in harness("diff", *map(str, runs), "--output", ".", status=2).stderr


def test_the_page_has_both_runs_figures_in_pairs_and_the_scripts_difference(runs, tmp_path):
    write_diff(diff(*runs), *runs, tmp_path / "page")
    page = (tmp_path / "page" / "diff.html").read_text()
    assert "Worse: 1 analytic" in page
    assert "-timestep one" in page
    assert "+timestep two" in page
    assert page.count('src="data:image/svg+xml,') == 1 + 2 + 1  # same, other, new
    assert page.count("the same in both") == 1
    assert page.count("not there") == 1
    assert json.loads((tmp_path / "page" / "diff.json").read_text())["status"] == 1
    assert len((tmp_path / "page" / "diff.csv").read_text().splitlines()) == 2


def test_a_page_below_folders_that_are_not_there_makes_them(runs, harness, tmp_path):
    harness("diff", *map(str, runs), "--output", "reports/runs/diff", status=1)
    assert (tmp_path / "reports" / "runs" / "diff" / "diff.html").is_file()


def test_runs_without_figures_have_a_page(runs, tmp_path):
    for run in runs:
        shutil.rmtree(run / "figures")
        shutil.rmtree(run / "scripts")
    write_diff(diff(*runs), *runs, tmp_path / "page")
    assert "Figures</h2>" not in (tmp_path / "page" / "diff.html").read_text()
