"""Cases of single contacts beyond impacts: what they refuse, and planted faults that turn them."""

from dataclasses import replace

import pytest

from harness.cases.contact.verification import verify_trials
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict
from harness.engines.lammps.engine import Lammps
from harness.errors import RequestError
from harness.parameters.rules import Rules
from harness.workflows.case_runs import run
from tests.cases.contact_base.perturbed import Planted


@pytest.mark.parametrize(
    ("name", "settings", "message"),
    [
        ("incline-rest", {"rolling": "none"}, r"rolling = 'none': must be sds in this case"),
        ("incline-rest", {"rolling_friction": "0"}, r"rolling_friction = 0\.0: must be greater"),
        ("collision", {"partner": "wall"}, r"partner = 'wall': must be one of sphere in this case"),
        ("collision", {"partner_share": "11"}, r"partner_share = '11': must be .*equal to 10"),
        ("collision", {"partner_radius": "1e5"}, r"partner_radius = .*: must be"),
        ("heat", {"conductance": "0"}, r"conductance = '0' .*: must be greater than 0"),
        ("heat", {"partner_temperature": "400"}, r"partner_temperature = 400\.0 K: must not be"),
        ("heat", {"normal": "jkr"}, r"normal = 'jkr': must be one of hooke, hertz in this case"),
        ("heat", {"overlap": "1"}, r"overlap = 1\.0 m: must be between"),
        ("heat", {"partner": "frozen"}, r"partner = 'frozen': must be one of wall, sphere"),
        ("drag", {"drag": "0"}, r"drag = '0' kg/s: must be greater than or equal to 1e-12"),
        ("drag", {"partner": "sphere"}, r"partner = 'sphere': must be one of wall in this case"),
        ("drag", {"duration": "1e9"}, r"duration = 1000000000\.0: must be at most"),
        ("moving-wall", {"moves": "up"}, r"moves = 'up': must be 'shear', 'along' or 'across'"),
        ("moving-wall", {"moves": "across", "normal": "hertz"}, r"normal = 'hertz': must be a lin"),
        (
            "moving-wall",
            {"moves": "along", "acceleration": "1e3"},
            r"acceleration = 1000\.0: must be",
        ),
        (
            "curved-wall",
            {"wall": "rim", "normal": "hertz"},
            r"normal = 'hertz': must be one of hooke",
        ),
        ("curved-wall", {"wall_radius": "0.01"}, r"wall_radius = 0\.01 m: must be at least 0\.011"),
        ("curved-wall", {"angle": "80"}, r"angle = '80' deg: must be .*equal to 60"),
        ("incline-rest", {"angle": "90"}, r"angle = '90' deg: must be .*less than 90"),
    ],
)
def test_values_without_a_meaning_are_refused(name, settings, message):
    with pytest.raises(RequestError, match=message):
        run(name, settings)


@pytest.mark.parametrize("fault", ["partner_density", "partner_radius", "partner_share"])
def test_another_partner_or_frame_is_seen(fault):
    """What is relative stays in every frame; masses and sizes are those that were asked for."""
    case = get_case("collision")
    systems = {one.system: one.parameters for one in case.trials("default", case.submodels[:1])}
    name = "size ratio 10" if fault == "partner_radius" else "unequal densities"
    parameters = systems[name]
    changed = parameters.replace(**{fault: 1.01 * getattr(parameters, fault)})
    before, after = (
        case.expected(one, Rules())["tangential_ratio"].value for one in (parameters, changed)
    )
    assert (abs(after - before) < 1e-12) == (fault == "partner_share")
    if fault != "partner_share":
        assert abs(after - before) > 1e-5


@pytest.fixture(scope="module")
def lammps():
    with Lammps(workers=1) as engine:
        yield engine


def verdicts(engine, case, system):
    """Return the verdicts of the first trial of a system at the shortest level."""
    trial = next(one for one in case.trials("default") if one.system == system)
    rows = verify_trials(case, engine, Study("quick"), [trial]).checks
    return {row.verdict for row in rows if row.judged}


@pytest.mark.live
@pytest.mark.usefixtures("lammps_here")
@pytest.mark.parametrize(
    ("name", "system", "faults"),
    [
        ("drag", "in a fluid", ("drag", "gravity_z", "mass_1")),
        ("heat", "two spheres", ("conductance", "heat_capacity", "temperature_2", "mass_2")),
        ("heat", "wall", ("wall_temperature", "temperature_1")),
        ("moving-wall", "shear", ("wall_speed", "friction")),
        ("moving-wall", "along", ("amplitude", "period", "youngs_modulus")),
        ("moving-wall", "across", ("amplitude", "period", "normal_stiffness")),
        ("curved-wall", "bowl", ("wall_radius", "youngs_modulus", "gravity_z")),
        ("curved-wall", "cylinder", ("wall_radius", "youngs_modulus")),
        ("curved-wall", "rim", ("radius_1", "tangential_stiffness")),
    ],
)
def test_what_lammps_is_told_wrongly_turns_a_row(lammps, name, system, faults):
    case = get_case(name)
    assert verdicts(lammps, case, system) == {Verdict.PASS}
    for fault in faults:
        planted = Planted(lammps, fault, 1.01)
        assert Verdict.FAIL in verdicts(planted, case, system), fault


