import pytest

from harness.reproduction import page


def fill(text):
    def inside(_found, path, _root):
        (path / "ledger.csv").write_text(text, encoding="utf-8")

    return inside


def test_an_older_reproduction_is_replaced_as_a_whole_or_left(tmp_path, monkeypatch):
    target = tmp_path / "reproduction"
    monkeypatch.setattr(page, "_fill", fill("first"))
    page.write(None, target)

    def fails(_found, path, _root):
        (path / "half.svg").touch()
        raise KeyboardInterrupt

    monkeypatch.setattr(page, "_fill", fails)
    with pytest.raises(KeyboardInterrupt):
        page.write(None, target)
    assert (target / "ledger.csv").read_text(encoding="utf-8") == "first"
    (target / "of-the-first.svg").touch()
    monkeypatch.setattr(page, "_fill", fill("second"))
    page.write(None, target)
    assert [path.name for path in target.iterdir()] == ["ledger.csv"]
    assert (target / "ledger.csv").read_text(encoding="utf-8") == "second"
    assert [path.name for path in tmp_path.iterdir()] == ["reproduction"]
