"""Pairs of the bulk scripts of Yade, Kratos, and LAMMPS under each of their rules, by the law."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from harness.cases.bulk.law import bulk_law, stated_law, with_tail
from harness.cases.bulk.penetration import CASE, Penetration
from harness.engines.contract import Job
from harness.engines.registry import engine_class
from harness.model.law import Law
from harness.model.scene import Scene, Wall, sphere
from harness.solvers import reference
from tests.cases.bulk.doubles import PROGRAMS, RULES, StandIn, changed, needs, run

P = Penetration(poisson_ratio=0.3)
STEEL = {"radius": P.steel_radius, "density": P.steel_density}
GRAIN = {"radius": P.radius, "density": P.density}

PAIR = '''
def pair(p):
    """Let the first body of a pair meet the second obliquely; write its velocities."""
    kinds = [getattr(sys.modules[__name__], word) for word in p.places.split("_")]
    spheres = Spheres(p, materials_of(p), pairs_of(p))
    radii = [p.radius, p.steel_radius]
    low = 0.0 if kinds[1] == WALL else spheres.add(kinds[1], (0, 0, 0), radii[kinds[1]], held=True)
    height = radii[kinds[0]] + (0.0 if kinds[1] == WALL else radii[kinds[1]])
    first = spheres.add(kinds[0], (0, 0, height * (1 + 1e-9)), radii[kinds[0]], held=True)
    if kinds[1] == WALL:
        spheres.wall(WALL, (0, 0, 0), (0, 0, 1), 1.0)
    spheres.start()
    spheres.release(first, (p.offset, 0.0, -p.speed))
    if kinds[1] != WALL:
        spheres.release(low, (0.0, 0.0, 0.0))
    series, results = Series(p.series, "t,vx,vz,wy".split(",")), Results(p.results)

    def look(step):
        _, _, _, velocity, spin = spheres.states()[first]
        series.add(step * p.step_size, velocity[0], velocity[2], spin[1])

    look(0)
    spheres.advance(p.steps, p.series_every, look)
    series.write()
    results.add("verdict", "finished")


class Impact:'''

LAMMPS_PAIR = """
delete_atoms group all compress no
variable first string 1
variable second string 0
if "${places} == SPHERE_GRAIN || ${places} == SPHERE_WALL" then "variable first string 2"
if "${places} == GRAIN_GRAIN || ${places} == SPHERE_GRAIN" then "variable second string 1"
if "${places} == GRAIN_SPHERE" then "variable second string 2"
variable R1 equal "v_radius+(v_first==2)*(v_steel_radius-v_radius)"
variable R2 equal "v_radius+(v_second==2)*(v_steel_radius-v_radius)"
variable low equal "(v_second>0)*(v_R2+0.01)"
create_atoms ${first} single $(0.5*v_length) $(0.5*v_width) &
  $(v_low+(v_R1+(v_second>0)*v_R2)*(1+1e-9):%.17g) units box
if "${second} > 0" then &
  "create_atoms ${second} single $(0.5*v_length) $(0.5*v_width) $(v_low:%.17g) units box"
set type 1 diameter $(2*v_radius:%.17g) density ${density}
set type 2 diameter $(2*v_steel_radius:%.17g) density ${steel_density}
set atom 1 vx ${offset} vz -${speed}
group grains clear
group sphere clear
group grains type 1
group sphere type 2
group first id 1
compute omega first property/atom omegay
compute spin first reduce sum c_omega
fix move all nve/sphere
variable t equal step*dt
fix series all print ${series_every} &
  '$(v_t:%.17g),$(vx[1]:%.17g),$(vz[1]:%.17g),$(c_spin:%.17g)' file ${series} &
  screen no title 't,vx,vz,wy'