class Synchronized(Lammps):
    """LAMMPS whose pairs have the keyword ``synchronized_verlet``."""

    @classmethod
    def _render(cls, template, variant):
        script = super()._render(template, variant)
        pairs = '"pair_coeff * * ${granular}'
        assert script.text.count(pairs) == 1
        return replace(script, text=script.text.replace(pairs, f"{pairs} synchronized_verlet"))


class WithoutTemperatures(Lammps):
    """LAMMPS that reads temperatures as releases before 29 Aug 2024 have to: from a data file."""

    @classmethod
    def _render(cls, template, variant):
        script = super()._render(template, variant)
        assert script.text.count("$(version) < 20240829") == 1
        return replace(script, text=script.text.replace("20240829", "99990101"))


@pytest.mark.live
@pytest.mark.usefixtures("lammps_here")
@pytest.mark.parametrize("system", ["wall", "unequal spheres"])
def test_temperatures_of_a_data_file_are_those_of_the_compute(lammps, system):
    case = get_case("heat")
    parameters = next(t for t in case.trials("default") if t.system == system).parameters
    with WithoutTemperatures(workers=1) as older:
        here, there = (one.run([case.job(parameters)])[0] for one in (lammps, older))
    for name, values in here.tables["series"].items():
        assert there.tables["series"][name] == pytest.approx(values, rel=1e-15), name
    assert case.read(parameters, there, older.traits)["excess_ratio"] == pytest.approx(
        case.expected(parameters, Rules())["excess_ratio"].value, rel=0.02
    )


@pytest.mark.live
@pytest.mark.usefixtures("lammps_here")
@pytest.mark.parametrize("submodel", [one.name for one in get_case("collision").submodels])
def test_a_small_sphere_on_a_large_one_has_one_limit_in_both_schemes(lammps, submodel):
    """synchronized_verlet (pull requests 4244, 4351) changes what a finite step does alone."""
    case = get_case("collision")
    plan = {(one.submodel, one.system): one for one in case.trials("default")}
    trial = plan[submodel, "size ratio 100"]
    coarse = trial.parameters.replace(steps_per_contact=25)
    with Synchronized(workers=1) as synchronized:
        for engine in (lammps, synchronized):
            rows = verify_trials(case, engine, Study("quick"), [trial]).checks
            assert {row.verdict for row in rows if row.judged} == {Verdict.PASS}
        one, other = (
            case.read(coarse, engine.run([case.job(coarse)])[0], engine.traits)["tangential_ratio"]
            for engine in (lammps, synchronized)
        )
    limit = case.expected(trial.parameters, Rules())["tangential_ratio"].value
    assert 0.0 < abs(one - other) < 2e-5  # the keyword acts
    assert 3e-4 < abs(one - limit) < 2e-3
    assert 3e-4 < abs(other - limit) < 2e-3


@pytest.mark.live
@pytest.mark.usefixtures("lammps_here")
@pytest.mark.parametrize("system", ["wall", "unequal spheres"])
def test_in_units_lj_no_bit_of_a_ratio_is_another(lammps, system):
    case, si = get_case("lj-units"), get_case("oblique")
    for trial in case.trials("default"):
        if trial.system == system:
            parameters = trial.parameters.replace(steps_per_contact=200)
            there, here = lammps.run([case.job(parameters), si.job(parameters)])
            ratios = case.read(parameters, there, lammps.traits)
            assert ratios == si.read(parameters, here, lammps.traits), trial.submodel
    wrong = Planted(lammps, "youngs_modulus", 1.01)
    (turned,) = wrong.run([case.job(parameters)])
    assert case.read(parameters, turned, lammps.traits) != ratios


@pytest.mark.parametrize("system", ["bowl", "cylinder", "hill"])
def test_a_curved_wall_has_the_moduli_of_walls_and_not_those_of_pairs(system):
    case = get_case("curved-wall")
    trials = [t for t in case.trials("quick") if t.submodel == "hertz, mass_velocity"]
    parameters = trials[0].parameters.replace(wall=system, wall_radius=0.02)
    plain, pairs, walls = (
        case.expected(parameters, Rules(**rule))["overlap_ratio"].value
        for rule in ({}, {"pair_factor": 0.5}, {"modulus_factor": 1.3})
    )
    assert pairs == plain
    assert abs(walls - plain) > 1e-3
