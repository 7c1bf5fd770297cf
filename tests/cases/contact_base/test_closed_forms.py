"""Closed forms of the contact cases, held against the limit of small steps of the reference."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from harness.cases.contact.parameters import reduced_modulus
from harness.cases.contact.submodels import COHESIVE_FRICTION, TURNING
from harness.cases.oblique import INCIDENCES, LAWS, POISSON
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.verdicts import Kind
from harness.engines.lammps.engine import Lammps
from harness.theory.contact import partial_slip_rebound, stiffness_ratio, twisting_spin
from tests.cases.contact_base.limits import limits

NAMES = (
    *("head-on", "slip-to-roll", "incline-roll", "incline-rest", "twist", "bounce"),
    *("prescribed-motion", "pull-off", "drag", "heat", "moving-wall", "collision"),
)


def exact_trials(name):
    """Return the trials of a case that have a closed form."""
    case = get_case(name)
    trials = [trial for trial in case.trials("default") if case.closed_forms(trial.parameters)]
    return [pytest.param(case, one, id=f"{name}-{one.submodel}-{one.system}") for one in trials]


@pytest.mark.parametrize(("case", "trial"), [one for name in NAMES for one in exact_trials(name)])
def test_the_limit_of_the_reference_is_the_closed_form(case, trial):
    found = limits(case, trial.parameters)
    for name, value in case.closed_forms(trial.parameters).items():
        assert found[name].value == pytest.approx(value, rel=2e-4, abs=2e-4), name


ROLLS = {
    "rolling": "sds",
    "rolling_stiffness": 1e3,
    "rolling_damping": 0.5,
    "rolling_friction": 0.05,
}


@pytest.mark.parametrize(
    ("name", "changes", "exact"),
    [
        ("slip-to-roll", {}, set()),
        ("incline-roll", {}, set()),
        ("incline-roll", {"angle": 60.0}, {"acceleration_ratio"}),
    ],
)
def test_rolling_resistance_takes_away_the_closed_forms_that_it_changes(name, changes, exact):
    """The momentum about the floor falls by mu_r g / 2 of the time at most: it must be seen."""
    case = get_case(name)
    parameters = case.default.replace(**changes, **ROLLS)
    integrated = limits(case, parameters)
    found = case.closed_forms(parameters)
    assert set(found) == exact
    for quantity, value in case.closed_forms(case.default.replace(**changes)).items():
        same = integrated[quantity].value == pytest.approx(value, abs=1e-4)
        assert same == (quantity in exact), quantity


def hertz_less_pull_off(parameters, overlap):
    """Return force, pull-off force [N] and contact radius [m] of dmt."""
    modulus, radius = reduced_modulus(parameters), parameters.reduced_radius
    pull = 4.0 * math.pi * parameters.surface_energy * radius
    a = math.sqrt(radius * overlap)
    return 4.0 / 3.0 * modulus * a * overlap - pull, pull, a


def with_a_neck(parameters, overlap):
    """Return the same of jkr, whose radius is searched for between its fold and R*."""
    modulus, radius = reduced_modulus(parameters), parameters.reduced_radius
    gamma = parameters.surface_energy

    def excess(a):
        return a * a / radius - 2.0 * math.sqrt(math.pi * gamma * a / modulus) - overlap

    a = brentq(excess, (math.pi * gamma * radius**2 / (4.0 * modulus)) ** (1 / 3), radius)
    hertz = 4.0 / 3.0 * modulus * a**3 / radius
    pull = 3.0 * math.pi * gamma * radius
    return hertz - 4.0 * math.sqrt(math.pi * gamma * modulus * a**3), pull, a


@pytest.mark.parametrize(("name", "force_at"), [("dmt", hertz_less_pull_off), ("jkr", with_a_neck)])
def test_attraction_loads_the_limit_of_friction_and_a_dashpot_does_not(name, force_at):
    (one,) = (each for each in COHESIVE_FRICTION if each.law["normal"] == name)
    case = get_case("prescribed-motion")
    (trial,) = (each for each in case.trials("default", [one]) if each.system == "wall")
    p = trial.parameters
    left = (1.0 - p.lift) * p.overlap
    elastic, pull, a = force_at(p, left)
    # the dashpot pulls at a sphere that is lifted
    force = elastic - p.damping_coefficient * p.mass * a * p.lift * p.overlap / p.duration
    limit = p.friction * (elastic + 2.0 * pull)
    assert 1.2 * p.friction * force < limit
    expected = limits(case, p)["lifted_ratio"].value
    assert expected == pytest.approx(limit / force, rel=1e-6)


def test_rolling_holds_its_torque_while_twisting_slides():
    case = get_case("prescribed-motion")
    one = TURNING[0]
    (trial,) = (each for each in case.trials("default", [one]) if each.system == "wall")
    # a twist far enough to slide, wherever the one back has left the spring
    p = trial.parameters.replace(twisting_friction=2e-5)
    found = limits(case, p)
    assert found["twisting_ratio"].value == pytest.approx(-p.twisting_friction / p.radius)
    # the dashpot of rolling rests, and so does that of the tangential spring, under its own limit
    load = p.normal_stiffness * (1.0 - p.lift) * p.overlap
    spun = p.radius * p.turn / p.duration
    rested = found["held_ratio"].value - found["rolling_ratio"].value
    dashpots = p.rolling_damping + p.tangential_damping * p.damping_coefficient
    assert rested == pytest.approx(dashpots * spun / load, rel=1e-6)


def test_a_twist_slips_stops_and_swings_back():
    """With a dashpot as weak as that of an elastic swing: amplitude mu_t m g / sqrt(k I)."""
    inertia, k, limit = 4e-7, 1.0, 1e-5
    omega = (k / inertia) ** 0.5
    largest = limit / (k * inertia) ** 0.5

    def spin(time, start, c=0.0):
        return twisting_spin(time, start, inertia, (k, c), limit)

    assert spin(1.0 / omega, 0.5 * largest) == pytest.approx(0.5 * largest * np.cos(1.0))
    stops = 1e2 * largest * inertia / limit
    late = [spin(stops + t / omega, 1e2 * largest) for t in np.linspace(1.0, 21.0, 2001)]
    assert max(late) == pytest.approx(largest, rel=1e-4)
    assert min(late) == pytest.approx(-largest, rel=1e-4)
    assert spin(0.5 * stops, 1e2 * largest) == pytest.approx(50.0 * largest, rel=2e-2)
    # a quarter of critical damping: at rest after a few swings
    weak = 0.5 * (k * inertia) ** 0.5
    assert abs(spin(stops + 100.0 / omega, 1e2 * largest, weak)) < 1e-9 * largest
    with pytest.raises(ValueError, match="must be below critical damping"):
        spin(1.0, 1.0, 3.0 * (k * inertia) ** 0.5)


@pytest.mark.parametrize(
    "changes",
    [{"twisting_damping": 2e-3}, {"normal": "jkr", "youngs_modulus": 1e8, "surface_energy": 0.01}],
)
def test_a_twist_without_a_closed_form_has_a_value_at_equal_steps(changes):
    case = get_case("twist")
    p = case.default.replace(**changes, steps_per_contact=200)
    assert case.closed_forms(p) == {}
    found = case.references(p, Lammps.traits)
    assert {one.kind for one in found.values()} == {"equal steps"}


def test_each_law_is_a_finding_and_is_the_curve_where_all_slides():
    case = get_case("oblique")
    found = case.verification.run_solvers(Study("default"))
    assert [check.kind for check in found.checks] == [Kind.FINDING] * len(LAWS)
    expected = partial_slip_rebound(INCIDENCES, POISSON)
    # at its limit a slider recovers as the contact opens: a law of the total displacement slides
    # to the end while the rebound is beyond -2/3, one of its increments while it is beyond -1
    slides = 7.0 * stiffness_ratio(POISSON) - 2.0 / 3.0 < INCIDENCES
    assert slides.any()
    for law, check in zip(LAWS, found.checks, strict=True):
        apart = found.evidence[law] - expected
        assert apart[slides] == pytest.approx(0.0, abs=2e-4)
        assert abs(check.difference) == pytest.approx(np.abs(apart).max())
        # the laws are no bounds, but stay within half of mu v
        assert np.abs(apart).max() < 0.5
    assert not case.display.sections(None, found, {})
