"""A study is run as sweeps are, by a workflow that knows no case, and written as a folder."""

import json
from html import unescape

import pandas as pd
import pytest

from harness.cases.contract import Measured
from harness.cases.layers.extents import EXTENTS, START, BoxExtent, Extent
from harness.cases.layers.study import LayersStudy
from harness.cases.layers.system import Layers
from harness.engines.registry import chosen_options
from harness.errors import EngineMissingError, EngineOutputError, RequestError
from harness.observables.provenance import Provenance
from harness.report.folder import Page, write_study
from harness.store import cache
from harness.workflows.study_run import RUN_SECONDS, study
from harness.workflows.sweep_run import as_frame


def angle(one):
    """Return an angle that falls with the thickness and knows nothing of softness."""
    return 6.0 + 6.0 / one.layers + 0.01 * one.seed


def executor_of(ranks):
    """Return what makes every run at once; of the grain with seed 2 nothing is decided."""
    if ranks > 1:
        raise EngineMissingError("no launcher here")

    def run(work):
        for place, one in enumerate(work.parameters):
            values = {"stop_angle_deg": angle(one)}
            if one.rise:
                values["start_angle_deg"] = angle(one) + 1.0
            undecided = EngineOutputError("undecided: it never stopped")
            bad = one.seed == 2 and one.layers == 2
            yield place, undecided if bad else Measured(values, Provenance("fake", "1"), 2.0)

    return run


@pytest.fixture(scope="module")
def found():
    return study("layers", "default", executor_of=executor_of)


def test_every_run_is_a_row_and_failed_ones_say_why(found):
    runs = as_frame(found.runs)
    bad = runs[runs["status"] == "failed"]
    expected = [
        one for arm in LayersStudy().arms("default") if arm.ranks == 1
        for one in arm.parameters if isinstance(one, Layers) and (one.seed, one.layers) == (2, 2)
    ]  # fmt: skip
    assert len(bad) == found.count("failed") == found.to_json()["failed"] == len(expected)
    assert set(bad["reason"]) == {"undecided: it never stopped"}
    assert set(bad["stiffness_over_weight"]) == {300.0, 3e4}
    good = runs[runs["status"] == "done"]
    assert good["stop_angle_deg"].between(6.0, 13.0).all()


def test_ranks_that_cannot_be_started_leave_their_arm_out(found):
    left_out = {arm.name for arm in LayersStudy().arms("default") if arm.ranks == 2}
    assert len(left_out) >= 3
    assert found.missing == dict.fromkeys(left_out, "no launcher here")
    assert not left_out & {row["arm"] for row in found.runs}
    assert f"Not run: {'; '.join(found.missing)}." in found.conclusion.verdict


def test_the_result_shows_itself(found):
    assert "does not depend on softness" in str(found)
    assert found.to_frame()["arm"].iloc[0] == "thickness"
    assert found.plot().axes


def test_a_run_in_python_may_take_as_long_as_on_the_command_line(monkeypatch):
    asked = []

    def none(name, *, options):
        asked.append(chosen_options(name, options=options)["limits"].seconds)
        raise EngineMissingError("not here")

    monkeypatch.setattr(cache, "open_engine", none)
    with pytest.raises(EngineMissingError, match="not here"):
        study("layers", "quick")
    assert asked == [RUN_SECONDS]


def test_one_rank_that_cannot_be_started_ends_it():
    def none(ranks):
        raise EngineMissingError(f"nothing here, {ranks}")

    with pytest.raises(EngineMissingError, match="nothing here, 1"):
        study("layers", "quick", executor_of=none)


def test_a_case_without_a_study_is_refused():
    with pytest.raises(RequestError, match="'incline' has no study: must be one of layers"):
        study("incline")


def test_the_folder_has_page_rows_and_figures_and_is_not_written_over(found, tmp_path):
    page = Page(found.title, found.question, found.conclusion.verdict, {"command": "study it"})
    tables = {"rows.csv": found.to_frame(), "runs.csv": as_frame(found.runs)}
    folder = tmp_path / "mine"
    write_study(page, found.conclusion.sections, found.to_json(), tables, folder)
    text = (folder / "report.md").read_text()
    html = unescape((folder / "report.html").read_text())
    for sentence in found.conclusion.verdict:
        assert sentence in html
    assert "One test judges every difference" in text
    assert "- command: study it" in text
    figures = sorted((folder / "figures").glob("*.svg"))
    assert [figure.stem for figure in figures] == ["angle-over-box", "angle-over-thickness"]
    assert all(f"figures/{figure.name}" in text for figure in figures)
    record = json.loads((folder / "study.json").read_text())
    rows = pd.read_csv(folder / "rows.csv")
    assert len(rows) == len(record["rows"]) == len(found.conclusion.rows)
    assert len(pd.read_csv(folder / "runs.csv")) == len(found.runs)
    with pytest.raises(RequestError, match="holds something already"):
        write_study(page, (), {}, {}, folder)


@pytest.mark.live
@pytest.mark.slow
def test_in_lammps_every_arm_of_a_tiny_study_has_angles(monkeypatch, lammps_here):  # noqa: ARG001
    tiny = {h: BoxExtent(6, 3, 20.0, 2) for h in (1, 2)}
    monkeypatch.setitem(EXTENTS, "quick", Extent(tiny, (100.0, 300.0), tiny[1], (0.5,), (START,)))
    found = study("layers", "quick")
    assert found.count("done") == len(found.runs) == 4 * 2 + 3 * 2 + 2
    arms = {row["arm"]: row for row in found.conclusion.rows}
    # a rest does not flow at the angle at which it came to rest
    assert arms["raised again"]["start_angle_deg"] > arms["raised again"]["stop_angle_deg"]
    single = arms["single grain"]
    below = 10.2078 - single["stop_angle_deg"]
    # the weight presses 1e-4 d into the row at 1e4 weights, 0.006 deg
    assert 0.0 < below < single["uncertainty_deg"] + 0.006
