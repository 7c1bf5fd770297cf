"""Submodels that act together, or are clipped, in LAMMPS: limits, and what ranks do to them."""

import pytest

from harness.cases.contact import invariance
from harness.cases.contact.submodels import TURNING
from harness.cases.contact.verification import verify_trials
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.known_defects import mark_known_defects
from harness.comparison.verdicts import Verdict
from harness.engines.lammps.engine import Lammps
from harness.store.baseline import known_defects

pytestmark = [pytest.mark.live, pytest.mark.usefixtures("lammps_here")]


@pytest.fixture(scope="module")
def lammps():
    with Lammps(workers=1) as engine:
        yield engine


def told(lammps, checks):
    return mark_known_defects(checks, known_defects(), {"lammps": lammps.identify().engine_version})


@pytest.mark.parametrize(
    ("name", "submodels"),
    [
        ("prescribed-motion", ("mindlin, dmt", "mindlin, jkr")),
        ("prescribed-motion", tuple(one.name for one in TURNING)),
        ("head-on", ("old hooke, clipped", "old hertz/history, clipped")),
    ],
)
def test_they_hold_from_the_default_level_on(lammps, name, submodels):
    case = get_case(name)
    chosen = [one for one in case.submodels if one.name in submodels]
    assert not [*case.trials("quick", chosen)]
    trials = [t for t in case.trials("default", chosen) if t.system in ("wall", "two spheres")]
    checks = told(lammps, verify_trials(case, lammps, Study("default"), trials).checks)
    assert {c.cell.submodel for c in checks if c.verdict is Verdict.PASS} == set(submodels)
    broken = {c.name for c in checks if c.verdict not in (Verdict.PASS, Verdict.FINDING)}
    # the torque at its limit, and in a pair that is tilted its part about other axes
    assert all("marshall" in name or "twisting sds, mindlin, jkr" in name for name in broken)
    assert not [name for name in broken if "_forth" in name and "marshall" not in name]
    assert not [c for c in checks if c.verdict is Verdict.FAIL]


def test_springs_of_rolling_turn_round_on_another_rank_which_is_known(lammps, monkeypatch):
    # four on fewer cores wait for one another: level full of the slow tests has them
    monkeypatch.setattr(invariance, "_most_ranks", lambda *_: 2)
    case = type(get_case("prescribed-motion"))()
    case.submodels = [one for one in TURNING if "marshall" not in one.name]
    case.systems = {"two spheres, turned": case.systems["two spheres, turned"]}
    checks = told(lammps, invariance.invariances(case, lammps, Study("full")))
    ranks = [check for check in checks if check.cell and check.cell.invariance == "2 ranks"]
    assert len(ranks) == len(case.submodels)
    if ranks[0].verdict is Verdict.NOT_TESTED:
        pytest.skip(ranks[0].note)
    assert {check.verdict for check in ranks} == {Verdict.KNOWN_DEFECT}
    assert all("rolling-turned-round-on-exchange" in check.note for check in ranks)
    # torques that turn round, no round-off
    assert all(check.value > 0.01 for check in ranks)
    assert not [check for check in checks if check.verdict is Verdict.FAIL]


def test_a_bounce_off_a_frozen_sphere_stays_on_the_axis_and_holds_to_a_millionth(lammps):
    case, names = get_case("bounce"), ("hooke, velocity", "hertz, viscoelastic", "old hooke")
    chosen = [one for one in case.submodels if one.name in names]
    trials = [t for t in case.trials("default", chosen) if t.system == "frozen sphere"]
    found = verify_trials(case, lammps, Study("default"), trials)
    assert {check.cell.submodel for check in found.checks} == set(names)
    assert {check.verdict for check in found.checks} == {Verdict.PASS}
    assert all(check.tolerance <= 1e-6 for check in found.checks)
    for one in found.evidence.refined:
        assert not one.motion.position[:, 0, :2].any()
