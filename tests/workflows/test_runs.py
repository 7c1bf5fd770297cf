"""One run of a case: parameters from text, references, limits, and the parts on request."""

import math

import pytest

from harness.engines.registry import open_engine
from harness.errors import CombinationError, RequestError, Unsupported
from harness.model.law import Law
from harness.workflows import run, sweep
from harness.workflows.runs import refined
from harness.workflows.settings import point_of, texts_of
from tests.workflows import doubles

pytestmark = pytest.mark.usefixtures("registered")


def ran(engine="good", settings=None, **more):
    return run("bounce", settings, engine, open_engine=open_engine, **more)


def test_the_reference_is_the_value_at_equal_steps_and_the_limit_the_closed_form():
    found = ran().quantities["restitution"]
    assert found.reference_kind == "equal steps"
    assert found.difference == 0.0
    assert abs(ran("off", {"stiffness": 1e5}).quantities["restitution"].difference) > 1e-8
    found = ran().quantities["time_s"]
    assert found.limit == doubles.scene_of(doubles.Bounce()).duration
    assert found.step_error == found.reference - found.limit


def test_the_limit_of_small_steps_is_what_finer_runs_tend_to():
    coarse = ran(settings={"steps": 50, "restitution": 1.0}).quantities["restitution"]
    fine = ran(settings={"steps": 100_000, "restitution": 1.0}).quantities["restitution"]
    assert coarse.limit == pytest.approx(1.0, abs=1e-5)  # an elastic ball leaves as fast
    assert abs(coarse.step_error) > 100 * abs(fine.value - coarse.limit)


def test_a_refined_scene_is_sampled_at_the_same_times():
    scene = doubles.scene_of(doubles.Bounce()).replace(every=10)
    finer = refined(scene, 4)
    assert finer.duration == pytest.approx(scene.duration, rel=1e-15)
    assert finer.step * finer.every == pytest.approx(scene.step * scene.every, rel=1e-15)


def test_a_case_that_the_reference_cannot_run_has_its_closed_form(monkeypatch):
    def refuse(*_):
        raise Unsupported("not one of its scenes")

    monkeypatch.setattr(doubles.BounceCase, "reference", refuse)
    quantities = ran().quantities
    assert quantities["time_s"].reference_kind == "closed form"
    assert quantities["restitution"].reference_kind == "none"
    assert math.isnan(quantities["restitution"].reference)
    solved = ran("exact")  # a solver of this package
    assert (solved.engine, solved.engine_version.split()[0]) == ("exact", "dem-harness")
    assert solved.quantities["time_s"].reference_kind == "closed form"


def test_a_search_has_its_uncertainty_and_leaves_what_it_varies_out():
    found = ran(quantities="softest")
    assert found.quantities["softest"].value == 1e4
    assert "stiffness" not in found.parameters
    assert found.to_frame()["uncertainty"].tolist() == [found.quantities["softest"].uncertainty]
    with pytest.raises(RequestError, match=r"--set stiffness=3.*softest varies it"):
        ran(settings={"stiffness": 3}, quantities="softest")
    with pytest.raises(RequestError, match="a search is another run"):
        ran(quantities="softest,time_s")


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"steps": "1.5"}, "--set steps = '1.5'"),
        ({"color": "red"}, "--set color: no such parameter.*stiffness, restitution"),
        ({"preset": "nix"}, "--set preset=nix.*usual, stiff"),
        ({"law.normal": "foo"}, "--set law.normal = 'foo': must be 'hooke', 'hertz'"),
        ({"steps.many": "3"}, "steps has no parts"),
        ({"colour.red": "3"}, "--set colour: no such parameter"),
        ({"law": "1", "law.normal": "hertz"}, "law: is set as a whole already"),
    ],
)
def test_a_wrong_setting_names_value_unit_and_what_is_allowed(settings, words):
    with pytest.raises(RequestError, match=words):
        ran(settings=settings)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"settings": "steps=3"}, "must be a table"),
        ({"engine": 5}, "--engine 5 is not known: must be one of"),
        ({"quantities": [5]}, "5.: must be a name, or several names"),
    ],
)
def test_an_argument_of_another_type_is_a_wrong_request(arguments, words):
    with pytest.raises(RequestError, match=words):
        run("bounce", **arguments)
    with pytest.raises(RequestError, match="case = 5: must be a valid string"):
        sweep(5)


def test_a_nested_parameter_is_changed_by_its_part():
    texts = {"law.normal_stiffness": "3e3", "law.friction": "none"}
    law = point_of(doubles.CASE, texts).parameters.law
    assert (law.normal_stiffness, law.friction) == (3e3, None)
    with pytest.raises(CombinationError):
        point_of(doubles.CASE, {"law.tangential": "linear_nohistory"})


def test_settings_of_python_are_those_of_the_command_line():
    settings = {
        "steps": 20,
        "law": Law.linear(3e3, 0.1, clipped=True),
        "sizes": (1.0, 2),
        "none": None,
    }
    texts = texts_of(settings)
    assert (texts["steps"], texts["sizes"], texts["none"]) == ("20", "[1.0, 2]", "none")
    assert texts["law.normal_stiffness"] == "3000.0"
    del texts["sizes"], texts["none"]
    assert point_of(doubles.CASE, texts).parameters.law == settings["law"]


def test_options_of_a_search_go_with_a_search(monkeypatch):
    monkeypatch.setattr(doubles.BounceCase, "search_options", doubles.Search)
    point = point_of(doubles.CASE, {"method": "fast", "steps": "20"}, ["softest"])
    assert (point.parameters.steps, point.options["method"]) == (20, "fast")
    with pytest.raises(RequestError, match="--set method: goes with --quantity softest only"):
        point_of(doubles.CASE, {"method": "fast"}, ["time_s"])
