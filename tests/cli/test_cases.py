"""``cases NAME``: all that is known of a case."""

import json

import pytest

from harness.cases.registry import all_cases
from harness.engines.registry import engine_names
from harness.workflows import case_details, cases


def test_a_case_in_full_has_what_the_list_has_and_more(command):
    (found,) = json.loads(command("cases", "oblique", "--json").out)["cases"]
    (listed,) = (one.to_json() for one in cases() if one.name == "oblique")
    assert {key: found[key] for key in listed if key != "parameters"} == {
        key: value for key, value in listed.items() if key != "parameters"
    }
    for name, one in listed["parameters"].items():
        assert found["parameters"][name].items() >= one.items()
    assert found["parameters"]["normal"]["allowed"] == "hooke, hertz, dmt, jkr, mdr"
    assert "less than or equal to 0.5" in found["parameters"]["poisson_ratio"]["allowed"]
    assert "Powder Technology 120" in found["preset_details"]["kharaz"]["source"]
    assert found["preset_details"]["kharaz"]["values"]["partner_youngs_modulus"] == 70e9
    assert found["preset_details"]["usual"] == {"source": "", "values": {}}


@pytest.mark.parametrize("name", all_cases())
def test_every_case_prints_its_parameters_quantities_and_engines(command, monkeypatch, name):
    monkeypatch.setenv("COLUMNS", "200")
    details, said = case_details(name), command("cases", name).out
    for part in (*details.parameters, *details.presets, *details.quantities, *engine_names()):
        assert part in said
    for reason in details.refused_by.values():
        assert reason
    # who has no script and takes no scene says so
    assert set(details.engines) | set(details.refused_by) == set(engine_names())
    for one in details.preset_details.values():
        assert set(one.values) <= set(details.parameters)


def test_nested_parameters_have_their_bounds():
    told = case_details("incline").parameters
    assert "clipped" in told["contact.tail"].allowed
    assert told["stiffness"].unit == "N/m"
    assert told["stiffness"].allowed == "greater than 0"


def test_a_name_that_is_not_known_is_refused(command):
    assert "case 'oblik' is not known" in command("cases", "oblik", status=2).err


@pytest.mark.parametrize("name", ["incline", "columns"])
def test_quantities_of_several_runs_are_listed_with_their_own_parameters(name, command):
    (found,) = json.loads(command("cases", name, "--json").out)["cases"]
    assert found["derived"]["critical_angle_deg"] == "deg"
    assert "critical_angle_deg" not in found["quantities"]  # of one run
    assert list(found["derived_parameters"]) == ["method", "tolerance", "starts"]
    said = command("cases", name).out
    for word in ("critical_angle_deg", "uncertainty_deg", "tolerance", "passage, steady"):
        assert word in said
