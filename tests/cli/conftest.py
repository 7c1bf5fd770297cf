import json

import pytest


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
