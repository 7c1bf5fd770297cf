"""Progress: reported to a function, and in a log line by line."""

import pytest

from harness import workflows
from harness.cases.incline.system import Incline
from harness.engines.reference import Reference
from harness.engines.registry import open_engine
from harness.parameters.tower import Tower
from harness.workflows import progress as module


def stages(verb):
    told = []
    verb(lambda *one: told.append(one))
    assert told
    for stage in {one[0] for one in told}:
        done = [one[1:] for one in told if one[0] == stage]
        assert [d for d, _ in done] == sorted(d for d, _ in done)
        assert all(0 <= d <= total for d, total in done)
    return told


def test_verbs_tell_how_far_they_are():
    assert stages(lambda told: workflows.tower(Tower(height=2), progress=told))
    table = {"heights": (2, 3), "stiffnesses": (1e6,), "speeds": (2.0,)}
    assert stages(lambda told: workflows.impulse_angles(progress=told, **table))[-1] == (
        "towers", 6, 6,
    )  # fmt: skip
    with Reference() as engine:
        found = stages(
            lambda told: workflows.critical_angle(
                Incline(stiffness=1e5), engine=engine, progress=told
            )
        )
        assert found[0][:2] == ("runs, passage", 0)
        assert stages(lambda told: workflows.run("drop", engine=engine, progress=told))
    assert stages(lambda told: workflows.engines(programs={}, progress=told))[-1][0] == "engines"


def test_a_log_says_which_stages_are_over_and_how_far_others_are(monkeypatch, capsys):
    now = [0.0]
    monkeypatch.setattr(module.time, "monotonic", lambda: now[0])
    with module.progress_bars("verify") as told:
        told("drop", 1, 1)  # over at once: no line
        for seconds, done in ((1.0, 0), (10.0, 1), (20.0, 2), (45.0, 3), (50.0, 4), (51.0, 4)):
            now[0] = seconds
            told("oblique", done, 4)
    assert capsys.readouterr().err.splitlines() == [
        "verify: oblique, 3 of 4, 45 s",
        "verify: oblique, 4 of 4, 50 s",
    ]
    with module.progress_bars("verify", quiet=True) as told:
        now[0] = 1000.0
        told("oblique", 4, 4)
    assert capsys.readouterr().err == ""


@pytest.mark.usefixtures("registered")
def test_a_verification_says_which_case_is_over():
    told = []
    workflows.verify(
        "quick", cases="line", engine=open_engine("toy"), baseline=False,
        progress=lambda *one: told.append(one),
    )  # fmt: skip
    for stage in ("line, toy", "line, own solvers"):
        assert [one[1:] for one in told if one[0] == stage] == [(0, 1), (1, 1)]