run ${steps} post no
print "RESULT verdict = finished"
"""

RULES_OF = ("yade", "kratos")
CODES = pytest.mark.parametrize(
    "code",
    [
        pytest.param(
            code,
            marks=[
                pytest.mark.live,
                pytest.mark.skipif(not PROGRAMS[code.partition(":")[0]], reason=f"no {code} here"),
                *([pytest.mark.slow] if code in RULES_OF else []),
            ],
        )
        for code in ("yade", "kratos", "lammps", "lammps:yade", "lammps:kratos")
    ],
)
PAIRS = {
    "GRAIN_WALL": (GRAIN, None, P.steel_restitution, P.steel_friction),
    "GRAIN_SPHERE": (GRAIN, STEEL, P.steel_restitution, P.steel_friction),
    "SPHERE_GRAIN": (STEEL, GRAIN, P.steel_restitution, P.steel_friction),
    "GRAIN_GRAIN": (GRAIN, GRAIN, P.restitution, P.friction),
    "SPHERE_WALL": (STEEL, None, P.steel_restitution, P.steel_friction),
}
LAWS = {
    code: stated_law(StandIn("penetration", code), bulk_law(P.poisson_ratio))
    for code in ("lammps", *RULES_OF)
}


def driven(code, fault):
    """Return an engine whose script lets pairs meet, perhaps with a planted fault."""

    def change(text):
        assert fault[0] in text
        text = text.replace(*fault) if fault[0] else text
        if code == "lammps":
            return text.partition("# ---- what is watched")[0] + LAMMPS_PAIR
        text = text.replace("class Impact:", PAIR.lstrip(), 1)
        for name in ("p", "parameters"):
            text = text.replace(f"Impact({name}).run()", f"pair({name})")
        return text

    return changed(engine_class(code), change)


def bodies_of(pair):
    """Return m* and R* of a pair, E* and the moduli of both."""
    first, second, _, _ = PAIRS[pair]
    mass, radius = sphere(**first).mass, first["radius"]
    if second is not None:
        other, wide = sphere(**second).mass, second["radius"]
        mass, radius = mass * other / (mass + other), radius * wide / (radius + wide)
    young = [
        P.youngs_modulus if one is GRAIN else P.steel_youngs_modulus
        for one in (first, second or STEEL)
    ]
    e_star = 1 / sum((1 - P.poisson_ratio**2) / one for one in young)
    return mass, radius, e_star, young


def contact_time(pair, speed):
    """Return Hertz's contact time without a dashpot [s]: 2.9432 times the deepest over speed."""
    mass, radius, modulus, _ = bodies_of(pair)
    deepest = (15 * mass * speed**2 / (16 * math.sqrt(radius) * modulus)) ** 0.4
    return 2 * deepest / speed * math.sqrt(math.pi) * math.gamma(1.4) / math.gamma(0.9)


def job(pair, speed, along, steps=2000, **changes):
    """Return the impact of a pair, at so many steps in the contact, over 1.6 contact times."""
    step = contact_time(pair, speed) / steps
    told = {
        "places": pair, "speed": speed, "offset": along, "gravity": 1e-12, "step_size": step,
        "steps": int(1.6 * steps), "series_every": 1,
    }  # fmt: skip
    return Job(CASE.template, {**P.values, **told, **changes}, sampled=True)


def outputs(code, jobs, fault=("", "")):
    """Return the series of jobs in a code; ``lammps:yade`` is LAMMPS under the rules of Yade."""
    code, _, rules = code.partition(":")
    if rules:
        jobs = [replace(one, values=LAWS[rules].values(one.values)) for one in jobs]
    return [one.tables["series"] for one in run(driven(code, fault), *jobs)]


def rebound(table, pair):
    """Return the restitution: the change of the first body's velocity, by m*, less one."""
    own, mass = sphere(**PAIRS[pair][0]).mass, bodies_of(pair)[0]
    return own / mass * (table["vz"][-1] - table["vz"][0]) / -table["vz"][0] - 1.0


def slides(table, pair):
    """Return friction of a pair that slides: tangential over normal change of velocity, twice."""
    own = PAIRS[pair][0]["radius"]
    normal = table["vz"][-1] - table["vz"][0]
    along, spin = table["vx"][0] - table["vx"][-1], table["wy"][-1] - table["wy"][0]
    return along / normal, 0.4 * own * spin / normal


