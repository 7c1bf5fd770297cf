"""Runs side by side: stored ones, accepted ones, releases; and known defects by name."""

import json
from dataclasses import replace

import pytest

from harness.engines import registry as engines
from harness.errors import EngineMissingError, RequestError
from harness.results.compare import Change
from harness.results.rows import not_tested, table
from harness.store.committed import accepted_rows
from harness.store.runs import NUMBERS, Meta, Run, write_run
from harness.workflows import accept, defects, diff, releases
from harness.workflows.comparisons import values_of
from tests.results.rows import row, rows
from tests.workflows import doubles
from tests.workflows.doubles import K

META = Meta(level="quick", cases=("incline",), engines={"code": "1"}, started="2026-01-01",
            platform="Linux", harness_version="2.0")  # fmt: skip
ALIVE = ("flight", None)


@pytest.fixture
def runs(tmp_path):
    """Write three runs: the second is worse and of another version, the third moved back."""
    meta = META.replace(engines={"code": "2"}, started="2026-01-02")
    three = {
        "a": Run(rows(ALIVE), META, scripts={"code/in": "run 1"}),
        "b": Run(rows(ALIVE, ("angle", row(value=10.5))), meta, scripts={"code/in": "run 2"}),
        "c": Run(rows(ALIVE, ("sink", row("sink"))), meta, scripts={"code/in": "run 2"}),
    }
    for name, run in three.items():
        write_run(run, tmp_path / name)
    return [tmp_path / name for name in three]


def test_two_runs(runs):
    first, second, third = runs
    found = diff(first, second)
    assert found.status == 1
    assert found.to_frame()[["quantity", "change"]].values.tolist() == [["angle", "worse"]]
    assert found.to_frame()["moved_by"].tolist() == [0.5]
    facts = {fact["name"]: fact["after"] for fact in found.facts["metadata"]}
    assert facts["engine code"] == "2"
    assert diff(second, third).status == 0
    assert diff(second, third).facts["counts"] == {"better": 1, "new": 1, "same": 6}
    assert json.dumps(found.to_json(), allow_nan=False)


def test_a_trend_of_three_runs(runs):
    found = diff(*runs)
    assert found.status == 0
    assert found.changes["change"].tolist() == [Change.WORSE, Change.BETTER, Change.NEW]
    assert set(found.changes["run_before"]) == {str(runs[0]), str(runs[1])}
    trend = values_of(*runs).reset_index().set_index("quantity")
    assert trend.loc["angle", [str(run) for run in runs]].tolist() == [10.0, 10.5, 10.0]
    assert len(found.summary()) >= 2


def test_rows_of_an_engine_that_could_not_be_run_are_not_worse_and_stay_accepted(tmp_path):
    two = META.replace(engines={"code": "1", "other": "1"})
    accepted = [row("angle"), row("shock", check="over other"), row("sink", engine="other")]
    accept(Run(table(accepted), two), tmp_path)
    untested = not_tested(row("", setup="", engine="other", version=""), "other is missing")
    lacking = Run(table([row("angle"), untested]), META.replace(engines={"code": "1", "other": ""}))
    found = diff(lacking, "accepted", accepted=tmp_path)
    assert (found.status, found.facts["counts"]) == (1, {"same": 1, "not comparable": 1})
    compared = lacking.against(accepted_rows(two.engines, tmp_path))
    assert (compared.status, compared.regressions.empty) == (3, True)
    assert compared.headline == "All verdicts hold; other could not be run; 1 not tested"
    accept(lacking, str(tmp_path))
    assert len(accepted_rows(two.engines, tmp_path)) == 3


