"""The words of a case: ``case.toml`` beside its module, its quantities and formula."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path
from typing import Any


def text_of(case: type) -> dict[str, Any]:
    """Return what stands in the file beside a case's module; {} where there is none."""
    file = Path(getattr(sys.modules[case.__module__], "__file__", None) or "").with_name(
        "case.toml"
    )
    return tomllib.loads(file.read_text("utf-8")) if file.is_file() else {}
