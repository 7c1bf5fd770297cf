"""An engine and a case of one's own, as two packages outside this one.

Both are installed into a fresh environment, found there by their entry points, and touch no
file of this project.
"""

import json
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
PROJECT = HERE.parents[1]
PACKAGES = ("small_dem", "ball_on_sphere")

pytestmark = [pytest.mark.slow, pytest.mark.live]


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """Return the bin folder of an environment that has the project and both packages."""
    folder = tmp_path_factory.mktemp("environment")
    subprocess.run([sys.executable, "-m", "venv", folder], check=True)
    pip = [folder / "bin" / "pip", "install", "-q", "--disable-pip-version-check"]
    subprocess.run([*pip, PROJECT, *(HERE / name for name in PACKAGES)], check=True)
    return folder / "bin"


@pytest.fixture
def harness(installed, tmp_path, monkeypatch):
    """Return a function that runs ``dem-harness`` in that environment: status and JSON object."""
    monkeypatch.delenv("PYTHONPATH", raising=False)
    monkeypatch.setenv("DEM_HARNESS_HOME", str(tmp_path / "home"))

    def run(*words):
        words = [installed / "dem-harness", *words, "--json"]
        done = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path, check=False)
        assert done.returncode in (0, 1, 2, 3), done.stderr
        return done.returncode, json.loads(done.stdout)

    return run


def test_the_engine_is_listed_and_the_case_too(harness):
    _, engines = harness("engines")
    assert ("small-dem", True) in {(e["engine"], e["available"]) for e in engines["engines"]}
    _, cases = harness("cases")
    (mine,) = [case for case in cases["cases"] if case["name"] == "ball-on-sphere"]
    assert {"lammps", "small-dem", "reference"} <= set(mine["engines"])
    assert mine["quantities"] == {"rebound": "1", "contact_time_s": "s"}


def test_the_suite_of_engines_takes_it_by_its_name(installed, tmp_path):
    code = "from harness.testing import check_engine; print(check_engine('small-dem'))"
    words = [installed / "python", "-c", code]
    assert subprocess.check_output(words, text=True, cwd=tmp_path) == "{}\n"  # nothing is skipped


def test_the_engine_is_verified_and_appears_in_the_report(harness, tmp_path):
    status, found = harness(
        "verify", "--quick", "--engines", "small-dem", "--cases", "incline,tower,ball-on-sphere",
        "--output", "report",
    )  # fmt: skip
    rows = [row for row in found["rows"] if row["engine"] == "small-dem"]
    assert status == 0, [row for row in rows if row["verdict"] == "fail"]
    for case in ("incline", "tower", "ball-on-sphere"):
        assert "pass" in {row["verdict"] for row in rows if row["case"] == case}
    page = (tmp_path / "report" / "report.html").read_text(encoding="utf-8")
    assert "small-dem" in page
    assert "ball-on-sphere" in page
