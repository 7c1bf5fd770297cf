"""Kratos itself, where it is installed, and the cases whose output was recorded."""

from importlib.util import find_spec
from pathlib import Path

import pytest

from harness.cases.drop.case import Drop
from harness.cases.incline.system import Incline
from harness.engines.kratos.engine import Kratos
from harness.engines.output import Output, read_csv, results_in
from harness.engines.programs import with_stages
from harness.observables.provenance import Provenance
from harness.parameters.law import PLASTIC
from harness.parameters.tower import Tower

RECORDED = Path(__file__).parent / "recorded"


@pytest.fixture(scope="session")
def recorded():
    """Return a function that reads a recorded output by name, its series damaged or not."""

    def read(name, series=lambda text: text):
        log, table = ((RECORDED / f"{name}.{end}").read_text("utf-8") for end in ("txt", "csv"))
        tables = {"series": read_csv(series(table), Kratos.traits.title)}
        return with_stages(Output(results_in(log), Provenance("kratos", "10.4.4"), tables, log))

    return read


@pytest.fixture(scope="session")
def recorded_drop():
    return Drop(
        contact=PLASTIC, steps_per_contact=200.0, gap=1e-3, speed=1.0, duration=2.0, every=20
    )


@pytest.fixture(scope="session")
def recorded_incline():
    return Incline(contact=PLASTIC, angle=10.3, stiffness=1e5, steps_per_contact=50.0)


@pytest.fixture(scope="session")
def recorded_tower():
    return Tower(height=2, law="overlap", stiffness=1e5)


@pytest.fixture(scope="session")
def kratos_here():
    """Skip, with the reason, where this Python has no Kratos."""
    for name in ("KratosMultiphysics", "KratosMultiphysics.DEMApplication"):
        try:
            found = find_spec(name) if "." not in name else _application()
        except ImportError:
            found = None
        if found is None:
            pytest.skip(f"{name} is not installed (pip install KratosDEMApplication)")


@pytest.fixture(scope="session")
def kratos(kratos_here):  # noqa: ARG001
    with Kratos() as engine:
        yield engine


def _application():
    """Return where the DEM application is, without importing Kratos: it prints."""
    package = find_spec("KratosMultiphysics")
    folder = Path(package.origin).parent / "DEMApplication"
    return folder if folder.is_dir() else None
