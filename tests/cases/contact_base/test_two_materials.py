"""Two materials in contact: the one that stands for both, and what codes make of each."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.cases.contact.impact import head_on
from harness.cases.contact.motion import followed
from harness.cases.contact.parameters import (
    ContactSystem,
    one_material,
    reduced_modulus,
    reduced_shear_modulus,
)
from harness.cases.contact.submodels import TWO_MATERIALS
from harness.cases.contact.verification import verify_trials
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.known_defects import mark_known_defects
from harness.comparison.verdicts import Verdict
from harness.engines.lammps.engine import Lammps
from harness.engines.registry import engine_class
from harness.errors import RequestError
from harness.observables.provenance import release_of
from harness.parameters.law import ContactLaw
from harness.parameters.rules import Rules
from harness.parameters.scene import Body, ContactScene, Plane
from harness.solvers.pair.system import effective_moduli
from harness.store.baseline import known_defects

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
    motion = followed(case.scene(two.replace(steps_per_contact=1600)), Rules()).motion
    exact = head_on(two, two.speed)
    found = case.observed(two, motion)
    assert exact.keys() == {
        "restitution", "contact_time_s", "largest_overlap_m", "largest_force_N"
    }  # fmt: skip
    assert {name: found[name] for name in exact} == pytest.approx(exact, rel=1e-5)


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


def trial_of(name, submodel, system):
    case = get_case(name)
    (found,) = [
        one for one in case.trials("default") if (one.submodel, one.system) == (submodel, system)
    ]
    return case, found


@pytest.mark.parametrize("name", ["yade", "liggghts", "kratos"])
def test_a_code_that_does_not_mix_says_so_and_takes_the_one_for_both(name):
    case, mixed = trial_of("head-on", "hertz", "two materials, mixed")
    job, traits = case.job(mixed.parameters), engine_class(name).traits
    assert "gets one material for both bodies" in traits.refuses(job.values)
    assert traits.refuses(case.job(mixed.parameters.replace(materials_as="stated")).values) == ""
    stated = case.job(mixed.parameters.replace(materials_as="stated"))
    assert stated.values.keys() == job.values.keys() - {
        "partner_youngs_modulus", "partner_poisson_ratio"
    }  # fmt: skip
    told = stated.values["youngs_modulus"], stated.values["poisson_ratio"]
    assert effective_moduli(of(*told)) == pytest.approx(
        effective_moduli(mixed.parameters.law), rel=1e-12
    )


@pytest.fixture(scope="module")
def lammps():
    with Lammps(workers=1) as engine:
        yield engine


def rows(engine, name, submodel, system):
    """Return the rows of a trial, failures that known defects explain marked."""
    case, trial = trial_of(name, submodel, system)
    found = verify_trials(case, engine, Study("quick"), [trial]).checks
    versions = {"lammps": engine.identify().engine_version}
    return [row for row in mark_known_defects(found, known_defects(), versions) if row.tolerance]


@pytest.mark.live
@pytest.mark.usefixtures("lammps_here")
class TestInLammps:
    """What LAMMPS makes of both, and that a fault of each shows."""

    def test_the_one_that_stands_for_both_is_the_law(self, lammps):
        for system in ("two materials, stated", "wall of another material"):
            found = rows(lammps, "oblique", "mindlin", system)
            assert {row.verdict for row in found} == {Verdict.PASS}
            assert len(found) == 4

    def test_mixed_ones_are_a_defect_of_the_size_that_its_cause_predicts(self, lammps):
        found = rows(lammps, "oblique", "mindlin", "two materials, mixed")
        if release_of(lammps.identify().engine_version) < release_of("28 Mar 2023"):
            pytest.skip("this release mixes them into hooke")
        assert {row.verdict for row in found} == {Verdict.KNOWN_DEFECT}
        assert {row.cell.defect for row in found} == {"mixed-tangential-stiffness"}
        assert max(abs(row.value / row.expected - 1.0) for row in found) > 0.05

    def test_a_wall_takes_the_coefficients_of_the_contact_and_says_so(self, lammps):
        case, trial = trial_of("oblique", "mindlin", "wall of another material")
        mixed = trial.parameters.replace(materials_as="mixed")
        assert "walls take the coefficients" in lammps.refuses(case.job(mixed))
        classic = trial.parameters.replace(**TWO_MATERIALS["two materials, mixed"])
        classic = classic.replace(tangential="mindlin_classic")
        assert "where G* follows from them" in lammps.refuses(case.job(classic))
        job = case.job(mixed.replace(partner="sphere"))
        assert lammps.refuses(replace(job, values={**job.values, "planes": 0})) == ""
