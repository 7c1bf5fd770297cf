"""Places, locks, and files and folders that are complete or not there."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from harness import files
from harness.errors import FullDiskError, RequestError
from harness.files import (
    OTHERS,
    PREFIX,
    VARIABLE,
    cache_place,
    check_folder,
    lock_file,
    make_private,
    sweep,
    text_writer,
    whole_folder,
    writable_by_others,
    write_files,
)


def test_the_option_wins_over_the_variable(monkeypatch):
    monkeypatch.setenv(VARIABLE, "/named")
    assert cache_place(Path("/mine")) == (Path("/mine"), "--cache")
    assert cache_place() == (Path("/named/cache"), VARIABLE)
    monkeypatch.delenv(VARIABLE)
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    assert cache_place().path == Path.home() / ".cache" / "dem-harness"


def test_a_lock_keeps_the_content_of_a_file_and_follows_no_link(tmp_path):
    target = tmp_path / "thesis.tex"
    target.write_text("years of work")
    with lock_file(target):
        pass
    (tmp_path / ".lock").symlink_to(target)
    with pytest.raises(OSError, match="symbolic links"), lock_file(tmp_path / ".lock"):
        pass
    assert target.read_text() == "years of work"


def test_a_private_folder_is_this_user_s_alone_and_so_are_those_made_above_it(tmp_path):
    before = os.umask(0)
    try:
        make_private(tmp_path / "a" / "b")
    finally:
        os.umask(before)
    assert {path.stat().st_mode & 0o777 for path in tmp_path.rglob("*")} == {0o700}


@pytest.mark.parametrize(
    ("mode", "bits", "reason"),
    [
        (0o775, 0o022, "others may write it (mode 775)"),
        (0o775, OTHERS, ""),
        (0o757, OTHERS, "others may write it (mode 757)"),
    ],
)
def test_who_may_write_a_folder(tmp_path, mode, bits, reason):
    tmp_path.chmod(mode)
    assert writable_by_others(tmp_path, bits) == reason


@pytest.mark.parametrize("stop", [KeyboardInterrupt, OSError])
@pytest.mark.parametrize("replace", [False, True])
def test_nothing_changes_by_a_block_that_fails(tmp_path, stop, replace):
    if replace:
        (tmp_path / "run").mkdir()

    def fill():
        with whole_folder(tmp_path / "run", replace=replace):
            raise stop

    with pytest.raises(stop):
        fill()
    assert [path.name for path in tmp_path.iterdir()] == ["run"] * replace


def test_what_another_process_writes_meanwhile_stays(tmp_path):
    with pytest.raises(RequestError, match="holds something"), whole_folder(tmp_path / "run"):
        write_files({("--csv", tmp_path / "run" / "other"): text_writer("whole")})
    assert [path.name for path in tmp_path.rglob("*")] == ["run", "other"]


def test_a_folder_is_there_as_a_whole_at_the_end_of_the_block(tmp_path):
    with whole_folder(tmp_path / "run") as new:
        (new / "first").touch()
        assert not (tmp_path / "run").exists()
    with whole_folder(tmp_path / "run", replace=True) as new:
        (new / "second").touch()
        assert (tmp_path / "run" / "first").exists()
    assert [path.relative_to(tmp_path) for path in tmp_path.rglob("*")] == [
        Path("run"), Path("run/second")]  # fmt: skip


def test_a_folder_takes_the_place_of_a_link_s_target(tmp_path):
    (tmp_path / "link").symlink_to("run")
    with whole_folder(tmp_path / "link") as new:
        (new / "first").touch()
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "run" / "first").exists()


def test_a_full_disk_is_an_error_by_name_and_new_folders_go(tmp_path):
    folder = tmp_path / "runs" / "mine"
    with pytest.raises(FullDiskError, match=f"{folder}: No space"), whole_folder(folder):
        raise OSError(28, "No space left on device")
    assert not list(tmp_path.iterdir())


def test_a_mount_point_takes_no_report(tmp_path, monkeypatch):
    monkeypatch.setattr(Path, "is_mount", lambda _: True)
    with pytest.raises(RequestError, match=f"--output {tmp_path}: is a mount point"):
        check_folder(tmp_path)


def test_files_are_all_written_or_none(tmp_path):
    (tmp_path / "a").write_text("old")

    def fail(_):
        raise OSError(28, "No space left on device")

    good = {("--csv", tmp_path / "a"): text_writer("new")}
    with pytest.raises(FullDiskError, match=r"--png .*No space"):
        write_files(good | {("--png", tmp_path / "new" / "b"): fail})
    assert (tmp_path / "a").read_text() == "old"
    write_files(good)
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("a", "new")]


KEEPER = """
import sys, time
from pathlib import Path
from harness.files import whole_folder
with whole_folder(Path(sys.argv[1])) as new:
    (new / "half").write_text("half")
    print("filling", flush=True)
    time.sleep(60)
"""


def test_a_folder_of_a_living_process_stays_and_of_a_killed_one_goes(tmp_path):
    words = [sys.executable, "-c", KEEPER, tmp_path / "other"]
    with subprocess.Popen(words, stdout=subprocess.PIPE) as keeper:
        assert keeper.stdout.readline() == b"filling\n"
        sweep(tmp_path)
        assert len(list(tmp_path.glob(f"{PREFIX}*"))) == 1
        keeper.kill()
    sweep(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_link_and_a_folder_that_others_write_or_own_are_left_alone(tmp_path, monkeypatch):
    victim = tmp_path / "victim"
    victim.mkdir()
    (tmp_path / f"{PREFIX}link").symlink_to(victim)
    folder = tmp_path / f"{PREFIX}x"
    folder.mkdir()
    folder.chmod(0o777)
    sweep(tmp_path)
    folder.chmod(0o700)
    monkeypatch.setattr(files.os, "geteuid", lambda: 12345)
    sweep(tmp_path)
    assert folder.is_dir()
    assert victim.is_dir()
    monkeypatch.undo()
    sweep(tmp_path)
    assert not folder.exists()
