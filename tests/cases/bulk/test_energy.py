"""Elastic energy of a bed at rest: by LAMMPS's script and from places, and its limits."""

import math
import subprocess

import numpy as np
import pytest
from scipy.integrate import quad

from harness.cases.bulk.beds import tangential_share
from harness.cases.bulk.penetration import CASE
from harness.engines.lammps.engine import Lammps
from harness.engines.output import results_in

SMALL = CASE.default.replace(
    along=5, across=4, layers=3, start_height=0.0115, settle_time=0.05, duration=0.03
)


def ran(p, lmp, folder, **more):
    """Run the script of a small bed by hand; return its results, and its particles by step."""
    script = folder / "penetration.in"
    script.write_text(Lammps.script(CASE.template).text, encoding="utf-8")
    values = {**CASE.job(p).values, "dump": "all", "record": "yes", **more}
    sets = (word for name, value in values.items() for word in ("-var", name, str(value)))
    command = [lmp, "-in", str(script), "-log", "log", "-screen", "none", *sets]
    subprocess.run(command, cwd=folder, check=True)
    results = dict(results_in((folder / "log").read_text("utf-8")))
    lines = (folder / "all").read_text("utf-8").splitlines()
    block = int(lines[3]) + 9
    frames = {
        int(lines[i + 1]): np.loadtxt(lines[i + 9 : i + block]) for i in range(0, len(lines), block)
    }
    return results, frames


def elastic_energy(p, frame):
    """Return what normal springs hold [J], each pair and wall by hand; id type x y z ... radius."""
    kind, place, radius = frame[:, 1], frame[:, 2:5], frame[:, 8]
    young = np.where(kind == 1, p.youngs_modulus, p.steel_youngs_modulus)

    def spring(overlap, modulus, other, size):
        compliance = (1 - p.poisson_ratio**2) * (1 / modulus + 1 / other)
        return np.where(overlap > 0, 8 / 15 / compliance * np.sqrt(size) * abs(overlap) ** 2.5, 0)

    i, j = np.triu_indices(len(place), 1)
    overlap = radius[i] + radius[j] - np.linalg.norm(place[i] - place[j], axis=1)
    total = spring(overlap, young[i], young[j], 1 / (1 / radius[i] + 1 / radius[j])).sum()
    x, y, z = place.T
    for depth in (x, p.box.length - x, y, p.box.width - y, z):
        total += spring(radius - depth, young, p.steel_youngs_modulus, radius).sum()
    return total


@pytest.mark.slow
@pytest.mark.live
def test_the_script_measures_what_places_say_and_changes_nothing(lmp, tmp_path):
    results, frames = ran(SMALL, lmp, tmp_path)
    series = (tmp_path / "penetration.csv").read_bytes()
    # the overlaps are counted in bins of 4e-8 m, some 1e-2 of one: at random over all contacts
    for name, step in (("elastic_J", SMALL.settle_steps), ("end_elastic_J", max(frames))):
        assert float(results[name]) == pytest.approx(
            elastic_energy(SMALL, frames[step]), rel=5e-3
        ), name
    # looked at each 500 steps, no bit of the motion changes
    ran(SMALL, lmp, tmp_path, thermo=500)
    assert (tmp_path / "penetration.csv").read_bytes() == series


@pytest.mark.live
def test_grains_that_lie_alone_hold_two_fifths_of_weight_times_overlap(lmp, tmp_path):
    p = SMALL.replace(along=3, across=3, layers=1, spacing=2.0, scatter=0.0, settle_time=0.2)
    results, _ = ran(p, lmp, tmp_path)
    both = p.youngs_modulus * p.steel_youngs_modulus / (p.youngs_modulus + p.steel_youngs_modulus)
    weight, modulus = p.grain.mass * p.gravity, both / (1 - p.poisson_ratio**2)
    overlap = (0.75 * weight / modulus / math.sqrt(p.radius)) ** (2 / 3)
    held = p.grains * 0.4 * weight * overlap
    assert float(results["elastic_J"]) == pytest.approx(held, rel=1e-3)  # it still swings


@pytest.mark.parametrize("nu", [0.0, 0.2, 0.49])
def test_a_tangential_spring_holds_most_at_coulombs_limit(nu):
    friction, modulus, radius, overlap = 0.3, 1e7, 1e-3, 2e-6
    contact = modulus / (1 - nu**2) / 2, modulus / (1 + nu) / 2 / (2 * (2 - nu)), radius / 2
    young, shear, size = contact
    width = math.sqrt(size * overlap)
    normal = quad(lambda d: 4 / 3 * young * math.sqrt(size) * d**1.5, 0, overlap, epsabs=0)[0]
    force = friction * 4 / 3 * young * math.sqrt(size) * overlap**1.5
    slide = force / (8 * shear * width)
    tangential = quad(lambda s: 8 * shear * width * s, 0, slide, epsabs=0)[0]
    assert tangential / normal == pytest.approx(tangential_share(friction, nu), rel=1e-7)
    assert tangential_share(0.0, nu) == 0.0