SLOW = 0.003
"""[m/s]: overlaps of 5e-4 of a radius, so that neither lever nor normal change."""

ELASTIC = {"restitution": 1.0, "steel_restitution": 1.0}


def sliding(code, restitution):
    """Return the ratio of the impulses of a pair that slides all the time, over friction.

    Friction acts while a tail attracts, too, where Coulomb's limit is that of the force's size. The
    force changes its sign at the speed e1 at which it would end without a tail: its impulses are
    1 + e1 and e1 - e, their sum over their difference is (1 + 2 e1 - e)/(1 + e), a tenth above 1.
    """
    if LAWS[code.rpartition(":")[2]].law.clipped:
        return 1.0
    without = brentq(lambda e: with_tail(e) - restitution, 0.2, 0.95)
    return (1.0 + 2.0 * without - restitution) / (1.0 + restitution)


def check_impulses(code, fault=("", "")):
    """Hold restitution and friction of each pair against those stated.

    Thornton's fit is within 2e-4 of the restitution that the clipped dashpot gives. A grazing pair
    slides all the time, and the ratio of its impulses is friction, without a tail; its normal turns
    by up to 0.4 %, which moves friction by as much.
    """
    jobs = [job(pair, SLOW, way * SLOW, series_every=10) for pair in PAIRS for way in (0.0, 6.0)]
    tables = outputs(code, jobs, fault)
    for number, (pair, (_, _, restitution, friction)) in enumerate(PAIRS.items()):
        head_on, grazing = tables[2 * number : 2 * number + 2]
        assert rebound(head_on, pair) == pytest.approx(restitution, abs=5e-4), pair
        assert head_on["vx"][-1] == pytest.approx(0.0, abs=1e-9), pair
        impulses = sliding(code, restitution) * friction
        assert slides(grazing, pair) == pytest.approx((impulses, impulses), rel=0.02), pair


def check_times(code, fault=("", "")):
    """Hold the time of each elastic contact against Hertz's; of its 2000 steps the ends are off."""
    tables = outputs(code, [job(pair, SLOW, 0.0, **ELASTIC) for pair in PAIRS], fault)
    for pair, table in zip(PAIRS, tables, strict=True):
        moving = np.abs(np.diff(table["vz"])) > 1e-10 * SLOW
        assert moving.sum() / 2000 == pytest.approx(1.0, abs=2e-3), pair
        assert rebound(table, pair) == pytest.approx(1.0, abs=1e-6), pair


def expected(code, pair, along, **more):
    """Return vx and wy of the first body after an impact, by the reference at equal steps.

    The impact is elastic unless a dashpot is among ``more``: those of the rules.
    """
    first, second, _, friction = PAIRS[pair]
    young, partner = bodies_of(pair)[3]
    law = Law(
        normal="hertz",
        youngs_modulus=young,
        partner_youngs_modulus=partner,
        poisson_ratio=P.poisson_ratio,
        partner_poisson_ratio=P.poisson_ratio,
        tangential=LAWS[code.rpartition(":")[2]].law.tangential,
        friction=friction,
        **more,
    )
    height = first["radius"] + (second["radius"] if second else 0.0)
    place = (0.0, 0.0, height * (1 + 1e-9))
    bodies = [sphere(**first, position=place, velocity=(along, 0.0, -SLOW))]
    bodies += [sphere(**second)] if second else []
    steps, step = int(1.6 * 2000), contact_time(pair, SLOW) / 2000
    walls = () if second else (Wall(),)
    scene = Scene(bodies=bodies, walls=walls, law=law, step=step, steps=steps, every=steps)
    motion = reference.run(scene, rules_of(code.partition(":")[0]))
    return motion.velocity[-1, 0, 0], motion.angular_velocity[-1, 0, 1]


