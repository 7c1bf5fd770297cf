"""What MFiX is given and leaves: inputs against the recorded ones, frames in its form."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from harness.cases.drop.case import TEMPLATE as DROP
from harness.cases.drop.case import Drop, values_of
from harness.cases.incline.runs import scene_from
from harness.cases.incline.system import start_in_well
from harness.cases.tower import system as tower
from harness.engines.mfix.engine import CONTACT, input_texts
from harness.engines.mfix.frames import motion, read_frames
from harness.engines.mfix.system import steps_per_contact, system_of
from harness.errors import EngineNaNError, EngineOutputError, RequestError
from harness.parameters.law import SOURCE, Contact
from harness.parameters.tower import Tower
from harness.reproduction.mfix import START_SPEED, case_at

RECORDED = Path(__file__).parent / "recorded"
CHANGED = {
    *("RUN_NAME", "DESCRIPTION", "TSTOP"),
    # the recorded runs had routines of their own, with switches, for output and to freeze the row
    *("CALL_USR", *(f"C({i})" for i in range(1, 8))),
    # a grain that crosses would count twice: so the row is as long as it needs, and so is the box
    *("CYCLIC_X", "PARTICLES", "XLENGTH", "IMAX", "IC_X_E(1)"),
}
ADDED = ("BC_", "DESGRIDSEARCH_", "VTK_", "WRITE_VTK_FILES", "TIME_DEPENDENT_FILENAME")
"""Keywords of the outlet that holds the row, of the output, and of the search for neighbours."""


def incline_scene(angle=10.2, factor=50.0, wells=8, seconds=45.0):
    case = case_at(angle, 1e6, factor).replace(wells=wells)
    scene = scene_from(case, start_in_well(case, START_SPEED))
    return replace(scene, steps=math.ceil(seconds / case.step))


def incline_system(**how):
    scene = incline_scene(**how)
    return system_of("incline", scene, scene.steps, 20, "EULER")


def rows_of(system):
    text = input_texts(system)["particle_input.dat"].replace("d", "e")
    return np.array([[float(word) for word in line.split()] for line in text.splitlines()])


def test_every_keyword_of_the_recorded_input_is_stated_but_for_those_reviewed(stand_in_module):
    read = stand_in_module.read_keywords
    recorded = read((RECORDED / "mfix_quartier.dat").read_text(encoding="utf-8"))
    gx, gy = recorded["GRAVITY_X"], recorded["GRAVITY_Y"]
    factor, angle = recorded["DTSOLID_FACTOR"], math.degrees(math.atan2(gx, -gy))
    case = case_at(angle, recorded["KN"], factor).replace(gravity=math.hypot(gx, gy))
    scene = scene_from(case, start_in_well(case, START_SPEED))
    generated = read(input_texts(system_of("incline", scene, 10**5, 20, "EULER"))["mfix.dat"])
    for key in recorded.keys() - CHANGED:
        value = recorded[key]
        number = isinstance(value, float)
        assert generated[key] == (pytest.approx(value, rel=1e-12) if number else value), key
    cells = [generated[f"{a}LENGTH"] / generated[f"DESGRIDSEARCH_{i}MAX"] for a, i in ("XI", "YJ")]
    assert min(cells) >= 2.4 * generated["D_P0(1)"]
    assert all(key.startswith(ADDED) for key in generated.keys() - recorded.keys())
    assert {key for key in CHANGED if generated.get(key) == recorded[key]} == set()


@pytest.mark.parametrize(("scheme", "average"), [("EULER", 1.0), ("ADAMS_BASHFORTH", 0.5)])
def test_a_held_sphere_is_at_its_place_after_the_first_step(scheme, average):
    """By the schemes of the reference DEM: x + h (v + h a), and x + h/2 (v + v + h a)."""
    case = Drop(
        contact=CONTACT.replace(restitution=0.5),
        speed=1.0, steps_per_contact=100.0, gravity=9.81, gap=-1e-3,
    )  # fmt: skip
    system = system_of("drop", DROP.scene(values_of(case)), 100, 1, scheme)
    assert f"DES_INTG_METHOD = '{scheme}'" in input_texts(system)["mfix.dat"]
    eta = 2.0 * case.contact.zeta * np.sqrt(0.5 * case.stiffness * case.mass)
    press = case.stiffness * 1e-3 + eta * case.speed
    acceleration = -9.81 - press / case.mass
    moved = rows_of(system)[1, 5] + average * case.step * acceleration
    assert moved == pytest.approx(0.0, abs=1e-9 * abs(acceleration) * case.step)


@pytest.mark.parametrize("restitution", [1e-20, 0.5, 1.0])
def test_the_factor_divides_the_damped_contact_time_of_half_the_mass(restitution):
    contact = CONTACT.replace(restitution=restitution)
    eta = 2.0 * contact.zeta * math.sqrt(0.5)  # k = m = 1
    time = math.pi / math.sqrt(2.0 - eta**2)
    assert steps_per_contact(50, contact) == pytest.approx(50 * math.pi / time, rel=1e-9)
    if restitution == 1e-20:
        assert steps_per_contact(50, contact) == pytest.approx(4.8, abs=0.03)


@pytest.mark.parametrize(
    ("factor", "contact", "said"),
    [
        (0.0, CONTACT, "factor = 0.0: must be finite and greater than 0"),
        (math.nan, CONTACT, "must be finite"),
        (50.0, SOURCE, "half-mass"),
        (50.0, Contact(restitution=0.0, effective_mass="half"), "must be less than 1"),
    ],
)
def test_a_step_that_mfix_does_not_have_is_refused(factor, contact, said):
    with pytest.raises(RequestError, match=said):
        steps_per_contact(factor, contact)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"fixed": np.array([False, True, True])}, "the last alone be fixed"),
        ({"fixed": np.array([True, False, False])}, "must come last"),
        ({"position": np.array([[0.0, 0.0], [2.0, 0.0], [1.0, 0.0]])}, "must come in order"),
        ({"mass": np.array([1.0, 1.0, 2.0])}, "one mass"),
        ({"diameter": np.array([1.0, 1.0, 2.0])}, "one diameter"),
        ({"gravity": (0.0, -9.81)}, "forces of lines"),
        ({"gravity": (0.0, -9.81), "forces": False, "fixed": np.full(3, False)}, "must be level"),
    ],
)
def test_a_scene_that_mfix_cannot_hold_is_refused(changes, said):
    case = Tower(height=2, law="overlap")
    built = tower.scene_of(tower.values_of(case, tower.timing_of(case, 3.0, 1000.0, 10)))
    arrays = {n: v for n, v in changes.items() if isinstance(v, np.ndarray)}
    others = {n: v for n, v in changes.items() if n not in arrays}
    with pytest.raises(RequestError, match=said):
        system_of("line", replace(built.with_spheres(**arrays), **others), 100, 10, "EULER")
    with pytest.raises(RequestError, match="stages that say how far"):
        system_of("row", replace(incline_scene(), stages=()), 100, 10, "EULER")


# ---- frames: no VTP file of MFiX itself is here; these have the form of ``vtp_mod.f``

ROWS = 60


@pytest.fixture
def frames(stand_in_module, tmp_path):
    """Return system, states (ROWS, 4) and a folder with them, the grain at a place that changes."""
    system = incline_system()
    states = np.random.default_rng(1).uniform(1.0, 2.0, (ROWS, 4))
    for row, (x, y, vx, vy) in enumerate(states):
        others = [(99.0, (1.0, 5.0))]
        if row == 0:  # the first frame has the whole row
            others = [(2.0 + i, place) for i, place in enumerate(system.place[1:])]
        points = [(number, (*place, 0.0), (0.0,) * 3) for number, place in others]
        points.insert(len(points) if row % 2 else 0, (1.0, (x, y, 0.0), (vx, vy, 0.0)))
        ids, places, velocities = zip(*points, strict=True)
        fields = {"Velocity": velocities, "Particle_ID": [(number,) for number in ids]}
        content = stand_in_module.vtp(20 * row * system.scene.step, places, fields)
        (tmp_path / f"GRAIN_{row:04d}.vtp").write_bytes(content)
    return system, states, tmp_path


def read(system, folder):
    return motion(system, read_frames(folder, "GRAIN"), [])


def test_the_path_that_was_written_is_read_by_its_global_id(frames):
    system, states, folder = frames
    (folder / "GRAIN_0059.vtp").rename(folder / "GRAIN_10000.vtp")
    table = read(system, folder)
    assert table["step"] == pytest.approx(20 * np.arange(ROWS))
    for number, name in enumerate(("x_m", "y_m")):
        expected = states[:, number] - system.origin[number]
        assert np.abs(table[name][:, 0] - expected).max() < 2.0 * 2.0**-23
    assert np.abs(table["vx_m_per_s"][:, 0] - states[:, 2]).max() < 2.0 * 2.0**-23


def edit(number, change):
    def damage(folder):
        path = folder / f"GRAIN_{number:04d}.vtp"
        path.write_bytes(change(path.read_bytes()))

    return damage


@pytest.mark.parametrize(
    ("damage", "error", "said"),
    [
        (edit(7, lambda _: b""), EngineOutputError, r"GRAIN_0007\.vtp only in part"),
        (edit(7, lambda text: text[: len(text) // 2]), EngineOutputError, r"GRAIN_0007\.vtp"),
        (edit(7, lambda text: text[:-5]), EngineOutputError, r"GRAIN_0007\.vtp only in part"),
        (
            edit(7, lambda text: text.replace(b"\n _\0\0\0\x18", b"\n _\0\0\0\x0c")),
            EngineOutputError,
            "coordinates cut short",
        ),
        (
            edit(7, lambda text: text.replace(b"Particle_ID", b"Particle_XX")),
            EngineOutputError,
            "without their global ids",
        ),
        (
            edit(7, lambda text: text.replace(b"\n _\0\0\0\x18", b"\n _\0\0\0\x18\x7f\x80\0\0")),
            EngineNaNError,
            "not numbers",
        ),
        (lambda folder: (folder / "GRAIN_0030.vtp").unlink(), EngineOutputError, "not every 20"),
        (lambda folder: (folder / "GRAIN_0000.vtp").unlink(), EngineOutputError, "not every 20"),
    ],
)
def test_a_damaged_frame_is_named(frames, damage, error, said):
    system, _, folder = frames
    damage(folder)
    with pytest.raises(error, match=said):
        read(system, folder)
