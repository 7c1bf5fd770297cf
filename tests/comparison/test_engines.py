import pytest

from harness.comparison.verification import DeclaredEngine
from harness.shown import adapter, to_json


@pytest.mark.parametrize(
    ("changes", "summary"),
    [
        ({}, "qualified"),
        ({"missing": "not installed"}, "missing"),
        ({"unqualified": "free fall"}, "did not qualify"),
    ],
)
def test_whether_an_engine_was_used_is_said_and_to_json(changes, summary):
    declared = DeclaredEngine(
        "yade", "1", "executable", "apt install yade", ("1",), "velocity-verlet", ("clipped",),
        ("full",), 15, "", (), **changes,
    )  # fmt: skip
    assert declared.summary == summary
    record = to_json(declared)
    assert record["summary"] == summary
    assert adapter(DeclaredEngine).validate_python(record) == declared
