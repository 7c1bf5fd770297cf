import json

import pytest

from harness import workflows
from tests.workflows.test_static_site import run_folder


@pytest.fixture
def small(tmp_path, monkeypatch):
    """Let the site be that of no committed reports, but of runs alone."""
    (tmp_path / "project").mkdir()
    build = workflows.site
    monkeypatch.setattr(
        workflows,
        "site",
        lambda *asked, **more: build(*asked, **more, project=tmp_path / "project"),
    )


@pytest.mark.usefixtures("small")
def test_the_site_is_built_and_named_in_json(command, tmp_path):
    run = run_folder(tmp_path / "run", 10.2, 1)
    found = json.loads(command("site", str(run), "--output", "public", "--json").out)
    assert (tmp_path / found["start"]).is_file()
    assert {"page", "bytes"} == {*found["pages"][0]}
    assert "runs/run/report.html" in {page["page"] for page in found["pages"]}
    assert "unlinked" in found


def test_bad_input_is_status_2_and_leaves_nothing(harness, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("")
    said = harness("site", "--output", "mine", status=2).stderr
    assert "--output mine: holds thesis.tex, which no site wrote" in said
    said = harness("site", "absent", "--output", "public", status=2).stderr
    assert "RUN absent: is not a run of verify" in said
    assert not (tmp_path / "public").exists()