def test_a_run_and_the_accepted_one(runs, tmp_path):
    folder = tmp_path / "accepted"
    with pytest.raises(RequestError, match="has no accepted run of code"):
        diff(runs[0], "accepted", accepted=folder)
    accepted = accept(runs[0], folder)
    assert len(accepted.facts["files"]) == 1
    assert accepted.to_json()["counts"] == {"worse": 1, "new": 5, "not comparable": 1}
    assert diff(runs[0], "accepted", accepted=folder).status == 0
    for order in ((runs[1], "accepted"), ("accepted", runs[1])):
        found = diff(*order, accepted=folder)
        assert found.status == 1
        assert found.changes["value_before"].tolist() == [10.0]
    again = accept(runs[0], folder)
    assert again.facts["files"] == []
    assert again.to_json()["counts"] == {"same": 6, "not comparable": 1}


def test_a_value_that_moved_fails_against_the_accepted_run_alone(tmp_path):
    first = Run(rows(ALIVE), META)
    other = Run(rows(ALIVE, ("shock", row("shock", 10.2))), META)
    accept(first, tmp_path)
    assert diff(other, "accepted", accepted=tmp_path).status == 1
    found = diff(first, other)
    assert (found.status, found.facts["counts"]["moved"]) == (0, 1)
    assert found.facts["runs"] == ["2026-01-01 (1)", "2026-01-01 (2)"]


@pytest.mark.parametrize("request_", [(), ("a",), ("a", "b", "accepted"), ("accepted",) * 2])
def test_requests_that_cannot_be_met_are_refused(request_):
    with pytest.raises(RequestError, match="diff:"):
        diff(*request_)


def test_known_defects_by_name():
    every = defects()
    assert len(every) > 40
    (record,) = defects("tsuji-restitution")
    assert record["until"] == "22 Jul 2025"
    assert record["effect"] == "faults.tsuji_effective_mass" or "tsuji" in record["effect"]
    assert "expected" in record["script"]


# ---- releases


class Released(doubles.Good):
    """As the reference; release ``soft`` has another stiffness, ``gone`` cannot be installed."""

    name = "released"
    number, stiffness = "1", K

    @classmethod
    def check_release(cls, name):
        if name not in ("right", "same", "soft", "gone"):
            raise RequestError(f"release {name!r}: is not one")

    @classmethod
    def release(cls, name, _=None):
        if name == "gone":
            raise EngineMissingError("release gone: cannot be installed")
        made = cls()
        made.number, made.stiffness = name, K * (0.9 if name == "soft" else 1.0)
        return made

    def identify(self):
        return replace(super().identify(), engine="released", engine_version=self.number)

    def fingerprint(self):
        return None

    def scene_of(self, job):
        return job.scene.replace(law=job.scene.law.replace(normal_stiffness=self.stiffness))


@pytest.fixture(autouse=True)
def _released(registered, monkeypatch):  # noqa: ARG001
    places = {**engines.ENGINES, "released": f"{__name__}:Released"}
    monkeypatch.setattr(engines, "ENGINES", places)


def compared(*names, **options):
    return releases(names, engine="released", cases="bounce", **options)


def test_a_release_with_the_same_values_and_one_that_is_off(tmp_path):
    found = compared("right", "same")
    assert (found.status, found.facts["cells"]) == (0, [])
    right, same = found.facts["releases"]
    assert same["counts"] == {"same": sum(right["counts"].values())}
    found = compared("right", "soft", output=tmp_path / "out")
    assert (found.facts["reference"], found.status) == ("right", 1)
    assert {cell["soft"] for cell in found.facts["cells"]} == {"fail"}
    frame = found.to_frame()
    assert {"reference", "worse"} <= set(frame["change"])
    assert set(NUMBERS) <= set(frame)
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"report.md", "rows.csv"}


def test_a_release_that_cannot_be_installed_is_shown_and_no_reference():
    found = compared("gone", "right")
    assert (found.facts["reference"], found.status) == ("right", 3)
    assert found.to_json()["releases"][0]["version"] == ""


@pytest.mark.parametrize(
    ("names", "words"),
    [((), "at least one"), (("right", "right"), "named twice"), (("other",), "is not one")],
)
def test_names_that_are_refused(names, words):
    with pytest.raises(RequestError, match=words):
        compared(*names)
    with pytest.raises(RequestError, match="has no releases"):
        releases(["1"], engine="good")
