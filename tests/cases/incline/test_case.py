"""The incline as a case: one run, its references, parameters by preset, sections and figures."""

import itertools
import math

import numpy as np
import pytest

from harness.cases.incline.angle import (
    check_passage,
    critical_angle,
    critical_angle_by_passage,
    extrapolated_critical_angle,
    most_restitution,
)
from harness.cases.incline.case import CASE
from harness.cases.incline.closed_forms import closed_forms, rebound
from harness.cases.incline.runs import measured
from harness.cases.incline.system import Incline
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict
from harness.engines.reference import Reference
from harness.errors import RequestError
from harness.parameters.law import CLIPPED, PLASTIC, SOURCE, Contact
from harness.solvers.hard_sphere import critical_angle as rigid_angle
from harness.theory.incline import critical_angle as closed_form
from harness.theory.incline import passage_margin
from tests.engine_doubles import Twin

HALF = Contact(restitution=0.5, damping_ratio=None)


@pytest.mark.parametrize("preset", ["source", "clipped", "plastic"])
def test_one_passage_has_the_margin_of_the_closed_form_within_its_bias(preset):
    parameters, engine = CASE.presets[preset], Reference()
    found = CASE.measure(parameters, engine)
    expected = CASE.references(parameters, engine.traits)["margin_over_mgd"]
    assert expected.kind == "closed form"
    assert expected.value == passage_margin(parameters.angle, 0.25)
    # the slope is 0.0087 per degree: the bias of the angle is 0.01 deg at most
    assert found.values["margin_over_mgd"] == pytest.approx(expected.value, abs=2e-4)
    assert found.values["moves_on"] == float(found.values["margin_over_mgd"] >= 0.0)
    assert found.values["steps"] * parameters.step == pytest.approx(found.values["time_s"])
    assert set(found.values) == {quantity.name for quantity in CASE.quantities}


@pytest.mark.parametrize(("angle", "moves"), [(9.5, 0.0), (11.0, 1.0)])
def test_a_passage_moves_on_above_the_critical_angle(angle, moves):
    found = CASE.measure(CASE.presets["plastic"].replace(angle=angle), Reference())
    assert found.values["moves_on"] == moves
    assert found.values["touching"] == 1.0


def test_a_contact_that_rebounds_has_no_reference():
    assert CASE.references(Incline(contact=HALF), Reference.traits) == {}


def test_a_contact_is_chosen_by_its_name():
    assert Incline(contact="plastic").contact is PLASTIC
    with pytest.raises(RequestError, match=r"contact = 'wet'.* must be one of source, clipped, pl"):
        Incline(contact="wet")


def test_the_rebound_is_that_of_the_law_and_the_readings_part_with_it():
    assert rebound(SOURCE) == pytest.approx(1e-20, rel=1e-9)
    assert rebound(CLIPPED) == pytest.approx(math.exp(-2.0))
    assert rebound(HALF) == pytest.approx(0.5)
    assert rebound(HALF.replace(effective_mass="half")) > 0.6
    assert closed_forms(SOURCE) == pytest.approx({"kept": closed_form(), "lost": closed_form()})
    kept, lost = closed_forms(HALF).values()
    assert kept < closed_form() < lost


@pytest.mark.parametrize("measure", [critical_angle, extrapolated_critical_angle])
def test_a_rebounding_contact_is_refused_before_any_run_with_what_theory_says(measure):
    engine = Twin()
    with pytest.raises(RequestError, match=r"use method 'steady'; at e = 0.5 .* 6.25\d deg .* 15"):
        measure(Incline(contact=HALF), engine=engine)
    assert engine.jobs == []


@pytest.mark.parametrize("measure", [critical_angle, extrapolated_critical_angle])
@pytest.mark.parametrize(
    "contact",
    [Contact(restitution=0.35), Contact(restitution=0.25, tail="clipped")],
    ids=["tail", "clipped"],
)
def test_a_contact_whose_hops_last_to_where_a_passage_is_judged_is_refused_before(measure, contact):
    engine = Twin()
    with pytest.raises(RequestError, match=r"restitution 0.3[23]\d* at most at stiffness 1e\+0"):
        measure(Incline(contact=contact), engine=engine)
    assert engine.jobs == []


@pytest.mark.parametrize(
    ("restitution", "steps", "stiffness"),
    [(0.325, 20.0, 1e7), (0.33, 20.0, 1e7), (0.335, 50.0, 1e7), (0.335, 100.0, 1e7)],
)
def test_a_contact_that_rebounds_more_in_its_steps_is_refused_before_any_run(
    restitution, steps, stiffness
):
    engine, contact = Twin(), Contact(restitution=restitution)
    case = Incline(contact=contact, steps_per_contact=steps, stiffness=stiffness)
    with pytest.raises(RequestError, match=f"at most at stiffness .* \\(here {restitution:.3g}"):
        critical_angle(case, engine=engine)
    assert engine.jobs == []
    # where it is run all the same, the grain is in flight where it is judged
    with pytest.raises(RequestError, match="in flight"):
        critical_angle_by_passage(lambda cases: measured(Reference(), cases, "passage"), case)


@pytest.mark.parametrize("tail", ["attractive", "clipped"])
@pytest.mark.parametrize("stiffness", [1e5, 1e6, 1e7, 1e8])
def test_what_is_not_refused_before_is_not_refused_after(tail, stiffness):
    def allowed(by, steps):
        contact = Contact(damping_ratio=by, tail=tail)
        case = Incline(contact=contact, steps_per_contact=steps, stiffness=stiffness)
        try:
            check_passage(case)
        except RequestError:
            return None
        return case

    for steps in (12.0, 15.0, 20.0, 30.0, 50.0, 100.0):
        cases = (allowed(by, steps) for by in np.arange(0.3, 0.9, 0.002))
        most = next(filter(None, cases))  # rebounds the most
        assert 0.28 < rebound(most.contact) < 0.336, steps
        found = critical_angle(most, engine=Reference(workers=1))
        assert found.value_deg > closed_form(), steps


def test_a_soft_contact_settles_later_is_judged_later_and_may_rebound_more():
    contact = Contact(restitution=0.39)
    soft = Incline(contact=contact, stiffness=1e4)
    assert most_restitution(soft) == pytest.approx(0.4)
    found = critical_angle(soft, engine=Reference())
    steady = critical_angle(soft, method="steady", engine=Reference())
    assert found.value_deg == pytest.approx(steady.value_deg, abs=steady.uncertainty_deg + 0.01)


@pytest.mark.parametrize("stiffness", [1e5, 1e6, 1e8])
def test_below_the_bound_the_grain_slides_where_it_is_judged_and_above_it_may_fly(stiffness):
    def touching(e):
        case = Incline(contact=Contact(restitution=e), stiffness=stiffness, steps_per_contact=100.0)
        angle = rigid_angle(e)
        cases = [case.replace(angle=angle, phase=phase / 8) for phase in range(8)]
        return [run.touching for run in measured(Reference(), cases, "passage")]

    bound = most_restitution(Incline(stiffness=stiffness))
    assert all(touching(bound - 0.005))
    assert not all(itertools.chain.from_iterable(touching(bound + by) for by in (0.02, 0.03, 0.04)))


def test_the_theory_and_the_adaptive_reference_hold():
    found = CASE.verification.run_solvers(Study())
    assert {check.verdict for check in found.checks} == {Verdict.PASS}
    assert len(found.checks) == 8
