import json
import re
from pathlib import Path

import pytest

from harness.errors import RequestError
from harness.workflows import diff
from tests.published_run import RUN


@pytest.fixture
def written(tmp_path):
    """Return a function that writes results.json into a folder of its own."""

    def write(name="run", text=None, **changes):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "results.json").write_text(text or json.dumps(RUN | changes), encoding="utf-8")
        return folder

    return write


def test_a_run_is_a_folder_or_its_file(written):
    folder = written()
    assert diff(folder, folder / "results.json").status == 0
    assert diff(str(folder), folder).metadata == ()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('{"level": ', r"results\.json: is damaged, no JSON"),
        ("[" * 100_000, r"results\.json: is damaged, no JSON"),
        ("[]", r"results\.json: is not a run of dem-harness"),
        ('{"level": "quick"}', r"is not a run of dem-harness \(started: field required\)"),
        (json.dumps(RUN | {"schema": 1}), r"is of schema 1, this dem-harness reads 2"),
        (json.dumps(RUN | {"schema": "x"}), r"is of schema 'x', this dem-harness reads 2"),
        (json.dumps(RUN | {"checks": [{}]}), r"\(checks\.0\.name: field required\)"),
    ],
)
def test_what_is_no_run_is_refused_by_name(written, text, said):
    folder = written(text=text)
    with pytest.raises(RequestError, match=said) as caught:
        diff(folder, folder)
    assert str(caught.value).startswith(str(folder))
    assert "\n" not in str(caught.value)


def test_what_is_not_there_is_refused_by_name(tmp_path, written):
    with pytest.raises(RequestError, match=re.escape(f"{tmp_path}: is not a run: it holds no res")):
        diff(tmp_path, written())
    with pytest.raises(RequestError, match="nowhere: No such file"):
        diff(Path("nowhere"), tmp_path)


def test_a_file_that_is_no_text_is_refused(written):
    folder = written()
    (folder / "results.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(RequestError, match="no UTF-8 text"):
        diff(folder, folder)


def test_a_row_that_one_side_lacks_with_tolerance_0_is_told_and_no_error(written):
    row = {
        "name": "same script", "kind": "cross-code", "unit": "J", "value": 1.0, "expected": 1.0,
        "difference": 0.0, "uncertainty": 0.0, "tolerance": 0.0, "verdict": "pass",
    }  # fmt: skip
    found = diff(written(checks=[row]), written("quick", level="full"))
    assert found.status == 0
    assert found.to_json()["counts"]["not comparable"] == 1
