"""The command that says what is kept, and clears it."""

import os
import time

import numpy as np
import pytest

from harness.engines import process
from harness.engines.output import Output
from harness.observables.provenance import Provenance
from harness.store.cache import pack_output
from harness.store.entries import Entries, pack_verification


@pytest.fixture
def folder(tmp_path):
    """A cache with a run of each of two cases, a verification, an environment, a kernel."""
    cache = tmp_path / "cache"
    entries = Entries(cache)
    output = Output((), Provenance("toy", "1"), {"t": {"x": np.arange(3)}}, "", 0.0, "toy")
    for number, case in enumerate(("incline", "tower")):
        entries.put(f"{number}" * 64, pack_output(output, case))
    (tmp_path / "report").mkdir()
    entries.put("2" * 64, pack_verification(tmp_path / "report", {"cases": ["tower"]}))
    home = cache / process.FOLDER / "1.0"
    home.mkdir(parents=True)
    (home / process.COMPLETE).write_text("12345")
    (cache / "numba" / "a").mkdir(parents=True)
    (cache / "numba" / "a" / "kernel.nbc").write_bytes(b"code")
    old = time.time() - 40 * 86_400
    os.utime(cache / "00" / ("0" * 64), (old, old))
    return cache


def test_size_path_and_cases(folder, harness, answer):
    found = answer("cache", "--cache", str(folder))
    assert found["cache"] == str(folder)
    counts = {sort: part["count"] for sort, part in found["sorts"].items()}
    assert counts == {"run": 2, "verification": 1, "environment": 1, "kernel": 1}
    assert {case: part["count"] for case, part in found["cases"].items()} == {
        "incline": 1, "tower": 2,
    }  # fmt: skip
    assert found["size_bytes"] == sum(
        path.stat().st_size for path in folder.rglob("*") if path.is_file()
    )
    said = harness("cache", "--cache", str(folder)).stdout
    assert said.startswith(f"{folder}: 5 kept")


@pytest.mark.parametrize(
    ("words", "left"),
    [
        (("--case", "tower"), {"run": 1, "environment": 1, "kernel": 1}),
        (("--older-than", "30"), {"run": 1, "verification": 1, "environment": 1, "kernel": 1}),
        (("--older-than", "30", "--case", "tower"), {
            "run": 2, "verification": 1, "environment": 1, "kernel": 1,
        }),
    ],
)  # fmt: skip
def test_by_age_and_case(folder, answer, words, left):
    before = answer("cache", "--cache", str(folder))["count"]
    found = answer("cache", "--clear", *words, "--cache", str(folder))
    assert {sort: part["count"] for sort, part in found["sorts"].items()} == left
    assert found["cleared"]["count"] == before - found["count"]


@pytest.mark.parametrize("files", [[], ["notes.txt"]])
def test_all_of_it_leaves_no_folder_but_what_is_somebodys(folder, answer, files):
    for name in files:
        (folder / name).write_text("somebody's")
    assert answer("cache", "--clear", "--cache", str(folder))["count"] == 0
    assert [path.name for path in folder.rglob("*")] == files
    assert folder.exists() == bool(files)


def test_what_is_no_cache_is_not_touched(folder, tmp_path, answer):
    home = tmp_path / "home"
    for name in ("numba/setup.py", "ab/notes", "releases/1.0/complete", "empty/x"):
        (home / name).parent.mkdir(parents=True, exist_ok=True)
        (home / name).write_text("mine")
    (home / "empty" / "x").unlink()
    before = sorted(home.rglob("*"))
    assert answer("cache", "--clear", "--cache", str(home))["cleared"]["count"] == 0
    assert sorted(home.rglob("*")) == before
    (folder / "ab").mkdir()
    (folder / "ab" / "notes").write_text("mine")
    answer("cache", "--clear", "--cache", str(folder))
    assert (folder / "ab" / "notes").is_file()


def test_wrong_requests(folder, harness):
    for words, said in (
        (("--older-than", "nan"), "--older-than nan: must be 0 days or more"),
        (("--case", "nothing"), "nothing"),
    ):
        assert said in harness("cache", "--cache", str(folder), *words, status=2).stderr
    assert harness("cache", "--cache", str(folder / "no")).stdout.startswith(str(folder / "no"))
