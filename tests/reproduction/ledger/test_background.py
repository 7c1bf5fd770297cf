import math

import pytest

from harness.errors import EngineCrashError
from harness.reproduction.claims import PRINTED, ClaimStatus
from harness.reproduction.ledger import background
from harness.reproduction.ledger.background import (
    angles_by_step,
    depth_of_well,
    fate_angle,
    height,
    stiffness_of_springs,
)
from harness.reproduction.ledger.samples import integrate
from harness.theory.contact import duration_clipped, restitution_clipped, restitution_unclipped
from harness.theory.incline import critical_angle, gain_per_crest, well_depth


@pytest.mark.parametrize("angle", [0.0, 10.2078, 29.0])
def test_heights_from_coordinates_are_those_of_the_energy_map(angle):
    assert depth_of_well(angle) == pytest.approx(well_depth(angle), abs=1e-14)
    drop = height(0, 0, angle) - height(1, 0, angle)
    assert drop == pytest.approx(gain_per_crest(angle), abs=1e-14)


@pytest.mark.parametrize("shock", [0.1, 0.25, 0.6])
def test_bisected_fate_is_the_closed_form(shock):
    assert fate_angle(shock) == pytest.approx(critical_angle(shock), abs=2e-6)


def test_recorded_angles_cross_the_closed_form_as_the_step_is_refined():
    angles = angles_by_step()
    assert sorted(angles) == [1e5, 1e6, 1e7]
    for by_step in angles.values():
        assert sorted(by_step) == [50, 500, 5000]
        assert by_step[50] < critical_angle() < by_step[5000]
        assert by_step[50] < by_step[500] < by_step[5000]
    # the bias of the fine step falls with stiffness
    fine = [angles[k][5000] - critical_angle() for k in sorted(angles)]
    assert fine == sorted(fine, reverse=True)


@pytest.mark.parametrize("zeta", [0.0, 0.1, 0.7, 0.95])
def test_integrated_contact_is_the_closed_form(zeta):
    kept, clipped = integrate(4.0, 1.0, 4 * zeta), integrate(4.0, 1.0, 4 * zeta, "released")
    assert kept.restitution == pytest.approx(restitution_unclipped(zeta), abs=1e-8)
    assert kept.time == pytest.approx(math.pi / math.sqrt(1 - zeta**2) / 2, rel=1e-6)
    assert clipped.restitution == pytest.approx(restitution_clipped(zeta), abs=1e-8)
    assert clipped.time == pytest.approx(duration_clipped(zeta) / 2, rel=1e-8)


def test_springs_in_series():
    assert [stiffness_of_springs(n) for n in (1, 2, 5)] == pytest.approx([1, 1 / 2, 1 / 5])


class DeadEngine:
    """Fails in every run, as an engine whose program crashes."""

    def run(self, jobs):
        raise EngineCrashError(f"{len(jobs)} runs, killed by signal 11")


def test_an_engine_that_dies_is_the_reason_of_its_rows_and_of_no_others():
    rows = {
        row.source.key: row
        for row in background.background_incline_statements(PRINTED, DeadEngine())
    }
    for key in ("text-lammps-angle", "text-lammps-step", "text-restitution-angle"):
        assert rows[key].status is ClaimStatus.UNTESTABLE
        assert "signal 11" in rows[key].why
    assert rows["text-rest-angle"].status is ClaimStatus.REPRODUCED
