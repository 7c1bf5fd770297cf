import json

import jsonschema
import pytest

from harness.comparison.verification import read_published
from harness.report.folder import committed_schema, generated_schema
from harness.report.plain import finite


@pytest.fixture
def record(verification):
    return json.loads(json.dumps(finite(verification.to_json())))


def test_the_published_schema_is_what_would_be_written():
    assert committed_schema() == generated_schema(), "run: python -m harness.report.folder"


def test_a_run_is_valid_and_reads_back(verification, record):
    jsonschema.Draft202012Validator(json.loads(committed_schema())).validate(record)
    read = read_published(record)
    assert [row.name for row in read.checks] == [check.name for check in verification.checks]
    assert read.headlines == verification.headlines


def test_every_key_of_a_run_is_in_the_schema(record):
    schema = json.loads(committed_schema())
    # beside them stand the keys that cases publish
    assert set(record) - set(schema["properties"]) == {"slope_rows"}
    assert set(record["checks"][0]) <= set(schema["$defs"]["Check"]["properties"])


@pytest.mark.parametrize(
    ("key", "value"),
    [("schema", "two"), ("checks", {}), ("status", "fine"), ("headlines", [{"name": "x"}])],
)
def test_a_record_that_is_no_run_is_not_valid(record, key, value):
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(record | {key: value}, json.loads(committed_schema()))


def test_a_check_without_a_verdict_is_not_valid(record):
    del record["checks"][0]["verdict"]
    with pytest.raises(jsonschema.ValidationError, match="verdict"):
        jsonschema.validate(record, json.loads(committed_schema()))
