"""By which rules codes state the bulk law, and the dashpots of codes without a tail."""

import math

import pytest
from scipy.integrate import solve_ivp

from harness.cases.bulk.law import bulk_law, stated_law, with_tail
from harness.errors import Unsupported
from harness.theory.contact import damping_ratio
from tests.cases.bulk.doubles import CASES, StandIn

LAWS = {
    code: stated_law(StandIn("silo", code), bulk_law())
    for code in ("lammps", "liggghts", "yade", "kratos")
}


def test_lammps_and_liggghts_state_one_law_yade_and_kratos_others():
    assert LAWS["lammps"] == LAWS["liggghts"]
    assert LAWS["lammps"].law == bulk_law()
    springs = {code: (law.law.tangential, law.law.clipped) for code, law in LAWS.items()}
    assert springs["yade"] == ("mindlin/force", True)
    assert springs["kratos"] == ("mindlin_rescale/force", True)
    assert [code for code, law in LAWS.items() if law.lacks] == ["kratos"]


def test_springs_of_rolling_are_two_laws():
    laws = [
        stated_law(StandIn("heap", code), bulk_law(0.2, 0.1)) for code in ("lammps", "liggghts")
    ]
    assert laws[0] != laws[1]
    assert laws[0].rules == laws[1].rules
    assert not laws[0].lacks
    assert "rolling" in laws[1].lacks


def test_an_engine_without_declared_rules_has_a_law_of_its_own():
    class Silent(StandIn):
        def rules(self, _):
            raise Unsupported("it runs no scenes")

    law = stated_law(Silent("silo"), bulk_law())
    assert law.lacks == "its rules are not known: it runs no scenes"
    assert law != LAWS["lammps"]


def test_the_values_of_a_law_state_it_in_scripts():
    job = CASES["penetration"].job(CASES["penetration"].default)
    values = LAWS["kratos"].values(job.values)
    assert values["tangential"] == "mindlin_rescale/force"
    assert values["clipped"] == "yes"
    # sqrt(k_t/k_n) = sqrt(4 G*/E*) of nu = 0.2
    assert values["tangential_damping"] == pytest.approx((1.6 / 1.8) ** 0.5)
    for name in ("restitution", "steel_restitution"):
        assert values[name] == with_tail(job.values[name])
    same = [name for name in job.values if not name.endswith("restitution")]
    assert all(values[name] == job.values[name] for name in same)
    own = LAWS["lammps"].values(job.values)
    assert {name: own[name] for name in job.values} == job.values


def rebound(restitution, attracts):
    """Return the restitution of Hertz's spring with the dashpot of one that has a tail, or not.

    x'' = -x^1.5 - 2 sqrt(5/6) zeta sqrt(1.5) x^0.25 x' from x = 0 at speed 1, until the overlap is
    gone, or the force.
    """
    eta = 2.0 * math.sqrt(1.25) * damping_ratio(restitution)

    def force(_, state):
        x = max(state[0], 0.0)
        return [state[1], -(x**1.5) - eta * x**0.25 * state[1]]

    def over(time, state):
        x = max(state[0], 0.0)
        left = x if attracts else x**1.25 + eta * state[1]
        return 1.0 if time < 1e-3 else left

    over.terminal = True
    path = solve_ivp(
        force, (0, 50), [1e-12, 1.0], events=over, rtol=1e-10, atol=1e-12, max_step=0.05
    )
    return -path.y[1, -1]


@pytest.mark.parametrize("restitution", [0.3, 0.4, 0.45, 0.5, 0.8])
def test_a_restitution_without_a_tail_is_that_of_the_same_dashpot(restitution):
    """The fit is within 3e-4 of the restitution; a law with a tail would be off by far more."""
    stated = with_tail(restitution)
    assert rebound(stated, attracts=False) == pytest.approx(restitution, abs=3e-4)
    assert rebound(stated, attracts=True) == pytest.approx(stated, abs=1e-5)
    assert abs(rebound(restitution, attracts=False) - restitution) > 0.005
