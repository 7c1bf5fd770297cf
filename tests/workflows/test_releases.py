"""Releases of an engine: what moves, what fails, what a release cannot run."""

import json
from dataclasses import replace

import pytest

from harness.engines import registry as engines
from harness.errors import EngineMissingError, RequestError
from harness.store.runs import NUMBERS
from harness.workflows import releases
from tests.workflows import doubles
from tests.workflows.doubles import K


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


def test_a_release_with_the_same_values_and_one_that_moved():
    found = compared("right", "same")
    assert found.status == 0
    right, same = found.facts["releases"]
    assert same["counts"] == {"same": sum(right["counts"].values())}
    assert found.facts["cells"] == []


def test_a_release_that_is_off_fails_and_the_first_is_the_reference(tmp_path):
    found = compared("right", "soft", output=tmp_path / "out")
    assert (found.facts["reference"], found.status) == ("right", 1)
    assert {cell["soft"] for cell in found.facts["cells"]} == {"fail"}
    frame = found.to_frame()
    assert {"reference", "worse"} <= set(frame["change"])
    assert set(NUMBERS) <= set(frame)
    assert json.dumps(found.to_json(), allow_nan=False)
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
