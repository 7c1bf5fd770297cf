"""A verification is handed out again, or goes on with what was kept of it."""

import json
import os
import shutil
import subprocess
import sys
from types import SimpleNamespace

import pytest

import harness.workflows
from harness.cli import verify
from harness.cli.engine_options import CacheOptions, EngineOptions
from harness.errors import RequestError
from harness.report import folder as report_folder
from harness.store.entries import Entries
from harness.workflows.progress import silent


class Kept:
    """A verification that was run once, and the commands after it."""

    def __init__(self, folder, home):
        self.folder, self.home = folder, home

    def run(self, *arguments):
        return subprocess.run(
            [sys.executable, "-m", "harness", *arguments],
            cwd=self.folder,
            env={**os.environ, "DEM_HARNESS_HOME": str(self.home)},
            capture_output=True,
            text=True,
            timeout=600,
            check=True,
        )

    def entries(self):
        """Return the files of the cache, smallest first, that of the verification last."""
        return sorted(
            (self.home / "cache").glob("??/*"),
            key=lambda path: (b"record.json" in path.read_bytes(), path.stat().st_size),
        )


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    found = Kept(tmp_path_factory.mktemp("kept"), tmp_path_factory.mktemp("home"))
    found.first = json.loads(found.run("verify", "--quick", "--json", "--output", "first").stdout)
    return found


@pytest.fixture
def copy(kept, tmp_path):
    """The same cache at another place, for tests that damage it."""
    shutil.copytree(kept.home, tmp_path / "home")
    (tmp_path / "folder").mkdir()
    return Kept(tmp_path / "folder", tmp_path / "home")


def _files(folder):
    return {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.mark.slow
@pytest.mark.live
def test_what_was_verified_is_handed_out_again_and_said_to_be_so(kept):
    again = json.loads(kept.run("verify", "--quick", "--json", "--output", "again").stdout)
    assert (kept.first["cached"], again["cached"]) == (False, True)
    assert again["engine_runs"] == 0
    assert {**again, "folder": ""} == {
        **kept.first, "folder": "", "cached": True, "engine_runs": 0,
    } | {"engine_runs_from_cache": 0}  # fmt: skip
    assert _files(kept.folder / "again") == _files(kept.folder / "first")
    said = kept.run("verify", "--quick", "--output", "printed").stdout
    assert f"from the cache: measured {kept.first['started']}" in said


@pytest.mark.slow
@pytest.mark.live
def test_only_what_is_damaged_is_run_again(kept, copy):
    *runs, report = copy.entries()
    assert len(runs) == kept.first["engine_runs"]
    report.write_bytes(report.read_bytes()[:-1])
    for path in runs[:5]:
        data = bytearray(path.read_bytes())
        data[-1] ^= 1
        path.write_bytes(bytes(data))
    done = copy.run("verify", "--quick", "--json", "--output", "run")
    record = json.loads(done.stdout)
    assert done.stderr.count("is damaged") == 6
    assert record["cached"] is False
    assert record["engine_runs"] == 5
    assert record["checks"] == kept.first["checks"]
    assert all(path.exists() for path in (report, *runs))


@pytest.fixture
def died(monkeypatch):
    """A verification whose engine died, in place of one that takes its time."""
    found = SimpleNamespace(
        engine_errors=("crashed",),
        cases=(),
        to_json=lambda: {"status": 3, "engine_errors": ["crashed"]},
    )
    monkeypatch.setattr(harness.workflows, "verify", lambda *_, **__: found, raising=False)
    monkeypatch.setattr(report_folder, "write", lambda _, folder, __, **___: folder.mkdir())
    return found


def test_a_verification_whose_engine_died_is_not_kept(died, tmp_path, monkeypatch):
    monkeypatch.setattr(verify, "_key", lambda *_: "ab" * 32)
    asked = verify.VerifyOptions(quick=True, no_baseline=True)
    engine = EngineOptions(engine="reference", cache=tmp_path / "cache")

    def kept():
        return Entries(tmp_path / "cache").get("ab" * 32)

    verify.verified(asked, engine, tmp_path / "run", silent)
    assert kept() is None
    died.engine_errors, died.to_json = (), lambda: {"status": 0, "engine_errors": []}
    verify.verified(asked, engine, tmp_path / "again", silent)
    assert kept() is not None


def test_a_kept_report_that_is_none_is_dropped(tmp_path):
    said = []
    entries = Entries(tmp_path / "cache", tell=said.append)
    entries.put("ab" * 32, b"no archive")
    assert verify._kept(entries, "ab" * 32, tmp_path / "run") is None
    assert "not a verification" in said[0]
    assert [path.name for path in tmp_path.iterdir()] == ["cache"]


def test_a_named_cache_that_cannot_be_written_is_an_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RequestError, match=r"--cache .*file: cannot be used"):
        CacheOptions(cache=tmp_path / "file").entries()


def test_a_default_cache_that_cannot_be_written_costs_a_note(tmp_path, monkeypatch, capsys):
    (tmp_path / "file").write_text("")
    monkeypatch.delenv("DEM_HARNESS_HOME")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert CacheOptions().entries() is None
    assert "nothing is kept" in capsys.readouterr().err


@pytest.mark.live
def test_runs_of_a_single_command_are_kept_and_fresh_runs_them_again(answer, tmp_path):
    options = ("critical-angle", "--stiffness", "1e5", "--cache", str(tmp_path / "mine"))
    first, again, fresh = answer(*options), answer(*options), answer(*options, "--fresh")
    assert [a["engine_runs"] for a in (first, again, fresh)] == [first["runs"], 0, first["runs"]]
    assert again["engine_runs_from_cache"] == first["runs"]
    assert len({a["critical_angle_deg"] for a in (first, again, fresh)}) == 1
    assert (tmp_path / "mine").is_dir()
