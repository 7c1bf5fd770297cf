import math

import numpy as np
import pytest

from harness.cases.tower.run import tower
from harness.observables.tower import significant_contacts
from harness.parameters.tower import Tower
from harness.reproduction import schematics
from harness.reproduction.claims import ClaimStatus


@pytest.fixture(scope="module")
def found():
    schematics.towers_in_time.cache_clear()
    evidence, in_time = schematics.force_and_contacts()
    return evidence, (in_time, schematics.separated()[1])


def test_events_of_three_particles(found):
    """By another solver, and against the numbers of the source's own law."""
    evidence, (statement, _) = found
    assert statement.status is ClaimStatus.REPRODUCED
    told = schematics.event_times(evidence.by_height[1])
    assert told == pytest.approx([0.424, 0.607, 0.990, 1.573], abs=1e-3)
    rk4 = tower(Tower(height=2), solver="rk4", profiles=True)
    assert schematics.event_times(rk4) == pytest.approx(told, abs=2e-3)


def test_events_of_the_overlap_law_is_another(monkeypatch):
    """A perturbed law changes the verdict."""
    monkeypatch.setattr(schematics, "Tower", lambda height: Tower(height=height, law="overlap"))
    schematics.towers_in_time.cache_clear()
    _, statement = schematics.force_and_contacts()
    schematics.towers_in_time.cache_clear()
    assert statement.status is ClaimStatus.NOT_REPRODUCED


def test_a_grain_that_never_comes_back_has_no_events():
    run = tower(Tower(height=2), solver="exact", duration=0.9, profiles=True)
    told = schematics.event_times(run)
    assert math.isnan(told.back)
    assert math.isnan(told.leaves)
    with pytest.raises(ValueError, match="three particles"):
        schematics.event_times(tower(Tower(height=3), solver="exact"))


def test_the_largest_force_is_that_of_all_heights(found):
    evidence, _ = found
    assert evidence.largest_force == pytest.approx(
        Tower().gravity + math.sqrt(Tower().gravity ** 2 + 1e6 * 4), rel=1e-5
    )
    assert max(r.grain_force.max() for r in evidence.by_height) == evidence.largest_force


def test_the_base_is_felt_later_in_longer_chains(found):
    evidence, (_, statement) = found
    assert statement.status is ClaimStatus.REPRODUCED
    assert list(evidence.base_felt[:3]) == sorted(evidence.base_felt[:3])
    assert evidence.base_felt[3] == math.inf


def test_the_base_is_not_felt_before_the_chain_reaches_it(found):
    """Another route: a contact with the base is needed, whose force is in the profiles."""
    evidence, _ = found
    for run, felt in zip(evidence.separated[1:3], evidence.base_felt[1:3], strict=True):
        reached = run.time_over_t0[np.flatnonzero(significant_contacts(run) == run.tower.height)[0]]
        assert felt >= reached


def test_a_base_that_is_felt_in_20_particles_changes_the_verdict(found):
    evidence, _ = found
    felt = (*evidence.base_felt[:3], 1.4)
    statement = schematics.separation(evidence.separated, felt)
    assert statement.status is ClaimStatus.NOT_REPRODUCED


def test_collapse():
    runs, statement = schematics.collapse()
    assert statement.status is ClaimStatus.REPRODUCED
    assert [run.tower.each("stiffness")[0] for run in runs] == [1e5, 1e6, 1e7]


def test_without_gravity_the_collapse_is_exact_and_of_other_heights_there_is_none():
    def run(height, stiffness, gravity):
        case = Tower(height=height, stiffness=stiffness, gravity=gravity)
        return tower(case, solver="exact", profiles=True)

    bare = schematics.judged((run(9, 1e5, 0.0), run(9, 1e6, 0.0)))
    assert bare.status is ClaimStatus.REPRODUCED
    left = float(bare.computed.rsplit("neighbours is ", 1)[1].removesuffix(" %."))
    # t0 is the same half-wave for both, so only the grids' rounding is left
    assert left < 1e-3
    mixed = schematics.judged((run(9, 1e5, 9.81), run(1, 1e6, 9.81)))
    assert mixed.status is ClaimStatus.NOT_REPRODUCED
