import subprocess
import sys

import pytest

from harness.store.aside import PREFIX, whole_folder


def test_the_folder_is_there_at_the_end_of_the_block(tmp_path):
    target = tmp_path / "below" / "run"
    with whole_folder(target) as aside:
        aside.mkdir()
        (aside / "results").write_text("1")
        assert not target.exists()
    assert (target / "results").read_text() == "1"
    assert [path.name for path in target.parent.iterdir()] == ["run"]


def test_an_empty_folder_is_replaced(tmp_path):
    (tmp_path / "run").mkdir()
    with whole_folder(tmp_path / "run") as aside:
        aside.mkdir()
        (aside / "results").write_text("1")
    assert (tmp_path / "run" / "results").is_file()


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
from harness.store.aside import whole_folder
with whole_folder(Path(sys.argv[1])) as aside:
    aside.mkdir()
    (aside / "half").write_text("half")
    print("filling", flush=True)
    time.sleep(60)
"""


@pytest.fixture
def keeper(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-c", KEEPER, tmp_path / "other"], stdout=subprocess.PIPE
    )
    assert process.stdout.readline() == b"filling\n"
    yield process
    process.kill()
    process.communicate()


def test_the_folder_of_a_living_process_is_left_alone_that_of_a_killed_one_removed(
    keeper, tmp_path
):
    with whole_folder(tmp_path / "one") as aside:
        aside.mkdir()
    assert len(list(tmp_path.glob(f"{PREFIX}*"))) == 1
    keeper.kill()
    keeper.wait()
    with whole_folder(tmp_path / "two") as aside:
        aside.mkdir()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one", "two"]
