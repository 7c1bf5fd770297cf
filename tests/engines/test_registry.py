import pytest

from harness.cases.incline.parameters import Incline
from harness.engines.contract import Engine
from harness.engines.registry import ENGINES, open_engine
from harness.errors import EngineCrashError, RequestError


def test_unknown_engine_is_named_with_those_that_exist():
    with pytest.raises(
        RequestError, match=r"^--engine 'granoo' is not known: must be one of lammps, .*reference"
    ):
        open_engine("granoo")


def test_lammps_is_known_and_opens_without_starting_anything():
    assert "lammps" in ENGINES
    with open_engine("lammps") as engine:
        assert engine.name == "lammps"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"lmp": "/no/such/lmp"}, r"--lmp '/no/such/lmp': no such executable"),
        ({"lmp": "sh", "launcher": "no-such-mpirun -np 2"}, r"--mpirun 'no-such-mpirun': no such"),
    ],
)
def test_program_that_is_missing_is_a_wrong_request(options, message):
    with pytest.raises(RequestError, match=message):
        open_engine("lammps", **options)


class HalfBroken(Engine):
    name = "half-broken"
    closed = False

    def identify(self):
        raise NotImplementedError

    def drops(self, cases):
        raise NotImplementedError

    def inclines(self, cases, route, *, every=None):
        return [EngineCrashError(f"{route}, {every}") if c.angle > 10 else c for c in cases]

    def towers(self, cases, duration, **options):
        raise NotImplementedError

    def close(self):
        self.closed = True


def test_measured_raises_the_first_error_and_passes_results_through():
    low, high = Incline(angle=5.0), Incline(angle=15.0)
    with HalfBroken() as engine:
        assert engine.measured([low, low], "steady") == [low, low]
        with pytest.raises(EngineCrashError, match="steady, None"):
            engine.measured([low, high], "steady")
    assert engine.closed
