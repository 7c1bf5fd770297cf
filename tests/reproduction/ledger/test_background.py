import math

import pytest

from harness.errors import EngineCrashError
from harness.reproduction.claims import PRINTED, ClaimStatus
from harness.reproduction.ledger import background
from harness.reproduction.ledger.background import (
    angles_at,
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


def test_angles_in_mfix_s_scheme_cross_the_closed_form_as_the_step_is_refined():
    coarse, fine = angles_at(50), angles_at(5000)
    assert all(coarse < critical_angle())
    assert all(critical_angle() < fine)
    assert list(fine) == sorted(fine, reverse=True)  # its bias falls with stiffness


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
