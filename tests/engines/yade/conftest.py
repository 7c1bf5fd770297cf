"""Yade itself where it is, recorded output of it, and the cases that were recorded."""

import shutil
from pathlib import Path

import pytest

from harness.cases.drop.case import Drop
from harness.cases.incline.system import Incline
from harness.engines.output import Output, read_csv, results_in
from harness.engines.programs import with_stages
from harness.engines.yade.engine import Yade
from harness.observables.provenance import Provenance
from harness.parameters.law import PLASTIC
from harness.parameters.tower import Tower

RECORDED = Path(__file__).parent / "recorded"
WHO = Provenance("yade", "1970.01a")


@pytest.fixture(scope="session")
def incline():
    return Incline(angle=10.5, contact=PLASTIC, stiffness=1e5)


@pytest.fixture(scope="session")
def drop():
    contact = PLASTIC.replace(name="e = 0.5", damping_ratio=None, restitution=0.5)
    return Drop(contact=contact, speed=1.0, steps_per_contact=100.0, duration=2.0, every=20)


@pytest.fixture(scope="session")
def tower():
    return Tower(height=2, law="overlap", stiffness=1e5)


@pytest.fixture(scope="session")
def recorded():
    """Return a function that reads a recorded output by name, as it is or damaged."""

    def read(name, text=lambda text: text, series=lambda text: text):
        log = text((RECORDED / f"{name}.txt").read_text(encoding="utf-8"))
        path = RECORDED / f"{name}.csv"
        tables = {}
        if path.is_file():
            tables["series"] = read_csv(series(path.read_text(encoding="utf-8")), Yade.traits.title)
        return with_stages(Output(results_in(log), WHO, tables, log, seconds=1.0))

    return read


@pytest.fixture(scope="session")
def yade():
    """Return Yade, ready to run; skip with the reason where there is none."""
    if shutil.which("yade") is None:
        pytest.skip("no Yade on PATH")
    with Yade(workers=2) as engine:
        yield engine
