"""Cases of single contacts beyond impacts: what they refuse, and planted faults that turn them."""

import pytest

from harness.cases.registry import get_case
from harness.comparison.verdicts import Verdict
from harness.errors import RequestError
from harness.parameters.rules import Rules
from harness.workflows.case_runs import run
from tests.cases.contact_base.perturbed import rows_of


@pytest.mark.parametrize(
    ("name", "settings", "message"),
    [
        ("incline-rest", {"rolling": "none"}, r"rolling = 'none': must be sds in this case"),
        ("incline-rest", {"rolling_friction": "0"}, r"rolling_friction = 0\.0: must be greater"),
        ("collision", {"partner": "wall"}, r"partner = 'wall': must be one of sphere in this case"),
        ("collision", {"partner_share": "11"}, r"partner_share = '11': must be .*equal to 10"),
        ("collision", {"partner_radius": "1e5"}, r"partner_radius = .*: must be"),
        ("incline-rest", {"angle": "90"}, r"angle = '90' deg: must be .*less than 90"),
    ],
)
def test_values_without_a_meaning_are_refused(name, settings, message):
    with pytest.raises(RequestError, match=message):
        run(name, settings)


@pytest.mark.parametrize(
    ("name", "system", "coefficient"),
    [
        ("incline-rest", "wall, rests", "rolling_stiffness"),
        ("incline-rest", "wall, rests", "rolling_damping"),
        ("incline-rest", "wall, rolls", "rolling_friction"),
        ("incline-rest", "wall, rests", "tangential_stiffness"),
        ("collision", "size ratio 100", "normal_stiffness"),
        ("collision", "size ratio 100", "friction"),
    ],
)
def test_a_percent_of_a_coefficient_turns_a_row(name, system, coefficient):
    case = get_case(name)
    trial = next(one for one in case.trials("default") if one.system == system)
    rows = rows_of(case, trial, coefficient, "quick")
    assert Verdict.FAIL in {row.verdict for row in rows}
    exact = rows_of(case, trial, coefficient, "quick", factor=1.0)
    assert {row.verdict for row in exact} == {Verdict.PASS}


@pytest.mark.parametrize("fault", ["partner_density", "partner_radius", "partner_share"])
def test_another_partner_or_frame_is_seen(fault):
    """What is relative stays in every frame; masses and sizes are those that were asked for."""
    case = get_case("collision")
    systems = {one.system: one.parameters for one in case.trials("default", case.submodels[:1])}
    name = "size ratio 10" if fault == "partner_radius" else "unequal densities"
    parameters = systems[name]
    changed = parameters.replace(**{fault: 1.01 * getattr(parameters, fault)})
    before, after = (
        case.expected(one, Rules())["tangential_ratio"].value for one in (parameters, changed)
    )
    assert (abs(after - before) < 1e-12) == (fault == "partner_share")
    if fault != "partner_share":
        assert abs(after - before) > 1e-5
