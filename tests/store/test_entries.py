import contextlib
import fcntl
import os
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.engines.process import COMPLETE, USED, held
from harness.store.entries import ABANDONED_SECONDS, ASIDE, PRUNING, Entries, key_of

KEY, OTHER = key_of({"n": 1}), key_of({"n": 2})


@pytest.fixture
def said():
    return []


@pytest.fixture
def entries(tmp_path, said):
    return Entries(tmp_path / "cache", tell=said.append)


def path_of(entries, key):
    return entries.folder / key[:2] / key


def test_what_was_put_is_got(entries, said):
    assert entries.get(KEY) is None
    entries.put(KEY, b"payload\nof\nlines")
    entries.put(OTHER, b"")
    assert entries.get(KEY) == b"payload\nof\nlines"
    assert entries.get(OTHER) == b""
    assert Entries(entries.folder).get(KEY) == b"payload\nof\nlines"
    assert said == []
    assert list((entries.folder / ASIDE).iterdir()) == []


def _truncated(path):
    path.write_bytes(path.read_bytes()[:-3])


def _empty(path):
    path.write_bytes(b"")


def _another_file(path):
    path.write_text("# notes on granular flow\n" * 20)


def _folder(path):
    path.unlink()
    path.mkdir()
    (path / "inside").write_text("x")


@pytest.mark.parametrize("damage", [_truncated, _empty, _another_file, _folder])
def test_a_damaged_entry_is_dropped_with_a_note_and_never_used(entries, said, damage):
    entries.put(KEY, b"the result of a run")
    damage(path_of(entries, KEY))
    assert entries.get(KEY) is None
    assert len(said) == 1
    assert "damaged" in said[0]
    assert KEY in said[0]
    assert not path_of(entries, KEY).exists()
    entries.put(KEY, b"computed again")
    assert entries.get(KEY) == b"computed again"


@given(st.binary(max_size=200), st.integers(0), st.integers(0, 7))
def test_no_single_flipped_bit_goes_unseen(tmp_path_factory, payload, where, bit):
    entries = Entries(tmp_path_factory.mktemp("cache"), tell=lambda _: None)
    entries.put(KEY, payload)
    path = path_of(entries, KEY)
    data = bytearray(path.read_bytes())
    data[where % len(data)] ^= 1 << bit
    path.write_bytes(bytes(data))
    assert entries.get(KEY) is None


def test_the_ones_not_asked_for_the_longest_are_dropped(tmp_path):
    entries = Entries(tmp_path, limit=20_000)
    names = [key_of({"n": n}) for n in range(30)]
    for age, key in enumerate(names[:20]):
        entries.put(key, bytes(800))
        os.utime(path_of(entries, key), (time.time() - 1000 + age,) * 2)
    assert entries.get(names[0]) is not None  # asked for: now the youngest
    for key in names[20:30]:
        entries.put(key, bytes(800))
    size = sum(path.stat().st_size for path in tmp_path.glob("??/*"))
    assert size <= 1.1 * 20_000
    assert entries.get(names[0]) is not None
    assert entries.get(names[1]) is None
    assert entries.get(names[29]) is not None


def test_environments_of_releases_count_and_are_dropped_in_their_turn(tmp_path):
    entries = Entries(tmp_path, limit=20_000)
    homes = [tmp_path / "releases" / name for name in ("old", "used", "new")]
    for age, home in enumerate(homes):
        (home / "lib").mkdir(parents=True)
        (home / "lib" / "lmp").write_bytes(bytes(6000))
        (home / COMPLETE).touch()
        os.utime(home / COMPLETE, (age, age))
    entries.put(KEY, bytes(500))  # 18,600: pruned from 20,000 on
    with held(homes[1], USED, fcntl.LOCK_SH):
        entries.put(OTHER, bytes(9000))
    assert [home.exists() for home in homes] == [False, True, False]
    assert entries.get(OTHER) == bytes(9000)


def test_what_a_killed_process_left_aside_is_removed_after_a_while(entries):
    old, young = (entries.folder / ASIDE / name for name in ("old", "young"))
    for path in (old, young):
        path.write_bytes(b"half an ent")
    os.utime(old, (time.time() - 2 * ABANDONED_SECONDS,) * 2)
    entries.put(KEY, b"x")
    assert not old.exists()
    assert young.exists()


def test_a_folder_that_goes_away_is_told_once_and_ends_nothing(entries, said):
    entries.put(KEY, b"x")
    for path in (path_of(entries, KEY), path_of(entries, KEY).parent, entries.folder / ASIDE):
        path.unlink() if path.is_file() else path.rmdir()
    entries.put(KEY, b"x")
    entries.put(OTHER, b"x")
    assert entries.get(KEY) is None
    assert len(said) == 1
    assert "nothing more is kept" in said[0]


def test_a_file_in_the_place_of_the_folder_is_an_error(tmp_path):
    (tmp_path / "cache").write_text("")
    with pytest.raises(OSError, match="cache"):
        Entries(tmp_path / "cache")


def test_a_cache_that_all_may_write_or_of_another_user_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "geteuid", lambda: 4321)
    tmp_path.chmod(0o777)
    if os.getuid() == 0:
        os.chown(tmp_path, 4321, -1)
        with pytest.raises(PermissionError, match=r"others may write it \(mode 777\); make it"):
            Entries(tmp_path)
        os.chown(tmp_path, 1234, -1)
    tmp_path.chmod(0o700)
    with pytest.raises(PermissionError, match=r"it belongs to user \d+; make it yours alone"):
        Entries(tmp_path)


@pytest.mark.parametrize("name", [PRUNING, f"releases/2025.7.22.4.0{USED}"])
def test_no_lock_empties_what_a_link_points_to(tmp_path, said, name):
    target = tmp_path / "thesis.tex"
    target.write_text("years of work")
    lock = tmp_path / "cache" / name
    lock.parent.mkdir(parents=True)
    lock.symlink_to(target)
    Entries(tmp_path / "cache", limit=10, tell=said.append).put(KEY, b"payload")
    with contextlib.suppress(OSError), held(tmp_path / "cache/releases/2025.7.22.4.0", USED):
        pass
    assert target.read_text() == "years of work"
