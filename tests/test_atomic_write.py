import signal
import subprocess
import sys

import pytest

from harness import files
from harness.files import OLD, PREFIX, sweep, whole_folder


def test_the_folder_is_there_at_the_end_of_the_block(tmp_path):
    target = tmp_path / "below" / "run"
    with whole_folder(target) as aside:
        aside.mkdir()
        (aside / "results").write_text("1")
        assert not target.exists()
    assert (target / "results").read_text() == "1"
    assert [path.name for path in target.parent.iterdir()] == ["run"]


@pytest.mark.parametrize("stop", [KeyboardInterrupt, OSError])
def test_nothing_is_left_of_a_block_that_fails(tmp_path, stop):
    def fill():
        with whole_folder(tmp_path / "run") as aside:
            aside.mkdir()
            raise stop

    with pytest.raises(stop):
        fill()
    assert list(tmp_path.iterdir()) == []


KEEPER = """
import sys, time
from pathlib import Path
from harness.files import whole_folder
with whole_folder(Path(sys.argv[1])) as aside:
    aside.mkdir()
    (aside / "half").write_text("half")
    print("filling", flush=True)
    time.sleep(60)
"""


def test_the_folder_of_a_living_process_is_left_alone(tmp_path):
    words = [sys.executable, "-c", KEEPER, tmp_path / "other"]
    with subprocess.Popen(words, stdout=subprocess.PIPE) as keeper:
        assert keeper.stdout.readline() == b"filling\n"
        sweep(tmp_path)
        assert len(list(tmp_path.glob(f"{PREFIX}*"))) == 1
        keeper.kill()


@pytest.mark.parametrize("exchanges", [True, False])
def test_an_older_folder_is_replaced_as_a_whole(tmp_path, monkeypatch, exchanges):
    if not exchanges:  # as on a file system that cannot
        monkeypatch.setattr(files, "_exchange", lambda *_: False)
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "of-the-first").touch()
    with whole_folder(tmp_path / "run", replace=True) as aside:
        aside.mkdir()
        (aside / "of-the-second").touch()
        assert (tmp_path / "run" / "of-the-first").exists()
    assert [path.name for path in (tmp_path / "run").iterdir()] == ["of-the-second"]
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


EXCHANGED = """
import os, signal, sys
from pathlib import Path
from harness import files as atomic_write
exchange = atomic_write._exchange
def killed(*paths):
    if sys.argv[2] == "after":
        exchange(*paths)
    os.kill(os.getpid(), signal.SIGKILL)
atomic_write._exchange = killed
with atomic_write.whole_folder(Path(sys.argv[1]), replace=True) as aside:
    aside.mkdir()
    (aside / "new").touch()
"""


@pytest.mark.parametrize(("when", "left"), [("before", "kept"), ("after", "new")])
def test_a_kill_about_the_exchange_leaves_the_old_or_the_new_and_never_none(tmp_path, when, left):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "kept").touch()
    killed = subprocess.run([sys.executable, "-c", EXCHANGED, tmp_path / "run", when], check=False)
    assert killed.returncode == -signal.SIGKILL
    assert [path.name for path in (tmp_path / "run").iterdir()] == [left]
    sweep(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_a_linked_old_folder_is_not_emptied(tmp_path):
    victim = tmp_path / "victim"
    victim.mkdir()
    (victim / "papers").touch()
    aside = tmp_path / "beside" / f"{PREFIX}x"
    aside.mkdir(parents=True, mode=0o700)
    (aside / OLD).symlink_to(victim)
    sweep(aside.parent)
    assert (victim / "papers").is_file()
    assert not (aside.parent / "papers").exists()


def test_a_folder_that_others_write_or_own_is_left_alone(tmp_path, monkeypatch):
    aside = tmp_path / f"{PREFIX}x"
    aside.mkdir()
    aside.chmod(0o777)
    sweep(tmp_path)
    assert aside.is_dir()
    aside.chmod(0o700)
    monkeypatch.setattr(files.os, "geteuid", lambda: 12345)
    sweep(tmp_path)
    assert aside.is_dir()
    monkeypatch.undo()
    sweep(tmp_path)
    assert not aside.exists()
