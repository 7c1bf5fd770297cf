"""Where numba keeps compiled kernels: in the cache folder, or where the user says."""

import errno
import os
import pickle
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numba
import pytest

from harness import compiled, solvers
from harness.compiled import jit, waits_for_compilation
from harness.files import VARIABLE
from harness.workflows.session import COMPILE

KERNEL = """
from harness.compiled import jit

def twice(x):
    return 2.0 * x

twice = jit(twice)
assert twice(2.0) == 4.0
"""


@pytest.fixture
def load(monkeypatch, tmp_path):
    """Return a function that imports modules of a folder as a new process of a user would."""
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.syspath_prepend(tmp_path)
    umask = os.umask(0o002)  # what is made, others may write

    def anew(*names, home="home", chosen=""):
        monkeypatch.setenv(VARIABLE, str(tmp_path / home))
        monkeypatch.setenv("NUMBA_CACHE_DIR", chosen)  # numba reads it again where it has changed
        monkeypatch.setattr("numba.config.CACHE_DIR", chosen)
        forget()
        return [import_module(name) for name in names]

    def forget():
        for known in (compiled._stamp, compiled._is_private, compiled._note):
            known.cache_clear()
        for path in tmp_path.rglob("*.py"):
            sys.modules.pop(path.stem, None)

    yield anew
    forget()
    os.umask(umask)


def test_a_kernel_is_kept_where_the_user_says(load, tmp_path):
    (tmp_path / "kernel.py").write_text(KERNEL)
    load("kernel", chosen=str(tmp_path / "mine"))
    kept = [path for path in tmp_path.rglob("*") if path.suffix in (".nbi", ".nbc")]
    assert len(kept) == 2
    assert all(path.is_relative_to(tmp_path / "mine") for path in kept)
    # other users of numba in the same process keep their own place
    assert str(tmp_path / "mine") == numba.config.CACHE_DIR


def test_a_place_into_which_the_user_may_not_look_costs_no_run(load, tmp_path, capsys):
    """Root may look into all folders; a name that is too long fails in the same way."""
    (tmp_path / "kernel.py").write_text(KERNEL)
    load("kernel", home="x" * 300)
    assert "error" not in capsys.readouterr().err


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
"""


def test_a_kernel_is_compiled_again_when_one_that_it_calls_has_changed(load, tmp_path):
    (tmp_path / "caller.py").write_text(CALLER)
    values = []
    for factor in (2.0, 3.0):
        (tmp_path / "part.py").write_text(PART.format(factor=factor))
        (caller,) = load("caller")
        values.append(caller.whole(1.0))
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


def test_kernels_are_kept_for_this_user_alone_and_no_others_are_read(
    load, tmp_path, monkeypatch, capsys
):
    """Whatever the umask; a pickle in the user's own folder is read, and so its mark is made."""
    for name in ("mine", "free", "linked"):  # of other stamps: in folders of their own
        (tmp_path / name).mkdir()
        (tmp_path / name / f"{name}_kernel.py").write_text(f"# {name}{KERNEL}")
        monkeypatch.syspath_prepend(tmp_path / name)
    load("free_kernel", "linked_kernel", "mine_kernel")
    (cache,) = tmp_path.glob("home/cache/numba")
    folders = {
        next(iter(path.rglob("*.nbi"))).name.partition("_")[0]: path for path in cache.iterdir()
    }
    for path in (*folders.values(), cache, cache.parent):
        assert path.stat().st_mode & 0o777 == 0o700
    for name, folder in folders.items():
        plant(folder, tmp_path / f"mark of {name}")
    folders["free"].chmod(0o775)
    folders["linked"].rename(tmp_path / "elsewhere")
    folders["linked"].symlink_to(tmp_path / "elsewhere")
    load("free_kernel", "linked_kernel", "mine_kernel")
    said = capsys.readouterr().err
    notes = [line for line in said.splitlines() if line.startswith("dem-harness: kernels in")]
    assert [path.name for path in tmp_path.glob("mark of *")] == ["mark of mine"]
    ways = {"free": "others may write it (mode 775)", "linked": "it is a link"}
    for note, (name, way) in zip(notes, ways.items(), strict=True):
        assert f"kernels in {folders[name]} are not used, {way}" in note
        assert "DEM_HARNESS_HOME" in note


OWN_CHECKS = """
from numba.core import event
from harness.cases.bench import Bench
from harness.cases.checks import run_checks
from harness.cases.tower.case import CASE

with event.install_recorder("numba:compile") as compiled:
    rows = run_checks("tower", list(CASE.own_checks()), Bench(None))
print(len(compiled.buffer), len(rows) > 10)
"""


def test_a_place_waits_for_kernels_until_one_is_kept_there(monkeypatch, tmp_path):
    folder = Path(solvers.__path__[0])
    for place, waits in ((tmp_path, True), (tmp_path / ("x" * 300), False)):
        monkeypatch.setattr("numba.config.CACHE_DIR", str(place))
        assert waits_for_compilation(folder) is waits
    monkeypatch.setattr("numba.config.CACHE_DIR", str(tmp_path))
    kept = next(tmp_path.iterdir()) / "solvers"
    kept.mkdir()
    (kept / "kernel.nbi").touch()
    assert not waits_for_compilation(folder)


OTHERS = """
from numba.core import event
from harness.solvers import reference

with event.install_recorder("numba:compile") as compiled:
    reference.run(reference.SMALLEST)
names = {record.data["dispatcher"].py_func.__name__ for _, record in compiled.buffer}
friction = {"find_slip", "tangential_force", "rolling_torque", "twisting_torque"}
print(len(names & friction), "take_steps" in names)
"""


@pytest.mark.slow  # it compiles for ten and for twenty seconds
@pytest.mark.parametrize(("beside", "then"), [(COMPILE[1], OWN_CHECKS), (COMPILE[0], OTHERS)])
def test_what_another_process_compiles_is_what_this_one_needs(beside, then, tmp_path):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    for text in (beside, then):
        run = subprocess.run(
            [sys.executable, "-P", "-c", text], env=environment, capture_output=True, text=True,
            check=True,
        )  # fmt: skip
    assert run.stdout.split() == ["0", "True"]
