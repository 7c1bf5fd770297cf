"""Kratos itself, where it is installed."""

from importlib.util import find_spec
from pathlib import Path

import pytest

from harness.engines.kratos.engine import Kratos


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
