import json
import sys

import pytest

from harness.cli import main
from tests.workflows.conftest import registered  # noqa: F401


@pytest.fixture
def harness(registered, monkeypatch, capsys, tmp_path):  # noqa: ARG001, F811
    """Run a command in this process, in an empty folder, with the doubles as engines."""
    monkeypatch.chdir(tmp_path)

    def run(*words, status=0):
        monkeypatch.setattr(sys, "argv", ["dem-harness", *map(str, words)])
        with pytest.raises(SystemExit) as left:
            main()
        said = capsys.readouterr()
        assert (left.value.code or 0) == status, said.err
        assert "Traceback" not in said.err
        return said

    return run


@pytest.fixture
def answer(harness):
    """Run a command with --json and return its object: nothing else is on stdout."""
    return lambda *words, status=0: json.loads(harness(*words, "--json", status=status).out)
