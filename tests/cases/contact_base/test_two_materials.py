"""Two materials in contact: the one that stands for both, and what codes make of each."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.cases.contact.impact import head_on
from harness.cases.contact.parameters import (
    ContactSystem,
    one_material,
    reduced_modulus,
    reduced_shear_modulus,
)
from harness.cases.registry import get_case
from harness.errors import RequestError
from harness.parameters.law import ContactLaw
from harness.parameters.scene import Body, ContactScene, Plane
from harness.solvers.pair.system import effective_moduli
from tests.cases.contact_base.limits import limits

MODULI = st.floats(1e5, 1e12)
RATIOS = st.floats(-0.9, 0.49)


def of(young, poisson, other=None, its=None):
    return ContactLaw(
        normal="hertz",
        youngs_modulus=young,
        poisson_ratio=poisson,
        partner_youngs_modulus=other,
        partner_poisson_ratio=its,
    )


@given(MODULI, RATIOS, MODULI, RATIOS)
def test_one_material_has_the_moduli_of_two_which_are_the_harmonic_mean_of_each(e, nu, f, xi):
    two = of(e, nu, f, xi)
    young, poisson = one_material(two)
    assert effective_moduli(of(young, poisson)) == pytest.approx(effective_moduli(two), rel=1e-9)
    # compliances of half-spaces add up: a pair of equal ones has twice that of one
    alone = zip(effective_moduli(of(e, nu)), effective_moduli(of(f, xi)), strict=True)
    means = [2.0 / (1.0 / first + 1.0 / second) for first, second in alone]
    assert effective_moduli(two) == pytest.approx(means, rel=1e-12)
    assert (reduced_modulus(two), reduced_shear_modulus(two)) == pytest.approx(means, rel=1e-12)
    assert min(nu, xi) - 1e-9 <= poisson <= max(nu, xi) + 1e-9


def test_a_rigid_partner_makes_a_contact_twice_as_stiff():
    equal, rigid = effective_moduli(of(1e8, 0.3)), effective_moduli(of(1e8, 0.3, 1e30))
    assert rigid == pytest.approx([2.0 * one for one in equal], rel=1e-12)


def test_an_impact_on_a_denser_sphere_of_another_material_is_that_of_hertz():
    case = get_case("head-on")
    (two,) = [
        one.parameters
        for one in case.trials("default")
        if (one.submodel, one.system) == ("hertz", "two materials, mixed")
    ]
    m1, m2 = (body.mass for body in case.scene(two).bodies)
    assert m2 == pytest.approx(2.0 * m1, rel=1e-12)
    assert two.reduced_mass == pytest.approx(m1 * m2 / (m1 + m2), rel=1e-12)
    exact = head_on(two, two.speed)
    found = {name: one.value for name, one in limits(case, two).items()}
    assert exact.keys() == {
        "restitution", "contact_time_s", "largest_overlap_m", "largest_force_N"
    }  # fmt: skip
    assert {name: found[name] for name in exact} == pytest.approx(exact, rel=1e-4)


@pytest.mark.parametrize(
    ("told", "words"),
    [
        ({"materials_as": "mixed"}, "materials_as = 'mixed': needs two materials"),
        ({"partner_density": 5e3}, "partner_density = 5000.0: partner = 'wall' has none"),
        (
            {"normal": "hooke", "partner_youngs_modulus": 1e8},
            "partner_youngs_modulus = 100000000.0: normal = 'hooke' takes none",
        ),
    ],
)
def test_what_has_no_meaning_is_refused(told, words):
    with pytest.raises(RequestError) as error:
        ContactSystem(**{"normal": "hertz", **told})
    assert words in str(error.value)


def test_which_of_several_contacts_two_materials_are_of_is_not_guessed():
    ball = Body(0.01, 0.01, (0.0, 0.0, 0.01))
    floor = Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    with pytest.raises(RequestError, match="partner_youngs_modulus"):
        ContactScene((ball, ball), (floor,), of(1e8, 0.3, 2e8), step=1e-6, steps=1)
    with pytest.raises(RequestError, match="upper_density is that of this case"):
        get_case("stacked").default.replace(partner_density=1e4)
