"""Critical angles of engines beside the main one, with stand-ins: rows and evidence."""

import math
from dataclasses import replace

import pytest

from harness.cases.incline.angle import critical_angle
from harness.cases.incline.case import CASE
from harness.cases.incline.engine_checks import (
    reference_for,
    same_rules,
)
from harness.cases.incline.levels import STATED
from harness.cases.incline.system import Incline
from harness.cases.verification import Study
from harness.comparison.verdicts import Kind, Verdict
from harness.engines.reference import Reference
from harness.parameters.law import CLIPPED
from tests.engine_doubles import TRAITS, Clamped, Crashing, Half, Twin, frictionless


@pytest.fixture(scope="module")
def found():
    study = Study("quick")
    engines = (Reference(), Twin(), Clamped(), Half(), Crashing())
    return {
        engine.name: CASE.verification.run(engine, replace(study, role="other"))
        for engine in engines
    }


def row(found, *words):
    rows = [check for one in found.values() for check in one.checks]
    (only,) = [c for c in rows if all(word in c.name for word in words)]
    return only


def test_an_engine_that_holds_has_no_failed_row(found):
    for engine in ("reference", "twin", "clamped", "half"):
        assert Verdict.FAIL not in {check.verdict for check in found[engine].checks}


def test_the_plastic_contact_is_judged_by_the_closed_form_and_the_source_s_is_a_finding(found):
    plastic = row(found, "twin: critical angle, plastic")
    assert (plastic.kind, plastic.verdict) == (Kind.ANALYTIC, Verdict.PASS)
    assert plastic.tolerance == 0.003
    assert "k = 1e+06 N/m, 100 steps" in plastic.name
    source = row(found, "twin: critical angle, source")
    assert source.verdict is Verdict.FINDING
    assert source.difference > 0.01


def test_the_same_code_is_on_the_curve_of_the_reference_dem_to_the_last_bit(found):
    for engine in ("twin", "clamped", "half"):
        assert found[engine].evidence[0].off_reference_deg == 0.0
    assert row(found, "half: critical angle against", "m_eff m/2").verdict is Verdict.PASS


def test_an_engine_in_another_scheme_than_it_declares_is_off_the_curve():
    class Other(Clamped):
        traits = replace(TRAITS, integrator="mfix-euler", frictionless=frictionless(tail="clipped"))

        def __init__(self):
            super().__init__()
            self.integrator = "velocity-verlet"

    off = row(
        {"": CASE.verification.run(Other(), Study("quick", role="other"))},
        "against",
        "source, clipped",
    )
    assert off.verdict is Verdict.FAIL
    assert not off.engine_died


def test_what_an_engine_cannot_state_is_not_tested_with_the_reason(found):
    refused = row(found, "half: critical angle, plastic")
    assert refused.verdict is Verdict.NOT_TESTED
    assert "tail = attractive" in refused.note
    assert "tail = clipped" in row(found, "clamped: critical angle, source contact").note
    assert row(found, "clamped: critical angle, source, clipped").verdict is Verdict.FINDING


def test_a_dying_engine_leaves_failed_rows_with_its_log(found):
    died = [check for check in found["crashing"].checks if check.engine_died]
    assert {check.log for check in died} == {"input\nlast words\n"}
    assert all(check.note == "crashed: signal SIGSEGV" for check in died)
    names = " ".join(check.name for check in died)
    assert "plastic" in names
    assert "source" in names
    untested = row(found, "crashing: critical angle against", "plastic")
    assert untested.verdict is Verdict.NOT_TESTED


def test_engines_of_one_class_agree_and_classes_are_findings_beside_the_first(found):
    class Other(Twin):
        name = "other"
        traits = replace(TRAITS, lineage="")

    beside = {"other": CASE.verification.run(Other(), Study("quick", role="other")), **found}
    rows = {check.name: check for check in CASE.verification.compare(beside)}
    agree = rows["engines: twin against other, source contact, unclamped"]
    assert (agree.kind, agree.tolerance, agree.verdict) == (Kind.CROSS_CODE, 0.002, Verdict.PASS)
    apart = rows["engines: clamped, source, clipped contact, less other, source"]
    assert apart.verdict is Verdict.FINDING
    assert apart.expected == pytest.approx(apart.value, abs=1e-9)
    assert apart.value < -0.01
    assert "engines: half, source, m_eff m/2 contact, less other, source" in rows
    assert not any("reference" in name.partition(",")[0] for name in rows)


def test_the_reference_dem_follows_the_scheme_and_there_is_none_for_one_without():
    assert reference_for(Half.traits).integrator == "mfix-euler"
    assert reference_for(replace(TRAITS, integrator="")) is None

    class Own(Twin):
        traits = replace(TRAITS, integrator="", frictionless=frictionless(tail="clipped"))

    found = {"twin": CASE.verification.run(Own(), Study("quick", role="other"))}
    assert row(found, "critical angle against", "plastic").verdict is Verdict.NOT_TESTED
    assert all(math.isnan(angle.reference_deg) for angle in found["twin"].evidence)


@pytest.mark.parametrize(("digits", "least"), [(15, 5e-4), (6, 1.5e-3)])
def test_the_tolerance_beside_the_reference_grows_with_missing_digits(digits, least):
    stiffness, steps = STATED
    case = Incline(contact=CLIPPED, stiffness=stiffness, steps_per_contact=steps)
    with Reference() as engine:
        own = critical_angle(case, engine=engine, phases=2)
    width = same_rules(replace(TRAITS, digits=digits), own, 10.2078).width(0.0)
    assert least <= width < 2 * least
