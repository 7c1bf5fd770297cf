"""A cross-code row that fails says when the force left the tolerance about the reference."""

from dataclasses import replace

import numpy as np

from harness.cases.tower.run import tower
from harness.cases.tower.verification import CodeEvidence, against_exact
from harness.comparison.verdicts import Verdict
from harness.parameters.tower import Tower

CASE = Tower(height=2, law="overlap")


def exact(run):
    return tower(CASE, solver="exact", samples=run.time.size - 1, profiles=True)


def test_rows_that_hold_have_no_class():
    run, diverged = tower(CASE, solver="rk4", profiles=True), []
    rows = against_exact(run, exact(run), CodeEvidence(), diverged)
    assert {row.verdict for row in rows} == {Verdict.PASS}
    assert not any(row.triage for row in rows)
    assert diverged == []


def test_code_that_lets_go_of_a_contact_parts_late():
    """Without the second contact particle 2 is free: the force is missed as (omega t)^5 / 120.

    In units of k v0/omega, leading order of three particles; the peak is about 0.72 of it.
    """
    shorter = tower(CASE.replace(height=1, base="free"), solver="rk4", profiles=True)
    run, diverged = tower(CASE, solver="rk4", profiles=True), []
    force, velocity = (
        np.interp(run.time, shorter.time, values)
        for values in (shorter.grain_force, shorter.grain_velocity)
    )
    lost = replace(run, grain_force=force, grain_velocity=velocity)
    row, impulse, _ = against_exact(lost, exact(run), CodeEvidence(), diverged)
    assert row.verdict is Verdict.FAIL
    assert row.triage.startswith("diverged late: grain_force_over_peak")
    assert impulse.triage == row.triage
    (parted,) = diverged
    assert parted.reference_label == "exact"
    unit = CASE.stiffness * CASE.speed / CASE.omega

    def missed(time):
        return unit * (CASE.omega * time) ** 5 / 120

    width = parted.band * float(exact(run).grain_force.max())
    assert missed(parted.divergence.last_inside) < 1.1 * width
    assert missed(parted.divergence.time) > 0.9 * width
