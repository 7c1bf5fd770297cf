import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from harness.errors import RequestError
from harness.parameters.law import CLIPPED, CONTACTS, PLASTIC, SOURCE, Contact, ContactLaw


@pytest.mark.parametrize("restitution", [0.05, 0.5, 0.9])
def test_damping_ratio_gives_the_nominal_restitution_when_integrated(restitution):
    zeta = Contact(restitution=restitution).zeta

    def leaves(_, state):
        return state[0]

    leaves.terminal, leaves.direction = True, -1.0
    run = solve_ivp(
        lambda _, s: [s[1], -s[0] - 2 * zeta * s[1]],
        (0.0, 20.0),
        [1e-9, 1.0],
        events=leaves,
        rtol=1e-10,
        atol=1e-12,
    )
    assert -run.y[1, -1] == pytest.approx(restitution, rel=1e-6)


@given(st.floats(0.0, 1.0))
def test_every_allowed_restitution_gives_a_finite_damping_ratio_up_to_critical(restitution):
    zeta = Contact(restitution=restitution).zeta
    assert math.isfinite(zeta)
    assert 0.0 <= zeta <= 1.0


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_damping_falls_with_restitution(one, other):
    low, high = sorted((one, other))
    assert Contact(restitution=low).zeta >= Contact(restitution=high).zeta


def test_restitution_zero_is_critical_damping():
    assert Contact(restitution=0.0).zeta == 1.0
    assert Contact(restitution=5e-324).zeta < 1.0


def test_restitution_one_is_no_damping():
    assert Contact(restitution=1.0).zeta == 0.0


def test_damping_ratio_wins_over_restitution():
    assert Contact(restitution=0.5, damping_ratio=3.0).zeta == 3.0


def test_a_restitution_is_stated_where_no_damping_ratio_is():
    assert SOURCE.stated_restitution == 1e-20
    assert CLIPPED.stated_restitution == 0.0
    assert PLASTIC.stated_restitution is None
    assert SOURCE.replace(damping_ratio=0.5).stated_restitution is None


@given(st.floats(0.0, 100.0))
def test_half_the_mass_gives_the_dashpot_of_half_the_mass(zeta):
    half = Contact(damping_ratio=zeta, effective_mass="half")
    mass, stiffness = 3.0, 7.0
    dashpot = 2 * zeta * math.sqrt(stiffness * mass / 2)
    assert half.zeta_against_full_mass == pytest.approx(
        dashpot / (2 * math.sqrt(stiffness * mass)), rel=1e-12
    )
    assert Contact(damping_ratio=zeta).zeta_against_full_mass == zeta


def test_contacts_of_the_study():
    assert list(CONTACTS) == ["source", "clipped", "plastic"]
    assert SOURCE.zeta == pytest.approx(0.99768, abs=5e-6)
    assert (SOURCE.tail, CLIPPED.tail, PLASTIC.tail) == ("attractive", "clipped", "clipped")
    assert (CLIPPED.zeta, PLASTIC.zeta) == (1.0, 5.0)


@pytest.mark.parametrize("value", [-0.1, 1.0001, math.nan, math.inf, -math.inf])
def test_restitution_out_of_range_is_named(value):
    with pytest.raises(RequestError) as caught:
        Contact(restitution=value)
    allowed = "greater than or equal to 0 and less than or equal to 1"
    finite = "" if math.isfinite(value) else "a finite number, "
    assert str(caught.value) == f"restitution = {value!r}: must be {finite}{allowed}"


@pytest.mark.parametrize("value", [-0.1, 101.0, math.nan, math.inf])
def test_damping_ratio_out_of_range_is_named(value):
    with pytest.raises(RequestError) as caught:
        Contact(damping_ratio=value)
    allowed = "greater than or equal to 0 and less than or equal to 100"
    finite = "" if math.isfinite(value) else "a finite number, "
    assert str(caught.value) == f"damping_ratio = {value!r}: must be {finite}{allowed}"


@pytest.mark.parametrize(
    ("field", "allowed"),
    [("tail", "'attractive' or 'clipped'"), ("effective_mass", "'full' or 'half'")],
)
def test_unknown_choice_is_named(field, allowed):
    with pytest.raises(RequestError, match=rf"^{field} = 'other': must be {allowed}$"):
        Contact(restitution=0.5, **{field: "other"})


def test_contact_without_damping_is_refused():
    with pytest.raises(RequestError, match=r"needs a restitution .* or a damping ratio"):
        Contact()


@pytest.mark.parametrize("contact", [*CONTACTS.values(), SOURCE.replace(effective_mass="half")])
def test_a_contact_is_a_law_with_a_constant_dashpot(contact):
    law = contact.law(4e6, 0.25)
    shared = 0.5 if contact.effective_mass == "half" else 1.0
    eta = pytest.approx(2.0 * contact.zeta * 1e3 * math.sqrt(shared), rel=1e-15)
    assert law.damping_coefficient == contact.dashpot(4e6, 0.25) == eta
    same = {"normal_stiffness": 4e6, "damping_coefficient": law.damping_coefficient}
    assert law == ContactLaw(**same, damping="velocity", clipped=contact.tail == "clipped")
    assert law.linear


def test_a_law_has_no_bounds_that_the_units_of_a_case_may_pass():
    assert PLASTIC.law(1e100, 1e-100).normal_stiffness == 1e100
