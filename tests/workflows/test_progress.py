"""Progress in a log: each stage ends in one line, also one of a single part."""

from harness.workflows import progress


def test_a_long_stage_is_logged_once_when_it_ends(monkeypatch, capsys):
    now = iter((0.0, 60.0, 61.0, 62.0, 100.0))
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(now))
    update = progress.log_lines("verify")
    update("solvers", 1, 1)
    update("lammps", 1, 3)
    update("lammps", 1, 3)
    update("lammps", 3, 3)
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(",")[0] for line in lines] == ["verify: solvers", "verify: lammps"]
