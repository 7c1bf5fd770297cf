"""What LIGGGHTS does when it is used in the naive way, and that qualification sees it."""

import math

import pytest

from harness.cases.drop.case import TEMPLATE, Drop, run_drops
from harness.cases.qualification import qualify
from harness.comparison.verdicts import Verdict
from harness.engines.liggghts.engine import Liggghts
from harness.engines.scripts import Script
from harness.errors import EngineInputError
from harness.parameters.law import SOURCE, Contact

pytestmark = pytest.mark.live

HALF = Contact(restitution=0.5, damping_ratio=None)
POISSON = 0.25
BETWEEN = ("fix kn all", "pair_coeff * *")
HOOKE = """
fix young   all property/global youngsModulus peratomtype {young} {young}
fix poisson all property/global poissonsRatio peratomtype {poisson} {poisson}
fix speed   all property/global characteristicVelocity scalar 1
variable zeta2 equal v_damping/2/sqrt(v_stiffness*v_mass)
variable e equal exp(-PI*v_zeta2/sqrt(1-v_zeta2^2+1e-30))*(v_zeta2<1)
fix rest    all property/global coefficientRestitution peratomtypepair 2 $(v_e) $(v_e) $(v_e) $(v_e)
pair_style gran model hooke tangential off limitForce off
"""


@pytest.fixture
def with_script(liggghts, monkeypatch):
    """Return a function that has the engine run drops with another text."""

    def change(text):
        script = Script("drop.in", text, Liggghts.script(TEMPLATE).variables)
        monkeypatch.setattr(Liggghts, "script", classmethod(lambda *_: script))
        return liggghts

    return change


def young_for(stiffness, case):
    """Return Young's modulus that gives two mobile grains this stiffness under model hooke.

    k = (16/15 sqrt(R*) E*)^(4/5) (m_eff v^2)^(1/5), with v = 1 m/s, R* = d / 4 and
    m_eff = m / 2.
    """
    powered = stiffness / (0.5 * case.mass) ** 0.2
    effective = powered**1.25 * 15.0 / 16.0 / math.sqrt(0.25 * case.diameter)
    return 2.0 * (1.0 - POISSON**2) * effective


def hooke_text():
    text = Liggghts.script(TEMPLATE).text
    start, end = (text.index(word) for word in BETWEEN)
    young = young_for(1e6, Drop())
    return text[:start] + HOOKE.format(young=repr(young), poisson=POISSON) + text[end:]


def failed(found):
    return {
        check.name.partition(": ")[2]: check
        for check in found.checks
        if check.verdict is Verdict.FAIL
    }


def test_model_hooke_refuses_the_source_restitution(with_script):
    (run,) = run_drops(with_script(hooke_text()), [Drop(contact=SOURCE)])
    assert type(run) is EngineInputError
    assert "0.05 < coefficientRestitution <= 1 required" in str(run)
    assert "ERROR" in run.log


def test_model_hooke_is_stiffer_against_a_fixed_sphere_than_between_grains(with_script):
    """The effective mass doubles there, and the stiffness goes with its fifth root."""
    found = qualify(with_script(hooke_text()))
    assert not found.holds
    static = failed(found)["static contact, overlap over m g / k"]
    softer = 1e4 / 1e6  # the overlap at rest is measured at 1e4 N/m, Young's modulus is for 1e6
    assert static.value == pytest.approx(softer * 0.5**0.2, rel=1e-6)
    assert "refused" in failed(found)["restitution head-on, source"].note


def test_spheres_in_two_dimensions_are_discs_with_another_mass(with_script):
    """A disc of unit height: pi r^2 against 4/3 pi r^3, 3/2 of the mass at r = 1/2 m."""
    text = Liggghts.script(TEMPLATE).text.replace("dimension 3", "dimension 2")
    found = qualify(with_script(text.replace("boundary f f f", "boundary f f p")))
    assert not found.holds
    static = failed(found)["static contact, overlap over m g / k"]
    assert static.value == pytest.approx(1.5, rel=1e-6)


def test_as_the_harness_states_it_the_engine_qualifies(liggghts):
    found = qualify(liggghts)
    assert found.holds, found.failures
    assert len(found.checks) >= 10
