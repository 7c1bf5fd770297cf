"""Films of bulk: the circles in which a plane cuts particles; a code without them says so."""

import math
from dataclasses import replace

import numpy as np
import pytest

from harness.cases.bulk.film import BANDS, PARTICLES, Cut, CutScene, Motion
from harness.cases.registry import get_case
from harness.engines.registry import engine_class
from harness.errors import EngineError, EngineMissingError, RequestError
from harness.workflows.case_runs import check_film

SMALL = {
    "silo": get_case("silo").default.replace(
        layers=3, silo_radius=0.016, cone_height=0.008, settle_time=0.1, duration=0.2
    ),
    "penetration": get_case("penetration").default.replace(
        along=6, across=5, layers=3, start_height=0.0115, settle_time=0.03, duration=0.02
    ),
    "drum": get_case("drum").default.replace(
        small_layers=1, large_layers=-2, drum_radius=0.016, drum_length=0.014,
        settle_time=0.05, turn=20.0,
    ),
    "heap": get_case("heap").default.replace(
        length=12, width=3, layers=6, duration=0.05, settle_time=0.05,
    ),
}  # fmt: skip


def motion():
    """Return eight grains on top of one another and a larger one beside them, which rises."""
    place = np.zeros((2, 9, 3))
    place[:, :8, 2] = np.arange(8) * 2e-3
    place[:, 8] = 5e-3, 0.6e-3, 1e-3
    place[1, 8, 2] = 3e-3
    return Motion(np.array([0.0, 0.1]), place, np.array([1e-3] * 8 + [2e-3]))


def test_a_particle_is_the_circle_that_the_plane_cuts_from_it():
    scene = CutScene(motion(), Cut(0.6e-3, [([0.0, 1e-2], [0.0, 0.0])], -1e-3, 2e-2), "Grains")
    assert scene.picture(0).shape == scene.picture(1).shape
    widths, offsets = scene._circles.get_widths(), scene._circles.get_offsets()
    # [mm]; the plane is 0.6 mm beside the grains' centres: sqrt(1 - 0.6^2) = 0.8
    assert widths[:8] == pytest.approx(2 * 0.8)
    assert widths[8] == pytest.approx(2 * 2.0)
    assert offsets[8] == pytest.approx([5.0, 3.0])
    aside = CutScene(motion(), Cut(1.5e-3, [], -1e-3, 2e-2), "Grains")
    aside.show(0)
    assert aside._circles.get_widths()[:8] == pytest.approx(0.0)
    assert aside._circles.get_widths()[8] == pytest.approx(2 * math.sqrt(4 - 0.81))


def test_colours_are_bands_of_first_height_and_sizes():
    kinds = motion().kinds
    assert kinds.tolist() == [0, 0, 1, 1, 2, 2, 3, 3, BANDS]
    varied = Motion(motion().time, motion().place, radius=np.linspace(1e-3, 2e-3, 9))
    assert varied.kinds.tolist() == [0, 0, 1, 1, 2, 2, 3, 3, 0]


def opened(code):
    """Return an engine that is here."""
    try:
        engine = engine_class(code)()
        engine.identify()
    except EngineMissingError as error:
        pytest.skip(str(error))
    return engine


@pytest.mark.live
@pytest.mark.parametrize(
    "code",
    ["lammps", *(pytest.param(c, marks=pytest.mark.slow) for c in ("liggghts", "yade", "kratos"))],
)
@pytest.mark.parametrize("name", SMALL)
def test_each_case_has_a_film(name, code, tmp_path):
    case, p = get_case(name), SMALL[name]
    if name == "heap" and code in ("yade", "kratos"):
        p = p.replace(rolling_friction=0.0)
    with opened(code) as engine:
        film = case.display.film(engine, p, 5)
    assert film.frames in (5, 6)
    assert not np.array_equal(film.picture(0), film.picture(film.frames - 1))
    film.save(tmp_path / "film.gif")
    assert (tmp_path / "film.gif").read_bytes().startswith(b"GIF")


@pytest.mark.live
@pytest.mark.slow
@pytest.mark.parametrize("code", ["liggghts", "yade", "kratos"])
def test_particles_of_the_drum_have_radii_and_the_places_of_its_series(code):
    p = SMALL["drum"]
    plain = get_case("drum").job(p)
    job = replace(plain, values={**plain.values, PARTICLES: 1})
    with opened(code) as engine:
        series, particles = (output.table(("step", "z_m")) for output in engine.run([plain, job]))
    assert particles["radius_m"][0] == pytest.approx(p.radii, rel=1e-6)
    assert particles["step"].tolist() == series["step"].tolist()
    # six digits of the drum's size are written at least
    assert particles["z_m"] == pytest.approx(series["z_m"], abs=1e-5 * p.drum_radius)


class Other:
    """A code of another package whose script of the silo writes no particles."""

    title = "Other"

    def refuses(self, job):
        return "its script silo.in has no variable 'particles'" if "particles" in job.values else ""


def test_a_code_whose_script_writes_no_particles_says_so():
    with pytest.raises(RequestError, match=r"film: Other cannot run it: .* 'particles'"):
        check_film("silo", {"layers": "3"}, Other())


class Slow(Other):
    """A code that writes down what it is given."""

    traits = engine_class("kratos").traits
    given = ()

    def run(self, jobs):
        self.given = jobs
        return [EngineError("no film")]


def test_the_run_of_a_film_has_the_time_that_it_is_expected_to_need():
    case, engine = get_case("silo"), Slow()
    with pytest.raises(EngineError, match="no film"):
        case.display.film(engine, case.default, 5)
    (job,) = engine.given
    assert job.seconds == case.seconds(case.default, engine.traits) > 0.0
