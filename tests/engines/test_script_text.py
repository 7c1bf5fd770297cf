"""Plain scripts of scenes, run by hand as they stand."""

import json
import subprocess

import numpy as np
import pytest

from harness.engines.base import scene_job
from harness.solvers import reference
from tests.engines.test_equal_steps_of_codes import program
from tests.engines.test_plane_scenes import LAWS, drop

SCENE = drop(LAWS["plastic"])


@pytest.mark.live
@pytest.mark.slow
@pytest.mark.parametrize("code", ["yade", "kratos"], indirect=True)
def test_script_of_a_scene_runs_alone(code, tmp_path):
    (tmp_path / "run.py").write_text(code.script_text(scene_job(SCENE)))
    words = [program(code.name), *(["-n", "-x"] if code.name == "yade" else []), "run.py"]
    subprocess.run(words, cwd=tmp_path, check=True, capture_output=True,
                   env=code.environment(tmp_path))  # fmt: skip
    table = json.loads((tmp_path / "0.json").read_text())
    expected = reference.run(SCENE, code.rules(SCENE))
    assert np.abs(np.array(table["position"]) - expected.position).max() < 1e-11


@pytest.mark.live
@pytest.mark.parametrize(
    "code", ["lammps", pytest.param("liggghts", marks=pytest.mark.slow)], indirect=True
)
def test_script_of_a_scene_is_short(code):
    assert len(code.script_text(scene_job(SCENE)).splitlines()) < 60