def rules_of(code):
    """Return the conventions of a code for an elastic pair of its law."""
    law = LAWS[code].law.replace(damping="none")
    bodies = sphere(**GRAIN), sphere(**GRAIN, position=(0.0, 0.0, 2.0 * P.radius))
    scene = Scene(bodies=bodies, law=law, step=1e-7, steps=1)
    return RULES[code](scene)


def check_springs(code, fault=("", "")):
    """Hold an elastic impact that sticks and slips against the law, in two materials' G*.

    1e-3 of the tangential speed: Yade's scheme is of first order, 2000 steps leave 4e-4.
    """
    along = 0.5 * SLOW
    jobs = [job(pair, SLOW, along, series_every=10, **ELASTIC) for pair in PAIRS]
    for pair, table in zip(PAIRS, outputs(code, jobs, fault), strict=True):
        radius = PAIRS[pair][0]["radius"]
        vx, wy = expected(code, pair, along)
        near = 1e-3 * along
        assert table["vx"][-1] == pytest.approx(vx, abs=near), pair
        assert radius * table["wy"][-1] == pytest.approx(radius * wy, abs=near), pair


def dashpot(code, pair):
    """Return the dashpot of a pair under the rules of a code, as the law takes it."""
    law, restitution = LAWS[code.rpartition(":")[2]].law, PAIRS[pair][2]
    return {
        "damping": "coeff_restitution",
        "restitution": with_tail(restitution) if law.clipped else restitution,
        "clipped": law.clipped,
        "tangential_damping": law.tangential_damping,
    }


def check_dashpots(code, fault=("", "")):
    """Hold an impact with a dashpot that sticks and slips against the law, within 1e-3 likewise.

    Kratos limits its dashpot along the surface twice, which the law does not state: 4.3 %.
    """
    along = 0.5 * SLOW
    jobs = [job(pair, SLOW, along, series_every=10) for pair in PAIRS]
    for pair, table in zip(PAIRS, outputs(code, jobs, fault), strict=True):
        radius = PAIRS[pair][0]["radius"]
        vx, wy = expected(code, pair, along, **dashpot(code, pair))
        near = (0.05 if code == "kratos" else 1e-3) * along
        assert table["vx"][-1] == pytest.approx(vx, abs=near), pair
        assert radius * table["wy"][-1] == pytest.approx(radius * wy, abs=near), pair


CHECKS = pytest.mark.parametrize(
    "check", [check_impulses, check_times, check_springs, check_dashpots]
)


@CODES
@CHECKS
def test_each_pair_of_materials_follows_its_law(code, check):
    check(code)


STEEL_AS_GRAINS = ("steel = (p.steel_youngs_modulus", "steel = (p.youngs_modulus")
FAULTS = [
    ("yade", check_impulses, ("math.atan(friction)", "friction")),
    ("yade", check_impulses, ("(*pair, restitution)", "(*pair, 0.4)")),
    ("yade", check_times, ("hertzian=True", "hertzian=False")),
    ("yade", check_springs, STEEL_AS_GRAINS),
    ("kratos", check_impulses, ("(None, restitution)", "(None, 0.5)")),
    ("kratos", check_impulses, ("= friction\n", "= 1.05 * friction\n")),
    ("kratos", check_times, STEEL_AS_GRAINS),
    ("kratos", check_springs, STEEL_AS_GRAINS),
    ("kratos", check_dashpots, ("(None, restitution)", "(None, 0.8)")),
    ("lammps:yade", check_impulses, ("string limit_damping", "string ''")),
    ("lammps:yade", check_springs, ("tangential ${tangential}", "tangential mindlin")),
    ("lammps:kratos", check_springs, ("tangential ${tangential}", "tangential mindlin/force")),
    ("lammps:kratos", check_dashpots, ("NULL ${tangential_damping}", "NULL 0")),
]


@pytest.mark.live
@pytest.mark.slow
@pytest.mark.parametrize(("code", "check", "fault"), FAULTS)
def test_a_planted_fault_turns_its_check(code, check, fault):
    needs(code)
    with pytest.raises(AssertionError, match="Obtained"):
        check(code, fault)
