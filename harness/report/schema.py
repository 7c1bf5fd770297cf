"""The JSON Schema of results.json; ``python -m harness.report.schema`` writes it anew."""

from __future__ import annotations

import json
from importlib import resources
from pathlib import Path

from harness.comparison.verification import SCHEMA, json_schema

NAME = "results.schema.json"


def published() -> str:
    """Return the committed schema, which lies beside results.json in every report."""
    return resources.files("harness.report").joinpath(NAME).read_text(encoding="utf-8")


def generated() -> str:
    """Return the schema as the dataclasses of :mod:`harness.comparison.verification` give it."""
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": f"urn:dem-harness:results:{SCHEMA}",
        **json_schema(),
    }
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    Path(__file__).with_name(NAME).write_text(generated(), encoding="utf-8")
