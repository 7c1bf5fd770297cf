"""pytest plugin: ``pytest --dem-harness`` makes each row of a verification a test.

``--dem-harness-options`` has the options of ``dem-harness verify``. The fixture
``dem_verification`` is the table of the rows. A session runs one verification at most.

pytest loads this module in every session of an environment that has it:
nothing but pytest and the standard library is imported here.
"""

from __future__ import annotations

import json
import shlex
import warnings
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    import pandas as pd

    from harness.cli.engine_options import EngineOptions
    from harness.cli.verify import VerifyOptions

OPTIONS = "--dem-harness-options"
REFUSED = ("--json", "--verbose", "--help", "-h", "--version")  # they change what is printed
LOG_CHARACTERS = 2000  # of the end of an engine's log, below a failure

Row = Mapping[str, Any]
RECORD = pytest.StashKey[dict[str, Any]]()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the flag and the options of the verification."""
    group = parser.getgroup("dem-harness", "verification of a DEM code (dem-harness)")
    text = "run a verification and make each of its rows a test"
    group.addoption("--dem-harness", action="store_true", help=text)
    text = 'options of dem-harness verify, as in "--quick --lmp build/lmp --cases contacts"'
    group.addoption(OPTIONS, metavar="TEXT", default="", help=text)


def pytest_configure(config: pytest.Config) -> None:
    """Declare the mark of the rows; raise UsageError for options that are wrong."""
    config.addinivalue_line("markers", "dem_harness: a row of a verification (--dem-harness)")
    if config.option.dem_harness and not hasattr(config, "workerinput"):
        verify_options(config)


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
    if not config.option.dem_harness:
        return
    parent = Verification.from_parent(session, name="dem-harness", nodeid="dem-harness")
    tests = parent.collect()
    items += tests
    # the terminal counts what is reported as collected
    report = pytest.CollectReport(parent.nodeid, "passed", None, [*tests])
    config.hook.pytest_collectreport(report=report)


@pytest.fixture(scope="session")
def dem_verification(request: pytest.FixtureRequest) -> pd.DataFrame:
    """Return the rows of the session's verification, with the columns of results.csv."""
    import pandas as pd

    try:
        record = session_record(request.config)
    except pytest.UsageError as error:
        pytest.fail(str(error), pytrace=False)
    if record["errors"]:
        pytest.fail("\n".join(record["errors"]), pytrace=False)
    return pd.DataFrame(record["rows"])


class Verification(pytest.Collector):
    """The verification of a session."""

    def collect(self) -> list[pytest.Item]:
        """Return a test for each row; one more where an engine failed or a case tested nothing."""
        if self.config.option.collectonly:  # the rows are known after a run only
            return [RowTest.from_parent(self, name="verification", row={}, record={})]
        record = session_record(self.config)
        rows = [(f"{row['kind']}: {row['name']}", row) for row in record["rows"]]
        if record["errors"]:
            rows.append(("engines", {"verdict": "error", "note": "\n".join(record["errors"])}))
        seen: Counter[str] = Counter()
        tests: list[pytest.Item] = []
        for name, row in rows:
            seen[name] += 1
            number = f" ({seen[name]})" if seen[name] > 1 else ""
            tests.append(RowTest.from_parent(self, name=name + number, row=row, record=record))
        return tests


class RowTest(pytest.Item):
    """A row as a test."""

    def __init__(self, *, row: Row, record: Mapping[str, Any], **rest: Any) -> None:
        super().__init__(**rest)
        self.row, self.record = row, record
        self.add_marker("dem_harness")

    def reportinfo(self) -> tuple[Path, int | None, str]:
        """Return a place, and the name: bare, pytest would write its dots as ``::``."""
        return self.config.rootpath / "dem-harness", None, f"dem-harness: {self.name}"

    def setup(self) -> None:
        """Fail where an engine failed: an error, beside the rows that it left."""
        if self.row["verdict"] == "error":
            pytest.fail(self.row["note"], pytrace=False)

    def runtest(self) -> None:
        """Pass, fail or skip by the verdict; a known defect is an expected failure."""
        verdict, note = self.row["verdict"], self.row["note"]
        self.user_properties.append(("kind", self.row["kind"]))
        text = row_text(self.row, Path(self.record["folder"]))
        if verdict == "fail" or (verdict == "not tested" and self.record["strict"]):
            pytest.fail(text, pytrace=False)
        self.add_report_section("call", "dem-harness", text)
        if verdict == "known defect":
            pytest.xfail(note)
        if verdict in ("not tested", "fixed"):
            pytest.skip(f"{verdict}: {note}")


