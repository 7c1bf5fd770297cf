"""What is Kratos's own: a Python without it, and its integrators."""

import pytest

from harness.engines.kratos.engine import Kratos
from harness.engines.process import Ended
from harness.engines.registry import open_engine
from harness.errors import EngineMissingError, RequestError


def test_a_python_without_kratos_is_named_with_the_remedy():
    said = "Traceback:\nModuleNotFoundError: No module named 'KratosMultiphysics'"
    with Kratos() as engine:
        error = engine.error_of(Ended(said, 1, 0.1, False), "")
    assert isinstance(error, EngineMissingError)
    assert "pip install KratosDEMApplication" in str(error)


def test_an_option_of_an_integrator_that_it_lacks_is_refused():
    with pytest.raises(RequestError, match=r"kratos\.scheme"):
        open_engine("kratos", options={"scheme": "Forward_Euler"})
