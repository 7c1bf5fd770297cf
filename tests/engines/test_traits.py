import pytest

from harness.engines.registry import ENGINES, engine_class
from harness.engines.traits import Traits
from harness.parameters.law import PLASTIC, SOURCE, Contact


def traits(**rules):
    return Traits(install_hint="somewhere", versions=("1",), integrator="", **rules)


@pytest.mark.parametrize(
    ("rules", "contact", "words"),
    [
        ({"tails": ("clipped",)}, SOURCE, "always have the clipped tail"),
        ({"tails": ("attractive",)}, PLASTIC, "always have the attractive tail"),
        ({"effective_masses": ("half",)}, SOURCE, "fixed sphere is half"),
        ({"most_damping": 1.0}, PLASTIC, "damping ratio is at most 1"),
        ({"restitution_floor": 0.001}, SOURCE, "restitution is at least 0.001"),
    ],
)
def test_what_an_engine_cannot_state_is_refused_with_the_reason(rules, contact, words):
    assert words in traits(**rules).refuses_contact(contact)
    assert traits().refuses_contact(contact) == ""


def test_a_damping_ratio_that_is_given_leaves_the_restitution_aside():
    contact = Contact(restitution=1e-20, damping_ratio=0.5)
    assert traits(restitution_floor=0.001).refuses_contact(contact) == ""


def test_rules_that_leave_no_choice_are_values_that_no_script_need_have():
    only = traits(tails=("clipped",), effective_masses=("half",))
    assert only.fixed_values == {"tail": "clipped", "effective_mass": "half", "law": "overlap"}
    assert traits(laws=("overlap", "deformable")).fixed_values == {}
    assert "overlap law only" in only.refuses({"law": "deformable"})


@pytest.mark.parametrize("name", ENGINES)
def test_every_engine_says_what_it_is_without_being_here(name):
    kind = engine_class(name)
    assert kind.name == name
    assert kind.traits.install_hint
    assert kind.traits.versions
