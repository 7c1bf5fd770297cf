import json
import sys

import pytest

from harness.cli import main
from tests.workflows.conftest import registered  # noqa: F401


@pytest.fixture
def command(monkeypatch, capsys, tmp_path):
    """Run a command in this process, in an empty folder."""
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
def harness(registered, command):  # noqa: ARG001, F811
    """Run a command likewise, with the doubles as cases and engines."""
    return command


@pytest.fixture
def answer(harness):
    """Run a command with --json and return its object: nothing else is on stdout."""
    return lambda *words, status=0: json.loads(harness(*words, "--json", status=status).out)
