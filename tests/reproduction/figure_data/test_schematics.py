import numpy as np
import pytest

from harness.reproduction import schematics
from harness.reproduction.claims import ClaimStatus
from harness.theory import incline
from harness.theory.incline import critical_angle


def test_quartier_system_to_scale():
    system, statement = schematics.quartier()
    assert statement.status is ClaimStatus.REPRODUCED
    assert system.angle_deg == critical_angle()
    heights = {name: at[1] for name, at in system.grains.items()}
    assert heights["C"] - heights["B"] == pytest.approx(incline.well_depth(system.angle_deg))
    assert np.diff(system.spheres, axis=0)[0] == pytest.approx(
        [np.cos(np.radians(system.angle_deg)), -np.sin(np.radians(system.angle_deg))]
    )


def test_another_well_is_not_reproduced(monkeypatch):
    depth = incline.well_depth
    monkeypatch.setattr(incline, "well_depth", lambda angle: 1.001 * depth(angle))
    statement = schematics.quartier()[1]
    assert statement.status is ClaimStatus.NOT_REPRODUCED


def test_force_diagrams():
    (before, after), statement = schematics.force_diagrams()
    assert statement.status is ClaimStatus.REPRODUCED
    assert before.velocity_before is None
    assert after.velocity_before == pytest.approx(before.state.velocity)
    assert before.state.sphere == pytest.approx(after.other)
    for state in (before.state, after.state):
        assert state.weight == pytest.approx([0, -1])
        assert state.velocity @ state.contact_force == pytest.approx(0, abs=1e-12)


def test_flight_before_the_shock_is_not_constant_contact(monkeypatch):
    """Above the bound of flight the contact would have to pull."""
    monkeypatch.setattr(schematics, "critical_angle", lambda: 16.0)
    statement = schematics.force_diagrams()[1]
    assert statement.status is ClaimStatus.NOT_REPRODUCED


def test_layers():
    (upright, packed), statement = schematics.layers()
    assert statement.status is ClaimStatus.CORRECTED
    assert len(upright.chain) == 1
    assert len(packed.chain) == schematics.LAYERS + 1
    assert upright.height == schematics.LAYERS
    assert packed.height == pytest.approx(schematics.LAYERS * np.sqrt(3) / 2)
    ends = packed.fixed[np.argmin(np.hypot(*(packed.fixed - packed.chain[-1]).T))]
    assert packed.chain[-1] == pytest.approx(ends)


def test_layers_without_any_chain_are_not_reproduced(monkeypatch):
    monkeypatch.setattr(incline, "close_packed", incline.towers)
    assert schematics.layers()[1].status is ClaimStatus.NOT_REPRODUCED
