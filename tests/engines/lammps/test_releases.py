import subprocess
import sys

import pytest

from harness.cases.drop import CASE, read_path
from harness.cases.registry import get_case
from harness.engines.lammps.engine import Lammps
from harness.engines.process import Limits
from harness.engines.scripts import Script, Task

pytestmark = [pytest.mark.live, pytest.mark.slow]

RELEASES = {
    "2022.6.23.4.0": "23 Jun 2022 - Update 4",
    "2023.8.2.3.1": "2 Aug 2023 - Update 3",
    "2024.8.29.3.0": "29 Aug 2024 - Update 3",
}


def install(release, folder):
    """Make a virtual environment with one release; return the path of its lmp."""
    subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
    pip = [str(folder / "bin" / "python"), "-m", "pip", "install", "-q"]
    answer = subprocess.run(
        [*pip, f"lammps=={release}", "mpich"], capture_output=True, text=True, check=False
    )
    if answer.returncode != 0:
        pytest.skip(f"pip cannot install lammps=={release}: {answer.stderr.strip()[-200:]}")
    return str(folder / "bin" / "lmp")


@pytest.fixture(scope="module", params=RELEASES)
def release(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("release") / request.param
    return RELEASES[request.param], install(request.param, folder)


def run_committed(lmp, inputs):
    """Run the committed input as it stands; return the release and the path."""
    text = (inputs / "drop.in").read_text(encoding="utf-8")
    with Lammps(lmp=lmp, workers=1, limits=Limits(seconds=120)) as engine:
        who, job = engine.identify(), CASE.job(CASE.presets["head-on"])
        names = frozenset(engine.script(job.template).variables)
        values = {"series": "0.csv", **engine.task(job).values}
        (output,) = engine.execute([Task(job, Script("drop.in", text, names), values)])
    return who, read_path(CASE.presets["head-on"], output)


def test_committed_input_gives_the_same_in_every_release(release, lmp, inputs):
    greeting, old = release
    who, path = run_committed(old, inputs)
    here, expected = run_committed(lmp, inputs)
    assert who.engine_version == greeting
    assert who.engine_version != here.engine_version
    assert path.y == pytest.approx(expected.y, rel=1e-12)
    assert path.vy == pytest.approx(expected.vy, rel=1e-9)


@pytest.mark.parametrize("model", ["radius", "area"])
def test_heat_is_refused_for_what_a_release_lacks(release, model):
    greeting, old = release
    case, lacks = get_case("heat"), {"23 Jun 2022": "heat", "2 Aug 2023": "compute property/atom"}
    job = case.job(case.default.replace(heat=model))
    with Lammps(lmp=old, workers=1) as older:
        reason = older.refuses(job)
    date = greeting.partition(" - ")[0]
    if date in lacks:
        assert reason.startswith(f"LAMMPS {date} has no {lacks[date]}")
    else:
        assert not reason
