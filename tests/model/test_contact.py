"""Contacts of the cases without friction: damping, effective mass, and the law they make."""

import math

import pytest

from harness.errors import RequestError
from harness.model.law import CLIPPED, PLASTIC, SOURCE, Contact, Law


def test_damping_of_the_named_contacts():
    assert SOURCE.zeta == pytest.approx(0.99768, abs=1e-5)
    assert (CLIPPED.zeta, PLASTIC.zeta, Contact(restitution=1.0).zeta) == (1.0, 5.0, 0.0)
    assert PLASTIC.dashpot(1e6, 4.0) == pytest.approx(2.0 * 5.0 * math.sqrt(4e6))


def test_half_the_effective_mass_damps_less():
    half = SOURCE.replace(effective_mass="half")
    assert half.zeta_against_full_mass == pytest.approx(SOURCE.zeta / math.sqrt(2.0))
    assert half.dashpot(1e6, 1.0) == pytest.approx(SOURCE.dashpot(1e6, 0.5))


def test_a_restitution_alone_replaces_the_damping_ratio():
    changed = PLASTIC.replace(restitution=0.5)
    assert (changed.damping_ratio, changed.tail) == (None, "clipped")
    assert Contact(restitution=0.5, damping_ratio=2.0).zeta == 2.0


def test_the_law_is_linear_with_the_same_dashpot():
    assert PLASTIC.law(1e6) == Law.linear(1e6, 5.0, True)
    assert SOURCE.law(1e6).dashpot(3.0, 1.0, 0.0) == pytest.approx(SOURCE.dashpot(1e6, 3.0))


@pytest.mark.parametrize("values", [{}, {"restitution": 1.1}, {"damping_ratio": -1.0}])
def test_a_contact_without_damping_or_out_of_range_is_refused(values):
    with pytest.raises(RequestError):
        Contact(**values)


def test_values_of_scripts_state_a_ratio_or_a_restitution():
    assert PLASTIC.script_values["damping"] == "ratio"
    assert CLIPPED.script_values == {
        "damping": "restitution", "restitution": 0.0, "damping_ratio": 1.0,
        "effective_mass": "full", "tail": "clipped",
    }  # fmt: skip
