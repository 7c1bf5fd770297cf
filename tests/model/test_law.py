"""Laws: defaults, what is refused and how, moduli, dashpots and other units."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.errors import CombinationError, RequestError
from harness.model.base import unit
from harness.model.conventions import Faults, Rules
from harness.model.law import CLIPPED, COEFFICIENTS, PLASTIC, SOURCE, SUBMODELS, Contact, Law

HERTZ = Law(normal="hertz", youngs_modulus=1e8, poisson_ratio=0.3)


def test_defaults_of_the_submodels_that_are_there():
    law = Law(tangential="linear_history", normal_stiffness="7.0")
    assert (law.tangential_stiffness, law.friction, law.tangential_damping) == (2.0, 0.3, 0.0)
    assert law.youngs_modulus is None


@pytest.mark.parametrize(
    ("values", "line"),
    [
        ({"normal": "hook"}, "normal = 'hook': must be 'hooke', 'hertz', 'dmt', 'jkr' or 'mdr'"),
        ({"normal_stiffness": -1.0}, "normal_stiffness = -1.0 N/m: must be greater than or equal"),
        ({"normal_stiffness": math.nan}, "normal_stiffness = nan N/m: must be"),
        ({"friction": math.inf, "tangential": "linear_history"}, "friction = inf: must be"),
        ({"stiffness": 1.0}, "stiffness: no such parameter of Law"),
        ({"normal_stiffness": 1e31}, "must be less than or equal to 1e+30"),
        ({"stiffness": None}, "stiffness: no such parameter of Law"),
        ({"friction": 0.3}, "friction = 0.3: belongs to tangential = 'linear_nohistory', not to"),
        ({"normal": "hertz", "normal_stiffness": 1.0}, "normal_stiffness = 1.0: belongs to normal"),
        ({"damping": "velocity"}, "damping_coefficient: must be given with damping = 'velocity'"),
        ({"damping": "tsuji"}, "damping = 'tsuji': needs normal = hertz"),
        ({"tangential": "mindlin"}, "tangential = 'mindlin': needs a material"),
        ({"tangential": "linear_nohistory"}, "tangential = 'linear_nohistory': needs a damping"),
        ({"twisting": "marshall"}, "twisting = 'marshall': needs a tangential spring"),
        ({"normal": "jkr", "clipped": True}, "clipped = True: must be False"),
        ({"normal": "mdr", "yield_stress": 1e6, "poisson_ratio": 0.5}, "poisson_ratio = 0.5: must"),
        ({"normal": "hertz", "normal_modulus": 1e8, "youngs_modulus": 1e8}, "normal_modulus: must"),
        ({"normal": "mdr", "tangential": "mindlin", "partner_friction": 0.1}, "has one material"),
        ({"rolling": "sds"}, "must be given with rolling = 'sds'"),
        ({"normal": ["hooke"]}, "normal = ['hooke']: must be"),
    ],
)
def test_refused_in_one_line(values, line):
    with pytest.raises(RequestError) as error:
        Law(**values)
    assert line in str(error.value)
    assert "\n" not in str(error.value)


def test_coefficient_that_no_submodel_takes():
    usual = [table.get(getattr(Law(), part)) for part, table in SUBMODELS.items()]
    taken = {name for row in filter(None, usual) for name in (*row.needs, *row.may_have)}
    assert taken < COEFFICIENTS
    for name in COEFFICIENTS - taken:
        with pytest.raises(CombinationError, match=name):
            Law(**{name: 0.3})


def test_replace_drops_what_is_left():
    law = HERTZ.replace(damping="viscoelastic", damping_coefficient=4e5)
    assert law.replace(damping="none").damping_coefficient is None
    assert law.replace(normal="hooke").youngs_modulus is None
    by_modulus = law.replace(normal_modulus=1e8)
    assert by_modulus.youngs_modulus is None
    assert by_modulus.replace(youngs_modulus=1e8, poisson_ratio=0.3).normal_modulus is None


@given(st.floats(1e6, 1e12), st.floats(0.0, 0.49), st.floats(1e6, 1e12), st.floats(0.0, 0.49))
def test_one_material_for_two(first, nu, second, other):
    law = HERTZ.replace(youngs_modulus=first, poisson_ratio=nu, partner_youngs_modulus=second,
                        partner_poisson_ratio=other)  # fmt: skip
    assert law.one_material.moduli == pytest.approx(law.moduli, rel=1e-9)
    assert not law.one_material.two_materials


@given(st.floats(1e-3, 1.0), st.floats(1e-3, 1.0), st.sampled_from(["geometric", "arithmetic"]))
def test_coefficients_of_a_pair_lie_between_those_of_each(first, second, kind):
    law = HERTZ.replace(damping="tsuji", restitution=first, partner_restitution=second,
                        tangential="mindlin", tangential_damping=0.0, friction=first,
                        partner_friction=second)  # fmt: skip
    pair, swapped = law.mixed(kind, "least"), law.of_each[::-1]
    assert not pair.two_materials
    assert pair.friction == min(first, second)
    low, high = sorted((first, second))
    assert low * (1.0 - 1e-15) <= pair.restitution <= high * (1.0 + 1e-15)
    assert [own.restitution for own in swapped] == [second, first]
    same = law.replace(partner_restitution=first, partner_friction=first)
    assert same.mixed(kind, kind).restitution == pytest.approx(first, rel=1e-15)


def test_other_units_keep_the_damping_ratio():
    for law in (
        Law(damping="velocity", damping_coefficient=2.0),
        HERTZ.replace(damping="viscoelastic", damping_coefficient=4e5),
        HERTZ.replace(damping="coeff_restitution", restitution=0.5),
    ):
        scaled = law.in_units(1e-3, 1e-6, 1e-2)
        eta, its = law.dashpot(0.01, 0.01, 1e-5), scaled.dashpot(1e4, 10.0, 1e-2)
        assert its == pytest.approx(eta * 1e-2 / 1e-6, rel=1e-12)


@pytest.mark.parametrize("kind", [Law, Rules, Faults])
def test_fields_have_units(kind):
    for name, field in kind.model_fields.items():
        assert field.description.startswith("["), name
        assert "]" in field.description
    assert unit(Law, "youngs_modulus") == "Pa"
    assert Rules(scheme="mfix_euler").changed == {"scheme": "mfix_euler"}


# ---- contacts without friction


def test_damping_of_the_named_contacts():
    assert SOURCE.zeta == pytest.approx(0.99768, abs=1e-5)
    assert (CLIPPED.zeta, PLASTIC.zeta, Contact(restitution=1.0).zeta) == (1.0, 5.0, 0.0)
    assert PLASTIC.dashpot(1e6, 4.0) == pytest.approx(2.0 * 5.0 * math.sqrt(4e6))
    half = SOURCE.replace(effective_mass="half")
    assert half.zeta_against_full_mass == pytest.approx(SOURCE.zeta / math.sqrt(2.0))
    assert half.dashpot(1e6, 1.0) == pytest.approx(SOURCE.dashpot(1e6, 0.5))


def test_a_contact_is_a_linear_law_with_the_same_dashpot():
    assert PLASTIC.law(1e6) == Law.linear(1e6, 5.0, True)
    for contact in (PLASTIC, SOURCE):
        dashpot = pytest.approx(contact.dashpot(1e6, 3.0))
        assert contact.law(1e6).dashpot(3.0, 1.0, 0.0) == dashpot


def test_a_restitution_alone_replaces_the_damping_ratio():
    changed = PLASTIC.replace(restitution=0.5)
    assert (changed.damping_ratio, changed.tail) == (None, "clipped")
    assert Contact(restitution=0.5, damping_ratio=2.0).zeta == 2.0
    values = CLIPPED.script_values
    assert (PLASTIC.script_values["damping"], values["damping"]) == ("ratio", "restitution")
    assert (values["restitution"], values["damping_ratio"]) == (0.0, 1.0)


def test_a_contact_without_damping_or_out_of_range_is_refused():
    for values in ({}, {"restitution": 1.1}, {"damping_ratio": -1.0}):
        with pytest.raises(RequestError):
            Contact(**values)
