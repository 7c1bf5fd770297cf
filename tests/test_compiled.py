"""Where numba keeps compiled kernels: in the cache folder, or where the user says."""

import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numba
import pytest

from harness.compiled import jit
from harness.home import VARIABLE

PROJECT = Path(__file__).parents[1]

KERNEL = """
from harness.compiled import jit

def twice(x):
    return 2.0 * x

twice = jit(twice)
assert twice(2.0) == 4.0
import numba
print(repr(numba.config.CACHE_DIR))
"""


@pytest.mark.parametrize("own", ["", "mine"])
def test_a_kernel_is_kept_in_the_cache_folder_or_where_the_user_says(tmp_path, own):
    (tmp_path / "kernel.py").write_text(KERNEL)
    home, mine = tmp_path / "home", str(tmp_path / own) if own else ""
    environment = {**os.environ, "PYTHONPATH": str(PROJECT), VARIABLE: str(home)}
    environment["NUMBA_CACHE_DIR"] = mine
    said = subprocess.run(
        [sys.executable, "-c", "import kernel"],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    kept = [path for path in tmp_path.rglob("*") if path.suffix in (".nbi", ".nbc")]
    assert len(kept) == 2
    where = tmp_path / own if own else home / "cache" / "numba"
    assert all(path.is_relative_to(where) for path in kept)
    # other users of numba in the same process keep their own place
    assert said.strip() == repr(mine)


@pytest.mark.slow
def test_uninstalling_leaves_no_file(tmp_path, monkeypatch):
    monkeypatch.delenv("PYTHONPATH", raising=False)
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")
    monkeypatch.setenv(VARIABLE, str(tmp_path / "home"))
    folder = tmp_path / "environment"
    subprocess.run([sys.executable, "-m", "venv", folder], check=True)
    pip = [folder / "bin" / "pip", "--disable-pip-version-check", "-q"]
    (site,) = folder.glob("lib/python*/site-packages")
    # what the project depends on is that of this environment; the project's wheel is not
    others = next(path for path in map(Path, sys.path) if (path / "numba").is_dir())
    (site / "others.pth").write_text(f"{others}\n")
    before = set(site.rglob("*"))
    subprocess.run([*pip, "install", "--no-deps", "--ignore-installed", PROJECT], check=True)
    for words in (
        ["tower", "--height", "2", "--solver", "exact"],
        ["run", "drop", "--engine", "reference"],
    ):
        subprocess.run([folder / "bin" / "dem-harness", *words], cwd=tmp_path, check=True)
    assert len(list((tmp_path / "home" / "cache" / "numba").rglob("*.nbc"))) > 5
    subprocess.run([*pip, "uninstall", "-y", "dem-harness"], check=True)
    left = [path for path in set(site.rglob("*")) - before if "pip" not in path.parts]
    assert left == []
    assert not (folder / "bin" / "dem-harness").exists()


CALLER = """
from harness.compiled import jit
from part import part

@jit
def whole(x):
    return part(x) + 0.5

print(whole(1.0))
"""

PART = """
from harness.compiled import jit

@jit
def part(x):
    return {factor} * x
"""


def test_a_kernel_is_compiled_again_when_one_that_it_calls_has_changed(tmp_path):
    (tmp_path / "caller.py").write_text(CALLER)
    environment = {**os.environ, "PYTHONPATH": str(PROJECT), VARIABLE: str(tmp_path / "home")}
    said = []
    for factor in (2.0, 3.0):
        (tmp_path / "part.py").write_text(PART.format(factor=factor))
        command = [sys.executable, "-B", "-c", "import caller"]
        run = subprocess.run(
            command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
        )
        said.append(float(run.stdout))
    assert said == [2.5, 3.5]


def test_threads_that_import_kernels_side_by_side_are_each_told_their_folder(monkeypatch):
    before, told = numba.config.CACHE_DIR, []

    def kernel():
        return 1.0

    def slow(**_):
        first = numba.config.CACHE_DIR
        time.sleep(0.05)
        told.append((first, numba.config.CACHE_DIR))
        return lambda function: function

    monkeypatch.setattr(numba, "njit", slow)
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(jit, [kernel] * 4))
    assert len(told) == 4
    assert all(first == last != before for first, last in told)
    after = numba.config.CACHE_DIR
    assert after == before
