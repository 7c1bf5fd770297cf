import io
import math
import zipfile

import pytest

from harness.store import entries
from harness.store.entries import (
    VERIFICATION_ERRORS,
    pack_verification,
    unpack_verification,
    verification_key,
)


@pytest.fixture
def report(tmp_path):
    folder = tmp_path / "report"
    (folder / "figures").mkdir(parents=True)
    (folder / "report.html").write_text("<p>±</p>", encoding="utf-8")
    (folder / "figures" / "a.png").write_bytes(bytes(range(256)))
    return folder


def test_a_report_and_its_record_come_back(report, tmp_path):
    record = {"status": 0, "checks": [{"value": math.inf, "tolerance": math.nan}]}
    back = unpack_verification(pack_verification(report, record), tmp_path / "copy")
    assert back["status"] == 0
    assert back["checks"][0]["value"] == math.inf
    assert math.isnan(back["checks"][0]["tolerance"])
    files = {p.relative_to(report): p.read_bytes() for p in report.rglob("*") if p.is_file()}
    copy = tmp_path / "copy"
    assert files == {p.relative_to(copy): p.read_bytes() for p in copy.rglob("*") if p.is_file()}


@pytest.mark.parametrize("payload", [b"", b"no archive"])
def test_what_is_no_verification_is_refused(payload, tmp_path):
    with pytest.raises(VERIFICATION_ERRORS):
        unpack_verification(payload, tmp_path / "copy")
    assert not (tmp_path / "copy").exists()


@pytest.mark.parametrize("name", ["../outside", "/tmp/outside", "a/../../outside", ""])
def test_a_name_that_leads_out_of_the_folder_is_refused_before_anything_is_written(name, tmp_path):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("record.json", "{}")
        archive.writestr("report/report.html", "<p>")
        archive.writestr(f"report/{name}", "crafted")
    with pytest.raises(VERIFICATION_ERRORS, match="no name of a file"):
        unpack_verification(stream.getvalue(), tmp_path / "below" / "copy")
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def told(monkeypatch):
    """Stand in for the engines: each has contents that a test may change."""
    contents = {"toy": {"files": ["a"]}, "other": {"files": ["b"]}}

    def fingerprint_of(engine, options):
        return contents[engine] and {**contents[engine], **options}

    monkeypatch.setattr(entries, "fingerprint_of", fingerprint_of)
    monkeypatch.setattr(entries, "chosen_options", lambda _, options: dict(options))
    return contents


def key(level="quick", **changes):
    return verification_key(level, **{"cases": ["one", "two"], "engine": "toy", **changes})


def test_everything_that_decides_the_verdicts_changes_the_key(told, monkeypatch):
    found = [
        key(),
        key("full"),
        key(cases=["one"]),
        key(engine="other"),
        key(program="/mine"),
        key(context={"baseline": "1"}),
    ]
    told["toy"] = {"files": ["another library"]}
    found.append(key())
    for fact in ("machine", "versions", "source_digest"):
        monkeypatch.setattr(entries, fact, lambda *_: {"other": "1"})
        found.append(key())
    assert None not in found
    assert len(set(found)) == len(found)


def test_an_engine_that_cannot_be_told_has_no_key(told):
    told["toy"] = None
    assert key() is None
