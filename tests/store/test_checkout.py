import shutil
import subprocess

import pytest

from harness.store import acceptance


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "harness").mkdir()
    (tmp_path / "harness" / "law.py").write_text("1")
    monkeypatch.setattr(acceptance, "ROOT", tmp_path / "harness")
    return tmp_path


def _git(folder, *words):
    who = ["-c", "user.name=A", "-c", "user.email=a@example.org"]
    subprocess.run(["git", *who, *words], cwd=folder, check=True, capture_output=True)


def test_outside_a_checkout_there_is_no_commit(folder):
    assert folder.is_dir()
    assert acceptance.commit() == ""


@pytest.mark.skipif(shutil.which("git") is None, reason="git is not here")
def test_the_commit_of_a_checkout_and_whether_files_were_edited(folder):
    _git(folder, "init")
    _git(folder, "add", ".")
    _git(folder, "commit", "-m", "law")
    _git(folder, "tag", "-a", "v1", "-m", "v1")
    clean = acceptance.commit()
    assert len(clean) == 40
    (folder / "harness" / "law.py").write_text("2")
    assert acceptance.commit() == f"{clean}-dirty"