def row_text(row: Row, folder: Path) -> str:
    """Return a row in words and numbers, a line each, and the end of its engine's log."""
    from harness.cli.verify import details

    lines = [f"{row['name']}: {row['verdict']}", *details(row, folder)]
    if row["why"]:
        lines.append(f"tolerance: {row['why']}")
    if row["log"]:
        log = (folder / "logs" / row["log"]).read_text(encoding="utf-8", errors="replace")
        lines.append(log[-LOG_CHARACTERS:].strip())
    return "\n".join(lines)


def session_record(config: pytest.Config) -> dict[str, Any]:
    """Return the verification of the session, run at the first call."""
    if RECORD not in config.stash:
        if not hasattr(config, "workerinput"):
            config.stash[RECORD] = verification_record(config)
        elif "dem_harness" in config.workerinput:
            config.stash[RECORD] = json.loads(config.workerinput["dem_harness"])
        else:
            raise pytest.UsageError("dem_verification: needs the flag --dem-harness under xdist")
    return config.stash[RECORD]


def verification_record(config: pytest.Config) -> dict[str, Any]:
    """Run a verification; return its rows, the errors of engines, the folder of its report.

    Raise UsageError for options that are wrong.
    """
    from harness.cli.files import output_folder
    from harness.cli.verify import verified
    from harness.errors import HarnessError, RequestError
    from harness.report.text import nothing_tested
    from harness.workflows.progress import progress_bars

    choice, engine = verify_options(config)
    temporary: pytest.TempPathFactory = config._tmp_path_factory  # type: ignore[attr-defined]
    named = choice.output or temporary.mktemp("dem-harness") / "report"
    shared = {"strict": choice.strict, "folder": str(named.absolute())}
    try:
        # a suite may turn warnings into errors: those of libraries below are not its own
        with (
            warnings.catch_warnings(action="ignore"),
            output_folder(named) as folder,
            progress_bars("verify") as progress,
        ):
            record = verified(choice, engine, folder, progress)
    except RequestError as error:
        text = config.option.dem_harness_options
        raise pytest.UsageError(f"{OPTIONS} {text!r}: {error}") from None
    except HarnessError as error:
        return {"rows": [], "errors": [f"dem-harness: {error}"], **shared}
    errors = [*record["engine_errors"]]
    if record["untested_cases"]:
        errors.append(nothing_tested(record["untested_cases"]))
    return {"rows": record["checks"], "errors": errors, **shared}


def verify_options(config: pytest.Config) -> tuple[VerifyOptions, EngineOptions]:
    """Return the options of ``dem-harness verify``; raise UsageError for what it refuses."""
    from cyclopts import CycloptsError

    from harness.cli.command import app, usage_message
    from harness.cli.verify import check_request

    text: str = config.option.dem_harness_options
    try:
        words = shlex.split(text)
        for word in words:
            if word.partition("=")[0] in REFUSED:
                raise ValueError(f"{word}: goes with the command dem-harness verify only")
        _, bound, _ = app.parse_args(["verify", *words], exit_on_error=False, print_error=False)
        bound.apply_defaults()
        choice, engine = bound.arguments["choice"], bound.arguments["engine"]
        check_request(choice, engine)
    except (CycloptsError, ValueError) as error:
        reason = usage_message(error) if isinstance(error, CycloptsError) else error
        raise pytest.UsageError(f"{OPTIONS} {text!r}: {reason}") from None
    return choice, engine
