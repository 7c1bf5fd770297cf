"""The drop as a case: quantities of one run, records of the baseline, sections."""

import math

import pytest

from harness.cases.drop.case import CASE, Drop
from harness.cases.verification import Study
from harness.engines.reference import Reference
from harness.parameters.law import PLASTIC, Contact
from tests.engine_doubles import Crashing

KNOWN = {
    "head-on": {"restitution", "largest_sampled_overlap_m", "end_speed_m_per_s"},
    "plastic": {"restitution", "largest_sampled_overlap_m", "end_speed_m_per_s"},
    "static": {"end_overlap_m"},
    "fall": {"end_overlap_m", "end_speed_m_per_s"},
    "oblique": {"angular_momentum_ratio"},
}
"""The quantities of each preset that have a closed form."""


@pytest.mark.parametrize("preset", KNOWN)
def test_each_preset_is_what_its_closed_forms_say(preset):
    parameters, engine = CASE.presets[preset], Reference()
    found = CASE.measure(parameters, engine).values
    expected = CASE.references(parameters, engine.traits)
    assert set(expected) == KNOWN[preset]
    # a step of 1/2000 of a contact, times 1 + 2 zeta
    width = math.pi / 2000 * (1 + 2 * parameters.contact.zeta)
    for name, reference in expected.items():
        assert reference.kind == "closed form"
        assert found[name] == pytest.approx(reference.value, rel=width, abs=width * 0.1)


def test_the_largest_overlap_is_that_of_the_damped_spring():
    """x = v t exp(-omega t) at critical damping, v / (e omega) at most; v / omega without."""
    for restitution, deepest in ((0.0, math.exp(-1.0)), (1.0, 1.0)):
        contact = Contact(restitution=restitution, damping_ratio=None)
        case = Drop(contact=contact, speed=1.0, gap=1e-4)
        expected = CASE.references(case, Reference.traits)["largest_sampled_overlap_m"].value
        assert expected == pytest.approx(deepest * 1e-3, rel=1e-9)
        found = CASE.measure(case, Reference()).values["largest_sampled_overlap_m"]
        assert found == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize(
    "changes",
    [
        {"gravity": 9.81, "gap": 0.05, "duration": 3000.0},  # it meets the sphere
        {"gravity": 9.81, "duration": 1.0},  # it has not come to rest
        {"gravity": 9.81, "sideways": 1.0},  # gravity turns the angular momentum
        {},  # nothing happens
        {"speed": 1e-3, "gap": 0.01},  # it does not reach the sphere
    ],
)
def test_what_has_no_closed_form_has_no_reference(changes):
    assert CASE.references(Drop(contact=PLASTIC, **changes), Reference.traits) == {}


def test_of_a_collision_that_is_not_over_the_overlap_is_known_once_it_has_turned():
    contact = Contact(restitution=1.0, damping_ratio=None)
    for duration, known in ((0.45, set()), (0.55, {"largest_sampled_overlap_m"})):
        case = Drop(contact=contact, speed=1.0, duration=duration)
        assert CASE.references(case, Reference.traits).keys() == known
    assert len(CASE.references(case.replace(duration=1.01), Reference.traits)) == 3


def test_a_collision_that_is_not_over_has_no_restitution():
    case = Drop(contact=PLASTIC, speed=1.0, gap=1e-4, duration=0.3)
    assert "restitution" not in CASE.measure(case, Reference()).values


def test_a_drop_that_dies_is_an_error_of_its_record():
    found = CASE.verification.run(Crashing(), Study())
    assert found.records == []
    assert len(found.errors) == 11
    assert "crashing/drop-restitution-plastic" in found.errors
    assert all(check.engine_died for check in found.checks)
