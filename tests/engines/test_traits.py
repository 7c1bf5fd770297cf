import pytest

from harness.engines.registry import engine_class
from harness.engines.traits import Traits
from harness.parameters.law import PLASTIC, SOURCE, Contact
from tests.engine_doubles import frictionless, least_restitution, most_damping


def traits(**rules):
    return Traits(install_hint="somewhere", versions=("1",), integrator="", **rules)


@pytest.mark.parametrize(
    ("rules", "contact", "words"),
    [
        (frictionless(tail="clipped"), SOURCE, "takes tail = clipped, not attractive"),
        (frictionless(tail="attractive"), PLASTIC, "takes tail = attractive, not clipped"),
        (frictionless(effective_mass="half"), SOURCE, "takes effective_mass = half, not full"),
        (most_damping(1.0), PLASTIC, "takes damping ratios up to 1"),
        (least_restitution(0.001), SOURCE, "takes restitutions from 0.001 on"),
    ],
)
def test_what_an_engine_cannot_state_is_refused_with_the_reason(rules, contact, words):
    assert words in traits(frictionless=rules).refuses_contact(contact)
    assert traits().refuses_contact(contact) == ""


def test_a_damping_ratio_that_is_given_leaves_the_restitution_aside():
    contact = Contact(restitution=1e-20, damping_ratio=0.5, effective_mass="half")
    assert engine_class("mfix").traits.refuses_contact(contact) == ""
    assert engine_class("mfix").traits.refuses_contact(contact.replace(restitution=1e-25)) != ""


def test_rules_that_leave_no_choice_are_values_that_no_script_need_have():
    only = traits(frictionless=frictionless(tail="clipped", effective_mass="half"))
    assert only.fixed_values == {"tail": "clipped", "effective_mass": "half", "law": "overlap"}
    assert engine_class("reference").traits.fixed_values == {}
    assert "law = overlap, not deformable" in only.refuses({"law": "deformable"})
