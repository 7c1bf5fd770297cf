import os
from pathlib import Path

import pytest

from harness.files import (
    OTHERS,
    VARIABLE,
    cache_place,
    lock_file,
    make_private,
    writable_by_others,
)


def test_the_option_wins_over_the_variable(monkeypatch):
    monkeypatch.setenv(VARIABLE, "/named")
    assert cache_place(Path("/mine")).path == Path("/mine")
    assert cache_place(Path("/mine")).named_by == "--cache"
    assert cache_place().path == Path("/named/cache")
    assert cache_place().named_by == VARIABLE


def test_a_refused_place_names_what_named_it():
    refused = cache_place(Path("/mine")).refused("Read-only file system")
    assert str(refused) == "--cache /mine: cannot be used (Read-only file system)"
    assert refused.exit_status == 2


def test_a_lock_does_not_touch_what_a_link_points_to(tmp_path):
    target = tmp_path / "thesis.tex"
    target.write_text("years of work")
    (tmp_path / ".lock").symlink_to(target)
    with pytest.raises(OSError, match="symbolic links"), lock_file(tmp_path / ".lock"):
        pass
    assert target.read_text() == "years of work"


def test_a_lock_keeps_what_a_file_holds(tmp_path):
    (tmp_path / ".lock").write_text("kept")
    with lock_file(tmp_path / ".lock"):
        pass
    assert (tmp_path / ".lock").read_text() == "kept"


def test_a_private_folder_is_this_user_s_alone_and_so_are_those_made_above_it(tmp_path):
    before = os.umask(0)
    try:
        make_private(tmp_path / "a" / "b")
    finally:
        os.umask(before)
    assert {path.stat().st_mode & 0o777 for path in (tmp_path / "a", tmp_path / "a" / "b")} == {
        0o700
    }


@pytest.mark.parametrize(
    ("mode", "bits", "said"),
    [
        (0o755, 0o022, ""),
        (0o775, 0o022, "others may write it (mode 775)"),
        (0o775, OTHERS, ""),
        (0o757, OTHERS, "others may write it (mode 757)"),
    ],
)
def test_who_may_write_a_folder(tmp_path, mode, bits, said):
    folder = tmp_path / "folder"
    folder.mkdir()
    folder.chmod(mode)
    assert writable_by_others(folder, bits) == said


def test_a_folder_of_another_user_is_theirs_whatever_its_mode(tmp_path, monkeypatch):
    tmp_path.chmod(0o700)
    if os.geteuid() == 0:  # root's own folders are everybody's to trust
        os.chown(tmp_path, 4321, -1)
        assert writable_by_others(tmp_path) == "it belongs to user 4321"
    else:
        owner = os.geteuid()
        monkeypatch.setattr(os, "geteuid", lambda: owner + 1)
        assert writable_by_others(tmp_path) == f"it belongs to user {owner}"
