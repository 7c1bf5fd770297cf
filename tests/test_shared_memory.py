"""Segments of MPICH: unlinked when the program that made them is gone."""

import os
import shutil
import sys
from collections import namedtuple

import pytest

from harness import files
from harness.engines.process import Processes
from harness.errors import EngineMemoryError
from harness.files import SHARED

pytestmark = pytest.mark.skipif(not SHARED.is_dir(), reason=f"no {SHARED} here")

MEMORY = 4 * 1024**3
USAGE = namedtuple("USAGE", "total used free")

MAPS = """
import mmap, sys, time
with open(sys.argv[1], "w+b") as file:
    file.truncate(4096)
    held = mmap.mmap(file.fileno(), 4096)
print("mapped", flush=True)
time.sleep(100)
"""


@pytest.fixture
def segment():
    """Return the path of a segment of this test, which is removed in the end."""
    path = SHARED / f"mpich_shm_{os.getpid():x}_77"
    yield path
    path.unlink(missing_ok=True)


def test_a_program_that_hangs_leaves_no_segment(tmp_path, segment):
    another = segment.with_name(segment.name + "9")
    another.touch()  # of this user, yet of nothing that was started here
    words = [sys.executable, "-c", MAPS, str(segment)]
    ended = Processes().run(words, tmp_path, seconds=1.0, memory=MEMORY)
    assert ended.timed_out
    assert "mapped" in ended.said
    assert not segment.exists()
    assert another.exists()
    another.unlink()


@pytest.mark.parametrize("name", ["mpich_shm_1_0", "other", "../mpich_shm_1_0"])
def test_only_segments_written_down_are_unlinked(tmp_path, monkeypatch, name):
    shared = tmp_path / "shared"
    shared.mkdir()
    monkeypatch.setattr(files, "SHARED", shared)
    for file in (tmp_path / "mpich_shm_1_0", shared / "mpich_shm_1_0", shared / "other"):
        file.touch()
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / files.RECORD).write_text(name + "\n")
    files.remove_segments(folder)
    assert (tmp_path / "mpich_shm_1_0").exists()
    assert (shared / "other").exists()
    assert (shared / "mpich_shm_1_0").exists() == (name == "other")


def test_one_that_dies_for_want_of_shared_memory_is_told_what_helps(tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, "disk_usage", lambda _: USAGE(64 * 10**6, 63 * 10**6, 10**6))
    source = "import os, signal; os.kill(os.getpid(), signal.SIGBUS)"
    words = [sys.executable, "-c", source]
    ended = Processes().run(words, tmp_path, seconds=60.0, memory=MEMORY)
    error = ended.error("LAMMPS")
    assert type(error) is EngineMemoryError
    assert "signal SIGBUS" in str(error)
    assert f"{SHARED} holds 64 MB, 1 MB of it free" in str(error)
    assert "fewer workers" in str(error)
    assert "--shm-size" in str(error)
