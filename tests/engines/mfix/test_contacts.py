"""Contacts with friction: what MFiX is told of them, what it leaves, and MFiX itself."""

import math

import pytest

from harness.cases.contact.submodels import Trial
from harness.cases.contact.transformations import first_runs
from harness.cases.registry import get_case
from harness.engines.mfix.contacts import CONTACTS, ContactInput, contact_table
from harness.engines.mfix.engine import KEYWORDS, PARTICLES, contact_files
from harness.engines.mfix.system import read_frame
from harness.engines.traits import stating
from harness.errors import EngineOutputError

OBLIQUE = get_case("oblique")
SPRINGS = OBLIQUE.default.replace(damping="velocity", damping_coefficient=2.0)
SOLID = OBLIQUE.default.replace(
    normal="hertz",
    youngs_modulus=1e8,
    poisson_ratio=0.3,
    damping="coeff_restitution",
    restitution=0.5,
    tangential="mindlin",
    tangential_damping=0.5,
)
WALL = Trial("linear_history", "wall", SPRINGS)
UNEQUAL = {"partner": "sphere", "partner_radius": 0.02}


def told(parameters, read_keywords):
    """Return the keywords of the input of an impact, and its job's values."""
    values = OBLIQUE.job(parameters).values
    return read_keywords(contact_files(ContactInput(values))[KEYWORDS]), values


def eta(restitution, stiffness, mass):
    logarithm = math.log(restitution)
    return 2.0 * math.sqrt(stiffness * mass) * -logarithm / math.hypot(math.pi, logarithm)


@pytest.mark.parametrize("system", [{}, {"partner": "sphere"}, UNEQUAL])
def test_the_dashpot_and_the_step_are_those_of_mfix_s_own_formulas(read_keywords, system):
    """check_solids_dem.f: DES_ETAN from a restitution, DTSOLID from the shortest contact time."""
    keys, values = told(SPRINGS.replace(**system), read_keywords)
    masses = [
        math.pi / 6.0 * keys[f"D_P0({m})"] ** 3 * keys[f"RO_S0({m})"]
        for m in range(1, int(keys["MMAX"]) + 1)
    ]
    pairs = [(a, b) for i, a in enumerate(masses) for b in masses[i:]]
    reduced = [a * b / (a + b) for a, b in pairs]
    etas = [eta(keys[f"DES_EN_INPUT({i})"], keys["KN"], m) for i, m in enumerate(reduced, 1)]
    times = [
        math.pi / math.sqrt(keys["KN"] / m - (e / m) ** 2 / 4.0)
        for e, m in zip(etas, reduced, strict=True)
    ]
    assert min(times) / keys["DTSOLID_FACTOR"] == pytest.approx(values["step_size"], rel=1e-12)
    if system:
        meeting = len(masses) - 1  # of two phases the second pair
        assert etas[meeting] == pytest.approx(2.0, rel=1e-12)
        assert masses[-1] == pytest.approx(values["mass_2"], rel=1e-12)
    else:
        wall = eta(keys["DES_EN_WALL_INPUT(1)"], keys["KN_W"], masses[0])
        assert wall == pytest.approx(2.0, rel=1e-12)
    assert keys["KT_FAC"] * keys["KN"] == pytest.approx(values["tangential_stiffness"], rel=1e-12)


def test_the_tangential_dashpot_of_hertz_is_told_by_a_restitution(read_keywords):
    """DES_ETAT is 2 zeta sqrt(HERT_KWT 2/7 m), with 8 G* for HERT_KWT: x_t of DES_ETAN."""
    keys, values = told(SOLID, read_keywords)
    root, mass = math.sqrt(values["radius_1"]), values["mass_1"]
    stiff = 4.0 / 3.0 * root * 1e8 / 2.0 / (1.0 - 0.3**2)
    shear = 8.0 * root * 1e8 / 2.6 / 2.0 / 1.7
    along = eta(keys["DES_ET_WALL_INPUT(1)"], shear, 2.0 / 7.0 * mass)
    across = eta(keys["DES_EN_WALL_INPUT(1)"], stiff, mass)
    assert keys["DES_EN_WALL_INPUT(1)"] == 0.5
    assert along / across == pytest.approx(0.5, rel=1e-12)


def test_spheres_lie_in_the_box_as_they_do_in_the_scene():
    contact = ContactInput(OBLIQUE.job(SPRINGS.replace(partner="frozen")).values)
    first, held = (
        [float(word.replace("d", "e")) for word in line.split()]
        for line in contact_files(contact)[PARTICLES].splitlines()
    )
    assert held[1] == held[2] == 0.01  # a radius from the outflow at the floor of the box
    assert first[1] - held[1] == pytest.approx(contact.balls[0].z + 0.01, rel=1e-12)
    assert first[4:] == [contact.balls[0].vx, contact.balls[0].vz]
    width, height = contact.box
    assert 0.0 < first[0] < width
    assert first[1] < height


def test_a_run_that_is_shorter_than_its_usual_first_step_is_told_a_shorter_one(read_keywords):
    """time_march: a run ends where TSTOP is within a tenth of DT, which MFiX sets afterwards."""
    keys, _ = told(OBLIQUE.presets["chung-ooi-5"].replace(steps_per_contact=100), read_keywords)
    assert 0.1 * keys["DT"] < keys["TSTOP"] < 1e-5


def test_walls_that_are_not_horizontal_cannot_be_told():
    (turned,) = (way for way in first_runs(OBLIQUE, WALL, "quick").runs.values() if way.name)
    assert "has horizontal walls at rest" in stating(CONTACTS, turned.job.values)[1]


def test_a_sphere_that_spins_at_the_start_cannot_be_told():
    case = get_case("spin")
    assert "starts spheres without spin" in stating(CONTACTS, case.job(case.default).values)[1]


def test_what_mfix_wrote_is_turned_back_and_forces_are_missing(write_vtp):
    contact = ContactInput(OBLIQUE.job(SPRINGS).values)
    x0, y0 = contact.origin

    def frame(step):
        fields = {
            "Velocity": [(0.5, -0.25, 0.0)],
            "Angular_velocity": [(0.0, 0.0, -4.0)],
            "Particle_ID": [(1.0,)],
        }
        place = [(x0 + 0.001, y0 + 0.01, 0.0)]
        return read_frame(write_vtp(step * contact.step, place, fields), "GRAIN_0000.vtp")

    table = contact_table(contact, [frame(0), frame(contact.every)])
    assert table["step"].tolist() == [0.0, contact.every]
    assert table["x_m"][-1, 0] == pytest.approx(0.001, abs=1e-8)
    assert table["z_m"][-1, 0] == pytest.approx(0.01, abs=1e-8)
    assert (table["vz_m_per_s"][-1, 0], table["wy_rad_per_s"][-1, 0]) == (-0.25, 4.0)
    assert "fx_N" not in table
    with pytest.raises(EngineOutputError, match=r"no particles at step \d+"):
        contact_table(contact, [frame(0)])
