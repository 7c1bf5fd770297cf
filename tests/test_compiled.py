"""Where numba keeps compiled kernels: in the cache folder, or where the user says."""

import errno
import os
import pickle
import subprocess
import sys
from pathlib import Path

from harness.compiled import jit
from harness.files import VARIABLE

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


def run_python(source, folder, home, numba_cache=""):
    """Run Python in a folder and return the process; files it makes others may write."""
    environment = {**os.environ, "PYTHONPATH": str(PROJECT), VARIABLE: str(home)}
    environment["NUMBA_CACHE_DIR"] = str(numba_cache)
    command = [sys.executable, "-B", "-c", source]
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=True,
        umask=0o002,
    )  # fmt: skip


def test_a_kernel_is_kept_where_the_user_says(tmp_path):
    (tmp_path / "kernel.py").write_text(KERNEL)
    run = run_python("import kernel", tmp_path, tmp_path / "home", tmp_path / "mine")
    kept = [path for path in tmp_path.rglob("*") if path.suffix in (".nbi", ".nbc")]
    assert len(kept) == 2
    assert all(path.is_relative_to(tmp_path / "mine") for path in kept)
    # other users of numba in the same process keep their own place
    assert run.stdout.strip() == repr(str(tmp_path / "mine"))


def test_a_place_into_which_the_user_may_not_look_costs_no_run(tmp_path):
    """Root may look into all folders; a name that is too long fails in the same way."""
    (tmp_path / "kernel.py").write_text(KERNEL)
    assert "error" not in run_python("import kernel", tmp_path, tmp_path / ("x" * 300)).stderr


def test_a_full_disk_costs_a_line_and_no_run(monkeypatch, capsys, tmp_path):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setenv(VARIABLE, str(tmp_path))
    monkeypatch.setattr("numba.core.caching.IndexDataCacheFile.save", full)
    kernels = [jit(lambda x: 2.0 * x), jit(lambda x: 3.0 * x)]
    assert [kernel(2.0) for kernel in kernels] == [4.0, 6.0]
    (line,) = capsys.readouterr().err.splitlines()
    assert "No space left on device" in line


PART = "from harness.compiled import jit\n@jit\ndef part(x):\n    return {factor} * x\n"
CALLER = """
from harness.compiled import jit
from part import part

@jit
def whole(x):
    return part(x) + 0.5

print(whole(1.0))
"""


def test_a_kernel_is_compiled_again_when_one_that_it_calls_has_changed(tmp_path):
    (tmp_path / "caller.py").write_text(CALLER)
    values = []
    for factor in (2.0, 3.0):
        (tmp_path / "part.py").write_text(PART.format(factor=factor))
        values.append(float(run_python("import caller", tmp_path, tmp_path / "home").stdout))
    assert values == [2.5, 3.5]


class Runs:
    """A pickle that makes a folder as it is read: what a stranger's kernel could do."""

    def __init__(self, mark):
        self.mark = str(mark)

    def __reduce__(self):
        return os.mkdir, (self.mark,)


def plant(folder, mark):
    """Put a pickle that runs code in the place of each kept kernel."""
    planted = list(folder.rglob("*.nbi"))
    assert planted
    for path in planted:
        path.write_bytes(pickle.dumps(Runs(mark)))


def test_kernels_are_kept_for_this_user_alone_and_no_others_are_read(tmp_path):
    """Whatever the umask; a pickle in the user's own folder is read, and so its mark is made."""
    for name in ("mine", "free", "linked"):  # of other stamps: in folders of their own
        (tmp_path / name).mkdir()
        (tmp_path / name / f"{name}.py").write_text(f"# {name}{KERNEL}")
    places = "import sys; sys.path += ['free', 'linked', 'mine']; import free, linked"
    run_python(f"{places}, mine", tmp_path, tmp_path / "home")
    (cache,) = tmp_path.glob("home/cache/numba")
    folders = {
        next(iter(path.rglob("*.nbi"))).name.partition(".")[0]: path for path in cache.iterdir()
    }
    for path in (*folders.values(), cache, cache.parent):
        assert path.stat().st_mode & 0o777 == 0o700
    for name, folder in folders.items():
        plant(folder, tmp_path / f"mark of {name}")
    folders["free"].chmod(0o775)
    folders["linked"].rename(tmp_path / "elsewhere")
    folders["linked"].symlink_to(tmp_path / "elsewhere")
    again = f"{places}\ntry: import mine\nexcept Exception: pass"
    said = run_python(again, tmp_path, tmp_path / "home").stderr
    notes = [line for line in said.splitlines() if line.startswith("dem-harness: kernels in")]
    assert [path.name for path in tmp_path.glob("mark of *")] == ["mark of mine"]
    ways = {"free": "others may write it (mode 775)", "linked": "it is a link"}
    for note, (name, way) in zip(notes, ways.items(), strict=True):
        assert f"kernels in {folders[name]} are not used, {way}" in note
        assert "DEM_HARNESS_HOME" in note
