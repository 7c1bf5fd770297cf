"""pytest plugin: ``pytest --dem-harness`` makes each row of a verification a test.

``--dem-harness-options`` has the options of ``dem-harness verify``; the fixture
``dem_verification`` is the table of the rows. A session runs one verification at most. pytest loads
this module in every session of its environment: it imports nothing but pytest and the standard
library before a verification.
"""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    import pandas as pd

OPTIONS = "--dem-harness-options"
USAGE, DIED = 2, 3  # exit status of a wrong request, and where an engine failed
LOG_CHARACTERS = 2000  # of the end of an engine's log, below a failure
RECORD = pytest.StashKey[dict[str, Any]]()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the flag and the options of the verification."""
    group = parser.getgroup("dem-harness", "verification of a DEM code (dem-harness)")
    text = "run a verification and make each of its rows a test"
    group.addoption("--dem-harness", action="store_true", help=text)
    text = 'options of dem-harness verify, as in "--quick --lmp build/lmp --cases contacts"'
    group.addoption(OPTIONS, metavar="TEXT", default="", help=text)


def pytest_configure(config: pytest.Config) -> None:
    """Declare the mark of the rows."""
    config.addinivalue_line("markers", "dem_harness: a row of a verification (--dem-harness)")


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Pass the verification to a worker of xdist."""
    if node.config.option.dem_harness:
        node.workerinput["dem_harness"] = json.dumps(session_record(node.config))


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(
    session: pytest.Session, config: pytest.Config, items: list[pytest.Item]
) -> None:
    """Add the rows, before -k, -m and others choose among the items."""
    if config.option.dem_harness:
        tests = [
            RowTest.from_parent(session, name=name, nodeid=f"dem-harness::{name}", row=row)
            for name, row in _named_rows(config)
        ]
        items += tests
        report = pytest.CollectReport("dem-harness", "passed", None, [*tests])
        config.hook.pytest_collectreport(report=report)  # the terminal counts what it reports


@pytest.fixture(scope="session")
def dem_verification(request: pytest.FixtureRequest) -> pd.DataFrame:
    """Return the rows of the session's verification, with the columns of rows.csv."""
    import pandas as pd

    record = session_record(request.config)
    if "error" in record:
        pytest.fail(record["error"], pytrace=False)
    return pd.DataFrame(record["rows"])


class RowTest(pytest.Item):
    """A row as a test."""

    def __init__(self, *, row: Mapping[str, Any], **rest: Any) -> None:
        super().__init__(**rest)
        self.row = row
        self.add_marker("dem_harness")

    def reportinfo(self) -> tuple[Path, int | None, str]:
        """Return a place, and the name: bare, pytest would write its dots as ``::``."""
        return self.config.rootpath / "dem-harness", None, f"dem-harness: {self.name}"

    def setup(self) -> None:
        """Fail where an engine or the whole run failed: an error, separate from the rows."""
        if "error" in self.row:
            pytest.fail(self.row["error"], pytrace=False)

    def runtest(self) -> None:
        """Pass, fail or skip by the verdict; a known defect is an expected failure."""
        from harness.cli.output import name_of, row_details

        row, verdict, note = self.row, self.row["verdict"], self.row["note"]
        self.user_properties.append(("kind", row["kind"]))
        reason = f"tolerance: {row['reason']}" if row["reason"] else ""
        lines = [f"{name_of(row)}: {verdict}", *row_details(row), reason]
        text = "\n".join(filter(None, [*lines, row["log"][-LOG_CHARACTERS:].strip()]))
        failing = ["fail", "not tested"] if session_record(self.config)["strict"] else ["fail"]
        if verdict in failing:
            pytest.fail(text, pytrace=False)
        self.add_report_section("call", "dem-harness", text)
        if verdict == "known defect":
            pytest.xfail(note)
        if verdict in ("not tested", "fixed"):
            pytest.skip(f"{verdict}: {note}")


def _named_rows(config: pytest.Config) -> list[tuple[str, Mapping[str, Any]]]:
    """Return the rows; one more where an engine failed or a case tested nothing.

    Likewise where the run fails against the accepted one, of which no row need fail.
    """
    from harness.cli.output import name_of

    if config.option.collectonly:  # the rows are known after a run only
        return [("verification", {})]
    record = session_record(config)
    rows = [(f"{row['kind']}: {name_of(row)}", row) for row in record["rows"]]
    moved = record["headline"] if record.get("regressions") else None
    errors = {"engines": record.get("error"), "accepted run": moved}
    return rows + [(name, {"error": text}) for name, text in errors.items() if text]


def session_record(config: pytest.Config) -> dict[str, Any]:
    """Return the verification of the session, run at the first call.

    It has an ``error`` where an engine failed.
    """
    if RECORD not in config.stash:
        inherited = getattr(config, "workerinput", {}).get("dem_harness")
        if inherited is None and hasattr(config, "workerinput"):
            return {"rows": [], "error": "dem_verification: needs --dem-harness under xdist"}
        config.stash[RECORD] = json.loads(inherited) if inherited else _run(config)
    return config.stash[RECORD]


def _run(config: pytest.Config) -> dict[str, Any]:
    """Return the record of a verification; raise UsageError where the options are wrong."""
    text = config.option.dem_harness_options
    temporary: pytest.TempPathFactory = config._tmp_path_factory  # type: ignore[attr-defined]
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise pytest.UsageError(f"{OPTIONS} {text!r}: {error}") from None
    if not any(word.partition("=")[0] == "--output" for word in words):
        words += ["--output", str(temporary.mktemp("dem-harness") / "report")]
    record = verification(words)
    if "rows" not in record and record["status"] == USAGE:
        raise pytest.UsageError(f"{OPTIONS} {text!r}: {record['error']}")
    if record["status"] >= DIED:
        record = {"rows": [], "strict": False, "error": record.get("headline")} | record
    return record


def verification(words: Sequence[str]) -> dict[str, Any]:
    """Return the JSON of ``dem-harness verify``, run in a process of its own."""
    # the paths of the suite, of its conftest and of pythonpath=, may have its engines
    places = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-m", "harness", "verify", *words, "--json"]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False, env=places)
    try:
        record: dict[str, Any] = json.loads(done.stdout)
    except ValueError:  # of --help, and of a process that died
        status = USAGE if done.returncode in (0, USAGE) else DIED
        record = {"error": f"dem-harness verify ended with {done.returncode}", "status": status}
    return record
