"""What the tests of all cases share: rows in an engine, made-up outputs, refusals."""

import pytest

from harness.cases.bench import Bench
from harness.cases.checks import run_checks, selected
from harness.engines.output import SERIES, Output, Provenance
from harness.errors import RequestError


def rows_of(case, engine, level="quick", only="*"):
    """Return the rows of the checks of a case in an engine."""
    checks = selected(case.name, case.checks_up_to(engine, level), level, only)
    return run_checks(case.name, checks, Bench(engine))


def verdicts(rows):
    return {row.verdict for row in rows}


def made(results, table=None, **more):
    """Return an output with these results, pairs or by name, and this series."""
    pairs = results.items() if isinstance(results, dict) else results
    texts = tuple((name, str(value)) for name, value in pairs)
    tables = {} if table is None else {SERIES: table}
    return Output(texts, Provenance("fake", "1"), tables, **more)


def assert_refused(words, function, *arguments, **values):
    """Assert that a call is refused in one line that matches these words."""
    with pytest.raises(RequestError, match=words) as error:
        function(*arguments, **values)
    assert "\n" not in str(error.value)
