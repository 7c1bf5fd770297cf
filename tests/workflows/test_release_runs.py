import pytest

from harness.comparison.releases import ReleaseChange
from harness.comparison.verification import Findings
from harness.errors import EngineMissingError, RequestError
from harness.workflows import releases
from tests.workflows import fakes

pytestmark = pytest.mark.usefixtures("registered")


class Released(fakes.Toy):
    """Multiplies with a factor that depends on the release."""

    name = "toy"

    @classmethod
    def check_release(cls, name):
        if not name[0].isdigit():
            raise RequestError(f"release {name!r}: is none")

    @classmethod
    def release(cls, name, folder=None):  # noqa: ARG003
        if name == "2019":
            raise EngineMissingError("pip could not install 2019")
        engine = cls()
        engine.factor = {"2022": 1.0, "2023": 1.0 + 1e-15, "2024": 1.1}[name]
        return engine


@pytest.fixture(autouse=True)
def released(monkeypatch):
    monkeypatch.setattr("harness.workflows.baseline.engine_class", lambda _: Released)


def test_each_release_is_held_against_the_first_that_runs():
    found = releases(["2019", "2022", "2023", "2024"], cases="kept", engine="toy")
    (row,) = found.rows
    assert (row.record, row.label, row.quantity) == ("toy/line", "the line", "y")
    assert [cell.change for cell in row.cells] == [
        ReleaseChange.DIED,
        ReleaseChange.REFERENCE,
        ReleaseChange.ROUNDING,
        ReleaseChange.MOVED,
    ]
    assert found.columns[0].error == "not found: pip could not install 2019"
    assert found.status == 3


def raises(*_):
    raise IndexError("list index out of range")


def leaves_nothing(verification, *_):
    return Findings(verification.case.name, "toy")


@pytest.mark.parametrize(
    ("run", "why"), [(raises, "IndexError"), (leaves_nothing, "missing: kept")]
)
def test_a_case_that_a_release_loses_is_a_failure_that_says_why(run, why, monkeypatch):
    """Its records are not there: without a value none has moved."""
    whole, seen = fakes.KeptVerification.run, []

    def of_the_first(verification, engine, study):
        seen.append(engine)
        return (whole if len(seen) == 1 else run)(verification, engine, study)

    monkeypatch.setattr(fakes.KeptVerification, "run", of_the_first)
    found = releases(["2022", "2023"], cases="kept", engine="toy")
    (row,) = found.rows
    assert row.cells[1].change is ReleaseChange.NOT_TESTED
    assert why in row.cells[1].note
    assert found.status == 1


@pytest.mark.parametrize(
    ("names", "said"),
    [
        ([], "name at least one"),
        (["2022", "2022"], "release '2022': is named twice"),
        (["2022", "x"], "release 'x': is none"),
    ],
)
def test_a_request_that_cannot_be_met_is_refused_before_anything_runs(names, said, monkeypatch):
    monkeypatch.setattr(fakes.Toy, "run", lambda *_: pytest.fail("it ran"))
    with pytest.raises(RequestError, match=said):
        releases(names, cases="kept", engine="toy")


def test_an_engine_without_releases_is_refused(monkeypatch):
    monkeypatch.setattr("harness.workflows.baseline.engine_class", lambda _: fakes.Toy)
    with pytest.raises(RequestError, match="has no releases"):
        releases(["2022"], engine="toy")
