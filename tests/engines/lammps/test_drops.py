"""LAMMPS on one fixed sphere: the path of the reference DEM, and what goes wrong."""

import numpy as np
import pytest

from harness.cases.drop.case import Drop, read, run_drops
from harness.engines.lammps.engine import Lammps
from harness.engines.output import Output, read_csv
from harness.engines.reference import Reference
from harness.errors import EngineInputError, EngineNaNError, EngineOutputError
from harness.observables.provenance import Provenance
from harness.parameters.law import CLIPPED, PLASTIC, SOURCE

HEAD = "time_s,x_m,y_m,vx_m_per_s,vy_m_per_s\n"
ROWS = "0,0,1.1,0,-1\n0.1,0,1.0,0,-1\n0.2,0,0.9,0,-1\n"
THREE = Drop(steps_per_contact=2.0, duration=1.0)


WHO = Provenance("lammps", "1 Jan 2030")


def drop(series, title="LAMMPS"):
    """Return the drop that a series tells of."""
    tables = {"series": read_csv(series, title, rising=True)}
    return read(THREE, Output((), WHO, tables, title=title))


def test_a_series_is_read_as_a_path():
    path = drop(HEAD + ROWS).path
    assert path.y_m.tolist() == [1.1, 1.0, 0.9]
    assert path.vy_m_per_s.tolist() == [-1.0] * 3


def test_rows_that_are_there_twice_are_read_once():
    first, _ = ROWS.split("\n", 1)
    assert drop(HEAD + first + "\n" + ROWS).path.y_m.tolist() == [1.1, 1.0, 0.9]


@pytest.mark.parametrize(
    ("series", "error", "words"),
    [
        ("", EngineOutputError, "series without rows"),
        (HEAD, EngineOutputError, "series without rows"),
        (HEAD + ROWS[:25], EngineOutputError, "cut in its last row"),
        (HEAD + ROWS[:-5], EngineOutputError, "cut in its last row"),
        (HEAD + ROWS[:-5] + "\n", EngineOutputError, "incomplete series"),
        (HEAD + ROWS[:15] + "\n", EngineOutputError, "LAMMPS left"),
        (HEAD + ROWS.replace("1.1", "nan"), EngineNaNError, "not numbers"),
    ],
)
def test_a_series_that_is_cut_or_damaged_is_named(series, error, words):
    with pytest.raises(error, match=words):
        drop(series)


def test_a_series_that_is_cut_is_named_with_the_engine_that_left_it():
    with pytest.raises(EngineOutputError, match="LIGGGHTS left 2 rows of a series of 3"):
        drop(HEAD + "\n".join(ROWS.splitlines()[:2]) + "\n", "LIGGGHTS")


def test_a_run_that_is_refused_costs_only_itself_and_keeps_its_log(script_file):
    path = script_file(
        'if [ "$1" = -h ]; then echo "LAMMPS (1 Jan 2030)"; '
        'printf "Installed packages:\\n\\nGRANULAR \\n\\n"; exit; fi\n'
        'echo "ERROR: Illegal model type" > 0.log; exit 1\n'
    )
    with Lammps(lmp=path, workers=1) as engine:
        (found,) = run_drops(engine, [THREE])
    assert isinstance(found, EngineInputError)
    assert "drop.in" in found.log
    assert "Illegal model type" in found.log


@pytest.mark.live
@pytest.mark.parametrize("contact", [SOURCE, CLIPPED, PLASTIC], ids=lambda c: c.name)
@pytest.mark.parametrize(
    "case",
    [
        Drop(speed=1.0, gap=0.01, duration=5.0, steps_per_contact=200.0),
        Drop(gravity=9.81, sideways=0.5, gap=-1e-4, duration=5.0, steps_per_contact=200.0),
        Drop(diameter=3e-3, density=2500.0, gravity=9.81, gap=1e-6, steps_per_contact=100.0),
    ],
    ids=["head-on", "oblique", "3 mm"],
)
def test_lammps_goes_where_the_reference_goes(in_process, contact, case):
    case = case.replace(contact=contact)
    (lammps,), (reference,) = run_drops(in_process, [case]), run_drops(Reference(), [case])
    scale = max(1.0, float(np.abs(reference.path.speed_m_per_s).max()))
    for name, unit in (("time_s", 1.0), ("y_m", case.diameter), ("vy_m_per_s", scale)):
        a, b = getattr(lammps.path, name), getattr(reference.path, name)
        assert np.abs(a - b).max() < 1e-12 * unit


@pytest.fixture(scope="module")
def in_process():
    with Lammps() as engine:
        yield engine
