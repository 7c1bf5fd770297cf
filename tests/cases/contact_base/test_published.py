"""The literature's curves of impacts with friction, against the integration of the laws."""

import numpy as np
import pytest

from harness.cases.contact import report
from harness.cases.contact.impact import ANGLES, published
from harness.cases.contact.limits import Failed
from harness.cases.contact.submodels import PLAIN, SYSTEMS, TANGENTIAL, TANGENTIAL_BESIDE, Trial
from harness.cases.registry import get_case
from harness.parameters.rules import Rules
from harness.theory.contact import partial_slip_rebound, slides_throughout, stiffness_ratio

SUBMODELS = {one.name: one for one in (*TANGENTIAL, *TANGENTIAL_BESIDE)}


def told(case, name, system="wall", **changes):
    law = {**PLAIN, **SUBMODELS[name].law, **SYSTEMS[system], **changes}
    return get_case(case).default.replace(**law, steps_per_contact=400)


def tried(case, parameters, system):
    """Return a trial that left nothing, under the default rules."""
    trial = Trial("some", system, parameters)
    references = get_case(case).expected(parameters, Rules())
    return Failed(trial, references, Rules(), parameters, "", "left no finite value")


@pytest.mark.parametrize("case", ["oblique", "spin"])
@pytest.mark.parametrize(
    ("name", "sticking"),
    [
        ("linear_history, 2/7, elastic", 2e-3),
        ("linear_nohistory", 5e-3),
        ("linear_history", 0.1),  # the dashpot's pull cuts the spring back
        # these stick as a whole, and so are off the curve where a part would slip
        ("mindlin_rescale/force, elastic", None),
        ("mindlin", None),
    ],
)
@pytest.mark.parametrize("system", ["wall", "unequal spheres"])
def test_a_page_shows_the_law_on_the_curve(monkeypatch, case, name, sticking, system):
    monkeypatch.setattr(report, "ANGLES", np.array([5.0, 85.0]))
    # slow: the normal turns little while the spheres pass each other, as it does for the curve
    one = tried(case, told(case, name, system, speed=0.01), system)
    plot = report.trial_plot(get_case(case), one, "TOY")
    law, known = plot.lines
    assert plot.group == system
    assert known.name.startswith("Walton" if name.startswith("linear") else "Maw")
    sticks, slides = np.interp(law.x, known.x, known.y)
    # a dashpot alone sticks at first and at last, at any angle
    assert law.y[1] == pytest.approx(slides, abs=0.05 if name == "linear_nohistory" else 2e-3)
    if sticking is not None:
        assert law.y[0] == pytest.approx(sticks, abs=sticking)
    assert "no point" in plot.caption
    assert ("mu (1 + e) / 2" in plot.caption) == (name == "mindlin")  # the other dissipates nothing


def test_an_elastic_linear_contact_that_sticks_is_on_the_branch():
    # k_t = 2/7 k_n: the slip comes back as it went, and the centre keeps 3/7 of its velocity
    for angle in (2.0, 10.0):
        parameters = told("oblique", "linear_history, 2/7, elastic", angle=angle)
        expected = get_case("oblique").expected(parameters, Rules())["tangential_ratio"].value
        assert expected == pytest.approx(3.0 / 7.0, abs=1e-3)
    found = published(parameters, 1.0)
    assert 1.0 - 2.0 / 7.0 * (1.0 - found.ratio[0]) == pytest.approx(3.0 / 7.0, abs=1e-12)


@pytest.mark.parametrize("restitution", [1.0, 0.5])
def test_partial_slip_is_the_computed_curve_and_coulombs_beyond(restitution):
    parameters = told("oblique", "mindlin, elastic")
    mu, kappa = parameters.friction, stiffness_ratio(parameters.poisson_ratio)
    found = published(parameters, restitution)
    incidence = np.tan(np.radians(found.angles))
    slides = incidence > slides_throughout(mu, restitution)
    assert 10 < slides.sum() < slides.size - 10
    beyond = 1.0 - slides_throughout(mu, restitution) / incidence[slides]
    assert found.ratio[slides] == pytest.approx(beyond, abs=1e-12)
    psi = kappa / (0.5 * mu * (1.0 + restitution)) * incidence
    below = slice(0, 30)
    assert found.ratio[below] * psi[below] == pytest.approx(
        partial_slip_rebound(psi[below], parameters.poisson_ratio), abs=1e-12
    )
    assert np.all(np.diff(found.angles) > 0.0)
    assert found.angles[0] >= ANGLES[0]
    assert ("no dashpot" in found.source) == (restitution < 1.0)


@pytest.mark.parametrize(
    "changes",
    [
        {"friction": 0.0},
        {"damping": "viscoelastic", "damping_coefficient": 1.0},
    ],
)
def test_there_is_none_without_friction_or_a_closed_form(changes):
    assert published(told("oblique", "linear_history"), 0.9) is not None
    assert published(told("oblique", "linear_history").replace(**changes), 0.9) is None


@pytest.mark.parametrize("name", ["linear_history", "mindlin"])
def test_a_curve_of_a_long_run_has_no_more_points_than_a_page_needs(name):
    case = get_case("slip-to-roll")
    parameters = told("slip-to-roll", name).replace(steps_per_contact=1600)
    plot = report.trial_plot(case, tried("slip-to-roll", parameters, "wall"), "TOY")
    for line in plot.lines:
        assert report.POINTS <= len(line.x) <= 5 * report.POINTS
        assert not line.marked
