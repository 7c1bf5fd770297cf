import math

import pytest

from harness.errors import EngineCrashError, RequestError
from harness.parameters.law import PLASTIC
from harness.workflows import cases, run
from tests.workflows import fakes

pytestmark = pytest.mark.usefixtures("registered")


def test_a_run_says_what_was_measured_beside_what_is_expected():
    record = run("line", {"slope": "4"}, "wrong").to_json()
    assert set(record) == {"case", "engine", "engine_version", "parameters", "quantities"}
    assert (record["case"], record["engine"], record["engine_version"]) == ("line", "wrong", "1")
    assert record["parameters"] == {"slope": 4.0, "count": 1, "end": {"x": 2.0, "limit": None}}
    y = record["quantities"]["y"]
    assert (y["unit"], y["reference"], y["reference_kind"]) == ("m", 8.0, "closed form")
    assert y["value"] == pytest.approx(8.8)
    assert y["difference"] == pytest.approx(0.8)
    twice = record["quantities"]["twice"]
    assert twice["reference_kind"] == "none"
    assert math.isnan(twice["reference"])


def test_an_open_engine_is_used_and_a_solver_is_one_too():
    assert run("line", {}, fakes.Toy()).engine == "toy"
    found = run("line", {}, "pencil")
    assert found.engine == "pencil"
    assert found.engine_version.startswith("dem-harness ")
    assert list(found.quantities) == ["y"]


def test_a_nested_parameter_is_set_by_its_name_and_a_preset_is_changed():
    found = run("line", {"end.x": "0.5", "preset": "steep"}, "toy")
    assert found.quantities["y"].value == 50.0
    assert run("line", {"end.limit": "7"}, "toy").parameters["end"]["limit"] == 7.0
    assert run("line", {"end.limit": "none"}, "toy").parameters["end"]["limit"] is None


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"slop": "1"}, r"--set: slop: no such parameter of LineParameters \(it has slope, count"),
        ({"end.y": "1"}, r"--set: y: no such parameter of End \(it has x, limit\)"),
        ({"slope": "-1"}, r"--set: slope = '-1': must be greater than 0"),
        ({"slope": "steep"}, "slope = 'steep': must be a valid number"),
        ({"end.x": "nan"}, "x = 'nan' m: must be"),
        ({"slope.x": "1"}, "slope has no parts"),
        ({"nothing.x": "1"}, "nothing: no such parameter"),
        ({"end": "1", "end.x": "1"}, "end is set as a whole already"),
        ({"preset": "flat"}, "case 'line' has the presets usual, steep"),
    ],
)
def test_a_setting_that_is_not_allowed_is_named_with_what_is(settings, said):
    with pytest.raises(RequestError, match=said) as caught:
        run("line", settings, "toy")
    assert "\n" not in str(caught.value)


def test_names_that_are_not_known_and_engines_that_cannot_are_refused():
    with pytest.raises(RequestError, match="case 'circle' is not known"):
        run("circle")
    with pytest.raises(RequestError, match=r"--engine 'pen' is not known: .*toy.*pencil"):
        run("line", {}, "pen")
    with pytest.raises(RequestError, match="'blind': cannot run 'line': it has no template"):
        run("line", {}, "blind")


def test_a_run_that_fails_is_an_engine_error():
    engine = fakes.Dying()
    engine.left = 0
    with pytest.raises(EngineCrashError, match="SIGSEGV"):
        run("line", {}, engine)


def test_the_cases_are_listed_with_parameters_quantities_and_engines():
    by_name = {case.name: case for case in cases()}
    assert list(by_name) == ["line", "kept", "gate", "raising"]
    record = by_name["line"].to_json()
    assert record["parameters"]["slope"] == {"default": 3.0, "unit": "", "description": "slope"}
    assert record["parameters"]["end.x"] == {"default": 2.0, "unit": "m", "description": "abscissa"}
    assert record["quantities"] == {"y": "m", "twice": "m"}
    assert "toy" in record["engines"]
    assert "blind" not in record["engines"]
    assert record["presets"] == ["usual", "steep"]


def test_a_restitution_that_is_set_is_not_overridden_by_the_damping_ratio_that_was_there():
    assert PLASTIC.replace(restitution=0.5).zeta == pytest.approx(0.2155, abs=1e-4)
    assert PLASTIC.replace(restitution=0.5, damping_ratio=2.0).zeta == 2.0
