import os
import shutil

import pytest

from harness.engines.lammps.engine import Lammps
from harness.engines.lammps.releases import fingerprint
from harness.engines.programs import digest
from harness.engines.registry import fingerprint_of


@pytest.fixture
def program(tmp_path):
    """A program with libraries, at a place of its own."""
    path = tmp_path / "lmp"
    shutil.copy(shutil.which("env") or "/usr/bin/env", path)
    return path


def _again(*arguments):
    digest.cache_clear()
    return fingerprint(*arguments)


def test_a_program_is_told_by_its_content_and_that_of_its_libraries(program):
    first = fingerprint(str(program))
    assert first["how"] == "executable"
    assert any("libc" in name for name in first["files"])
    os.utime(program, (1, 1))
    assert _again(str(program)) == first
    with program.open("ab") as stream:
        stream.write(b"\0")
    assert _again(str(program)) != first


def test_the_launcher_and_its_ranks_count(program):
    ways = [fingerprint(str(program), launcher) for launcher in (None, "env A=2", "env A=4")]
    assert len({str(way) for way in ways}) == 3


def test_arguments_count(program):
    ways = [fingerprint(f"{program}{more}") for more in ("", " -sf omp", " -sf opt")]
    assert len({str(way) for way in ways}) == 3
    assert ways[0] == fingerprint(str(program))
    assert len({str(way["files"]) for way in ways}) == 1


def test_the_twin_of_the_library_counts_and_an_executable_has_none(program):
    assert Lammps.twin_options() == {"lmp": "lmp"}
    assert Lammps.twin_options(lmp=str(program)) is None
    assert "twin" not in fingerprint_of("lammps", {"lmp": str(program)})


@pytest.mark.usefixtures("lammps_here")
def test_the_library_of_this_environment_is_told_without_loading_it():
    found = fingerprint_of("lammps", {})
    assert found["how"] == "in-process"
    assert any("liblammps" in name for name in found["files"])
    assert any("libmpi" in name for name in found["files"])


@pytest.mark.usefixtures("lammps_here")
def test_the_fingerprint_of_an_engine_is_that_of_its_class():
    with Lammps() as engine:
        assert engine.fingerprint() == fingerprint() == Lammps.fingerprint_of()
