"""Contact models: which one states a contact, and what is said where none does."""

import pytest

from harness.engines.traits import ContactModel, never_attracts, stating, takes

MODELS = (
    ContactModel("A", takes("hooke", "none velocity", "none") | {"planes": (0,)}),
    ContactModel("B", takes("hertz", "none", "none"), needs=never_attracts),
    ContactModel("C", takes("hertz dmt", "none", "none mindlin") | {"planes": (0,)}),
    ContactModel("D", takes("hertz", "viscoelastic", "none"), needs=never_attracts),
)
LAW = {"normal": "hertz", "damping": "none", "tangential": "none", "planes": 0, "clipped": "no"}


@pytest.mark.parametrize(
    ("changes", "name", "said"),
    [
        ({}, "B", ""),
        ({"tangential": "mindlin"}, "C", ""),
        # equally close, by the same value: told together, each word once
        ({"normal": "jkr"}, "A", "its A, B, C or D takes normal = hooke, hertz or dmt, not jkr"),
        (
            {"damping": "mass_velocity"},
            "B",
            "its B, C or D takes damping = none or viscoelastic, not mass_velocity",
        ),
        # the closest alone
        (
            {"tangential": "linear"},
            "B",
            "its B or C takes tangential = none or mindlin, not linear",
        ),
        ({"tangential": "mindlin", "planes": 1}, "C", "its C takes two spheres, and no wall"),
        ({"damping": "viscoelastic"}, "D", "its D never attracts (clipped = yes)"),
    ],
)
def test_what_no_model_states_is_said_of_all_that_are_equally_close(changes, name, said):
    model, reason = stating(MODELS, {**LAW, **changes})
    assert (model.name, reason) == (name, said)
