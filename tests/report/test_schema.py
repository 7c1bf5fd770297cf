import json

import jsonschema
import pytest

from harness.comparison.results import Results
from harness.report.finite import finite
from harness.report.schema import generated, published


@pytest.fixture
def record(verification):
    return json.loads(json.dumps(finite(verification.record())))


def test_the_published_schema_is_what_would_be_written():
    assert published() == generated(), "run: python -m harness.report.schema"


def test_a_run_is_valid_and_reads_back(verification, record):
    jsonschema.Draft202012Validator(json.loads(published())).validate(record)
    read = Results.model_validate(record)
    assert [row.name for row in read.checks] == [check.name for check in verification.checks]
    assert read.extrapolated.critical_angle_deg == verification.incline.extrapolated.value_deg


def test_every_key_of_a_run_is_in_the_schema(record):
    schema = json.loads(published())
    assert set(record) <= set(schema["properties"])
    assert set(record["checks"][0]) <= set(schema["$defs"]["CheckRow"]["properties"])


@pytest.mark.parametrize(
    ("key", "value"),
    [("schema", 2), ("checks", {}), ("status", "fine"), ("closed_form_deg", "10.2")],
)
def test_a_record_that_is_no_run_is_not_valid(record, key, value):
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(record | {key: value}, json.loads(published()))


def test_a_check_without_a_verdict_is_not_valid(record):
    del record["checks"][0]["verdict"]
    with pytest.raises(jsonschema.ValidationError, match="verdict"):
        jsonschema.validate(record, json.loads(published()))
