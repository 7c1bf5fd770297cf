import json
import sys

import pytest

from harness.cli import main


@pytest.fixture
def harness(tmp_path, commands):
    """Run the command line in a process of its own, in an empty folder.

    A first one in a new home waits for kernels to be compiled.
    """

    def run(*arguments, status=0, timeout=400):
        done = commands.run(arguments, tmp_path, timeout)
        assert done.returncode == status, done.stderr
        assert "Traceback" not in done.stderr
        return done

    return run


@pytest.fixture
def answer(harness):
    """Run a command with --json and return its object: nothing else is on stdout."""

    def run(*arguments, status=0, timeout=400):
        return json.loads(harness(*arguments, "--json", status=status, timeout=timeout).stdout)

    return run


@pytest.fixture
def command(monkeypatch, capsys, tmp_path):
    """Run a command in this process, where a test has changed something."""
    monkeypatch.chdir(tmp_path)

    def run(*words, status=0):
        monkeypatch.setattr(sys, "argv", ["dem-harness", *words])
        with pytest.raises(SystemExit) as left:
            main()
        said = capsys.readouterr()
        assert (left.value.code or 0) == status, said.err
        return said

    return run
