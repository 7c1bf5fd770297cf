import numpy as np
import pandas as pd
import pytest

from harness.cases.tower.impulse import READINGS, angle_from_impulse_ratio, impulse_angles
from harness.observables.reference import PEYNEAU_ROUX
from harness.reproduction import figure_data
from harness.reproduction.claims import ClaimStatus


def table(**ratios):
    """Return a table of runs by stiffness, each a list of alpha over height."""
    rows = [
        {
            "height": n,
            "stiffness_N_per_m": float(k.removeprefix("k")),
            "speed_m_per_s": 2.0,
            "law": "deformable",
            "impulse_ratio": alpha,
            "window_s": 0.1,
            **{f"critical_angle_{r}_deg": angle_from_impulse_ratio(alpha, r) for r in READINGS},
        }
        for k, alphas in ratios.items()
        for n, alpha in enumerate(alphas, 1)
    ]
    return pd.DataFrame(rows)


FALLING = [1.0, 0.9, 0.6, 0.55, 0.55, 0.55]
RISING = [1.0, 0.9, 1.1, 0.56, 0.55, 0.55]
LATE = [*np.linspace(1.0, 0.56, 14), 0.55]


@pytest.mark.parametrize(
    ("runs", "status"),
    [
        ({"k1e5": FALLING}, ClaimStatus.REPRODUCED),
        ({"k1e5": FALLING, "k1e6": RISING}, ClaimStatus.CORRECTED),
        ({"k1e5": RISING}, ClaimStatus.NOT_REPRODUCED),
        ({"k1e5": LATE}, ClaimStatus.NOT_REPRODUCED),
        ({"k1e5": [1.0, 0.9, 0.85, 0.85]}, ClaimStatus.NOT_REPRODUCED),
    ],
)
def test_the_status_of_alpha_follows_from_the_table(runs, status):
    statement = figure_data.impulse_ratio(table(**runs))
    assert statement.status is status
    assert bool(statement.correction) == (status is not ClaimStatus.REPRODUCED)


@pytest.fixture(scope="module")
def frame():
    return impulse_angles(solver="exact", laws=("deformable",))


def test_alpha_of_the_six_runs(frame):
    statement = figure_data.impulse_ratio(frame)
    assert statement.status is ClaimStatus.CORRECTED
    assert "k = 1e5 N/m, 2 m/s: rises by 0.16 on its way" in statement.computed


def test_angles_of_the_six_runs(frame):
    told = figure_data.critical_angles(frame).computed
    assert "From 10.21 deg" in told
    assert "below the published 5.76" in told


def test_measured_layers_are_not_tested():
    statement = figure_data.thin_layers()
    assert statement.status is ClaimStatus.UNTESTABLE
    assert f"{PEYNEAU_ROUX.value}" in statement.computed


def test_energy_scaling(monkeypatch):
    scaling, statement = figure_data.energy_scaling()
    assert statement.status is ClaimStatus.REPRODUCED
    flat = scaling.assign(critical_angle_lost_deg=6.0)
    monkeypatch.setattr(figure_data, "energy_scaling_angles", lambda: flat)
    assert figure_data.energy_scaling()[1].status is ClaimStatus.NOT_REPRODUCED


@pytest.fixture(scope="module")
def structure():
    return figure_data.structure_window()


def test_the_structure_window_exists_for_short_towers_only(structure):
    frame, statement = structure
    assert statement.status is ClaimStatus.CORRECTED
    exists = frame.dropna().groupby(["law", "held"])["height"].apply(list)
    assert exists["deformable", figure_data.LITERAL] == [1, 2, 3, 4]
    assert exists["overlap", figure_data.LITERAL] == [1, 2, 3]
    assert exists["deformable", figure_data.LOOSER] == [1, 2, 3, 4, 5, 6]


def test_the_literal_structure_window_is_that_of_the_impulse_table(structure):
    frame, _ = structure
    table = impulse_angles(
        heights=range(1, 7), stiffnesses=(1e6,), speeds=(2.0,), windows=("structure",),
        solver="exact",
    )  # fmt: skip
    ours = frame[frame["held"] == figure_data.LITERAL].set_index(["law", "height"]).sort_index()
    theirs = table.set_index(["law", "height"]).sort_index()
    assert ours["impulse_ratio"].to_numpy() == pytest.approx(
        theirs["impulse_ratio"].to_numpy(), nan_ok=True
    )


def test_window_selection(monkeypatch):
    choices, statement = figure_data.window_selection()
    assert statement.status is ClaimStatus.REPRODUCED
    for choice in choices:
        run = choice.run
        sampled = run.time_over_t0[int(run.compression.argmax())]
        assert choice.largest_compression == pytest.approx(sampled, abs=2e-3)
        assert choice.structure > 1
    assert [c.run.tower.particles for c in choices] == [3, 4]
    assert choices[0].largest_compression == pytest.approx(1.147, abs=5e-4)
    monkeypatch.setattr(figure_data, "SEARCH", 1.0)
    assert figure_data.window_selection()[1].status is ClaimStatus.NOT_REPRODUCED
