"""Recorded MFiX beside the reference DEM: which of it is judged at which level."""

import pytest
from harness.comparison.engine_evidence import EngineEvidence
from harness.workflows.verification.other_engines.recorded_mfix import recorded_checks

from harness.comparison.verdicts import Verdict


@pytest.mark.parametrize(("level", "judged", "coarse"), [("quick", 1, 0), ("full", 6, 3)])
def test_fine_steps_are_judged_and_coarse_ones_are_findings(level, judged, coarse):
    evidence = EngineEvidence(10.2078)
    angles = [c for c in recorded_checks(level, evidence) if "angle" in c.name]
    verdicts = [check.verdict for check in angles]
    assert verdicts.count(Verdict.PASS) == judged
    assert verdicts.count(Verdict.FINDING) == coarse
    assert len(verdicts) == judged + coarse == len(evidence.angles)
    assert all(angle.integrator == "mfix-euler" for angle in evidence.angles)
    assert all(abs(angle.off_reference_deg) <= 0.003 for angle in evidence.angles)


def test_recorded_towers_are_held_at_their_own_times():
    evidence = EngineEvidence(10.2078)
    rows = [check for check in recorded_checks("quick", evidence) if "tower" in check.name]
    assert {check.verdict for check in rows} == {Verdict.PASS}
    assert [tower.height for tower in evidence.towers] == [1, 2, 4, 9]
    # eight digits, and gravity half a step late
    assert all(abs(tower.peak_error) < 5e-6 for tower in evidence.towers)
