"""Every command fits 80 and 160 columns, and a pipe gets whole lines."""

import sys

import pytest

from harness import workflows
from harness.cli import main
from harness.cli.command import app
from harness.cli.files import print_columns
from harness.engines import registry
from harness.report.plain import printable
from tests.cli.test_terminal_layout import EXAMPLE, WIDTHS
from tests.workflows.test_static_site import run_folder

LINES = {
    "theory": "theory --restitution 0.5",
    "critical-angle": "critical-angle --engine reference --stiffness 1e5",
    "tower": "tower --height 4",
    "impulse": "impulse --heights 1-3 --window all",
    "cases": "cases",
    "defect": "defect",
    "run": "run incline --engine reference",
    "sweep": "sweep incline --over angle=9:11:3 --engines reference --output swept",
    "engines": f"engines --program mfix={sys.executable}",
    "diff": f"diff {EXAMPLE} {EXAMPLE}",
    "history": "history",
    "history of quantities": "history --quantity *",
    "cache": "cache",
    "inputs": "inputs --folder scripts",
    "site": "site run --output public",
}
"""By command; what `verify` prints, and `baseline compare` as it does, is in
test_terminal_layout.py."""

ELSEWHERE = {"verify", "reproduce", "study", "releases", "upstream"}
"""Commands that take minutes: what they print is in test_long_commands.py; upstream has a test of
its own, with a file to run."""


@pytest.fixture
def shown(monkeypatch, tmp_path, capsys):
    """Run all lines in a terminal; return what each printed."""

    def run(columns):
        monkeypatch.chdir(tmp_path)
        monkeypatch.setenv("COLUMNS", str(columns))
        project = tmp_path / f"project-{columns}"
        project.mkdir()
        build = workflows.site  # of the run alone: all committed reports take seconds
        monkeypatch.setattr(
            workflows, "site", lambda *a, **more: build(*a, **more, project=project)
        )
        run_folder(tmp_path / "run", 10.2, 1)
        for name in ("liggghts", "yade", "kratos", "esys"):  # seconds to look for
            monkeypatch.delitem(registry.ENGINES, name)
        monkeypatch.setattr("sys.stdout.isatty", lambda: True)
        found = {}
        for name, words in LINES.items():
            monkeypatch.setattr(sys, "argv", ["dem-harness", *words.split()])
            with pytest.raises(SystemExit) as left:
                main()
            found[name] = printable(capsys.readouterr().out)  # without colours
            assert (name, left.value.code or 0) == (name, 0)
        return found

    return run


@pytest.mark.parametrize("columns", WIDTHS)
def test_every_command_fits(shown, columns):
    found = shown(columns)
    widest = {name: max(map(len, out.splitlines())) for name, out in found.items()}
    assert {name: width for name, width in widest.items() if not 10 < width <= columns} == {}
    # nothing is cut: an angle for each run, a word in full
    angles = found["impulse"].count("10.208")
    assert angles == 6 * 2 * 3, found["impulse"]
    # an ellipsis stands for what is cut; the list of runs cuts long command lines, JSON has them
    assert "…" not in "".join(out for name, out in found.items() if name != "history")


def test_every_command_is_looked_at():
    names = {name for name in app.resolved_commands() if not name.startswith("-")}
    assert names - {"baseline"} == {line.split()[0] for line in LINES} | ELSEWHERE


LONG = [("name", "what", "n"), ("one", "word " * 30, "1"), ("two", "x" * 100, "20")]


def test_columns_fold_on_a_terminal_and_not_in_a_pipe(monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "60")
    print_columns(LONG, right={"n"})
    piped = capsys.readouterr().out.splitlines()
    assert len(piped) == 3
    assert piped[1].split() == ["one", *["word"] * 30, "1"]
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    print_columns(LONG, right={"n"})
    folded = capsys.readouterr().out
    assert max(map(len, folded.splitlines())) <= 60
    for text in ("word", "x"):
        assert folded.count(text) == piped[1].count(text) + piped[2].count(text)
    print_columns([("a", "b")])
    assert capsys.readouterr().out == "a  b\n"
