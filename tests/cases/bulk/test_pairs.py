"""Pairs of the bulk scripts, and of LAMMPS under the rules of others, at equal steps."""

import math
from dataclasses import replace

import numpy as np
import pytest

from harness.cases.bulk.comparison import bulk_law, stated_law, with_tail
from harness.cases.bulk.penetration import CASE, Penetration
from harness.engines.base import Job
from harness.engines.registry import engine_class
from harness.model.scene import Scene, Wall, sphere
from harness.solvers import reference
from tests.cases.bulk.doubles import RULES, StandIn, changed, needs, run

P = Penetration(poisson_ratio=0.3)
STEEL = {"radius": P.steel_radius, "density": P.steel_density}
GRAIN = {"radius": P.radius, "density": P.density}

PAIR = '''
class Pair(System):
    """Two bodies of which the first meets the second obliquely, or a wall."""

    COLUMNS = "t,vx,vz,wy".split(",")

    def build(self):
        p = self.p
        first, second = (globals()[word] for word in p.places.split("_"))
        radii = [p.radius, p.steel_radius, 0.0]
        height = (radii[first] + radii[second]) * (1 + 1e-9)
        if second == WALL:
            self.spheres.wall(WALL, (0, 0, 0), (0, 0, 1), 1.0)
        else:
            self.spheres.add(second, (0, 0, 0), radii[second], held=True)
        self.first = self.spheres.add(first, (0, 0, height), radii[first], held=True)

    def at_rest(self, states):
        return {}

    at_end = at_rest

    def disturb(self):
        for number in range(self.first):
            self.spheres.release(number, (0.0, 0.0, 0.0))
        self.spheres.release(self.first, (self.p.offset, 0.0, -self.p.speed))

    def row(self, step, states):
        _, _, _, velocity, spin = states[self.first]
        return [step * self.p.step_size, velocity[0], velocity[2], spin[1]]


if __name__'''

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

SLOW = ("yade", "kratos")
PAIRS = {
    "GRAIN_WALL": (GRAIN, None, P.steel_restitution, P.steel_friction),
    "GRAIN_SPHERE": (GRAIN, STEEL, P.steel_restitution, P.steel_friction),
    "SPHERE_GRAIN": (STEEL, GRAIN, P.steel_restitution, P.steel_friction),
    "GRAIN_GRAIN": (GRAIN, GRAIN, P.restitution, P.friction),
    "SPHERE_WALL": (STEEL, None, P.steel_restitution, P.steel_friction),
}
LAWS = {
    code: stated_law(StandIn("penetration", code), bulk_law(P.poisson_ratio))
    for code in ("lammps", "yade", "kratos")
}
SPEED = 0.003  # [m/s]: overlaps of 5e-4 of a radius
STEPS = 2000  # in a contact
ALONG = (0.0, 0.5, 6.0)  # tangential over normal speed: head-on, sticks and slips, slides
ELASTIC = {"restitution": 1.0, "steel_restitution": 1.0}
# largest difference of a velocity from the reference at equal steps, over the speed of the impact,
# elastic and with the dashpot. Kratos has levers of its own between unequal spheres, by shares of
# the overlap, and limits its dashpot along the surface twice
TOLERANCES = {
    "lammps": (1e-9, 1e-9),
    "lammps:yade": (1e-9, 1e-9),
    "lammps:kratos": (1e-9, 1e-9),
    "yade": (1e-9, 1e-9),
    "kratos": (3e-4, 0.03),
}


def driven(code, fault):
    """Return an engine whose script lets pairs meet, perhaps with a planted fault."""

    def change(text):
        assert fault[0] in text
        text = text.replace(*fault) if fault[0] else text
        if code == "lammps":
            return text.partition("# ---- what is watched")[0] + LAMMPS_PAIR
        return text.replace("if __name__", PAIR.lstrip()).replace("System(Simple", "Pair(Simple")

    return changed(engine_class(code), change)


def step_of(pair):
    """Return 1/2000 of Hertz's contact time without a dashpot [s]: 2.9432 deepest/speed."""
    first, second, _, _ = PAIRS[pair]
    bodies = [sphere(**one) for one in (first, second) if one]
    mass, radius = (
        1.0 / sum(1.0 / getattr(body, name) for body in bodies) for name in ("mass", "radius")
    )
    modulus = 1.0 / sum((1.0 - P.poisson_ratio**2) / young for young in moduli(pair))
    deepest = (15.0 * mass * SPEED**2 / (16.0 * math.sqrt(radius) * modulus)) ** 0.4
    return 2.9432 * deepest / SPEED / STEPS


def moduli(pair):
    """Return Young's modulus of both bodies [Pa]; walls are of steel."""
    first, second, _, _ = PAIRS[pair]
    both = first, second or STEEL
    return [P.youngs_modulus if one is GRAIN else P.steel_youngs_modulus for one in both]


def job(pair, along, **changes):
    """Return the impact of a pair over 1.6 contact times."""
    steps = int(1.6 * STEPS)
    values = {
        "places": pair, "speed": SPEED, "offset": along * SPEED, "gravity": 1e-12,
        "step_size": step_of(pair), "settle_steps": 0, "steps": steps, "series_every": steps,
    }  # fmt: skip
    return Job(CASE.template, {**P.values, **values, **changes}, sampled=True)


def measured(code, trials, fault=("", "")):
    """Return vx, vz [m/s] and r w [m/s] of the first body after each trial, (trials, 3)."""
    code, _, rules = code.partition(":")
    jobs = [job(pair, along, **(ELASTIC if law else {})) for law, pair, along in trials]
    if rules:
        jobs = [replace(one, values=LAWS[rules].values(one.values)) for one in jobs]
    tables = [one.tables["series"] for one in run(driven(code, fault), *jobs)]
    radii = [PAIRS[pair][0]["radius"] for _, pair, _ in trials]
    return np.array(
        [(t["vx"][-1], t["vz"][-1], r * t["wy"][-1]) for t, r in zip(tables, radii, strict=True)]
    )


def expected(code, pair, along, elastic):
    """Return vx, vz and r w of the first body after an impact, by the reference at equal steps."""
    first, second, restitution, friction = PAIRS[pair]
    code, _, rules = code.partition(":")
    stated, (young, partner) = LAWS[rules or code].law, moduli(pair)
    law = stated.replace(
        youngs_modulus=young,
        partner_youngs_modulus=partner,
        friction=friction,
        restitution=with_tail(restitution) if stated.clipped else restitution,
    )
    law = law.replace(damping="none") if elastic else law
    place = (0.0, 0.0, (first["radius"] + (second["radius"] if second else 0.0)) * (1 + 1e-9))
    bodies = [sphere(**first, position=place, velocity=(along * SPEED, 0.0, -SPEED))]
    bodies += [sphere(**second)] if second else []
    steps = int(1.6 * STEPS)
    scene = Scene(bodies=bodies, walls=() if second else (Wall(),), law=law, step=step_of(pair),
                  steps=steps, every=steps)  # fmt: skip
    motion = reference.run(scene, rules_of(code))
    (vx, _, vz), spin = motion.velocity[-1, 0], motion.angular_velocity[-1, 0, 1]
    return vx, vz, first["radius"] * spin


def rules_of(code):
    """Return the conventions of a code for an elastic pair of its law."""
    bodies = sphere(**GRAIN), sphere(**GRAIN, position=(0.0, 0.0, 2.0 * P.radius))
    law = LAWS[code].law.replace(damping="none")
    rules = RULES[code](Scene(bodies=bodies, law=law, step=1e-7, steps=1))
    # walls of Yade's bulk scripts are triangles, those of its scenes boxes, whose lever is r - d
    return rules.replace(wall_lever="contact_point") if code == "yade" else rules


def differences(code, elastic, fault=("", "")):
    """Return the largest difference of a velocity over the speed, by law, pair and slope.

    ``elastic`` is whether impacts are, for each law.
    """
    trials = [(law, pair, along) for law in elastic for pair in PAIRS for along in ALONG]
    found = measured(code, trials, fault)
    known = [expected(code, pair, along, law) for law, pair, along in trials]
    off = np.abs(found - np.array(known)).max(axis=1) / SPEED
    return dict(zip(trials, off.tolist(), strict=True))


CODES = [
    pytest.param(code, marks=[pytest.mark.live, *([pytest.mark.slow] if code in SLOW else [])])
    for code in TOLERANCES
]


@pytest.mark.parametrize("code", CODES)
def test_each_pair_of_materials_follows_its_law(code):
    needs(code)
    off = differences(code, (True, False))
    for elastic, tolerance in zip((True, False), TOLERANCES[code], strict=True):
        assert max(size for trial, size in off.items() if trial[0] is elastic) < tolerance, off


STEEL_AS_GRAINS = ("steel = p.steel_youngs_modulus", "steel = p.youngs_modulus")
FAULTS = [  # code, whether the impacts are elastic, words of its script
    ("yade", False, ("math.atan(friction)", "friction")),
    ("yade", False, ("(*pair, restitution)", "(*pair, 0.4)")),
    ("yade", True, ("hertzian=True", "hertzian=False")),
    ("yade", True, STEEL_AS_GRAINS),
    ("kratos", False, ("(None, restitution)", "(None, 0.5)")),
    ("kratos", True, ("= friction\n", "= 1.05 * friction\n")),
    ("kratos", True, STEEL_AS_GRAINS),
    ("lammps:yade", False, ("string limit_damping", "string ''")),
    ("lammps:yade", True, ("tangential ${tangential}", "tangential mindlin")),
    ("lammps:kratos", True, ("tangential ${tangential}", "tangential mindlin/force")),
    ("lammps:kratos", False, ("NULL ${tangential_damping}", "NULL 0")),
]


@pytest.mark.live
@pytest.mark.slow
@pytest.mark.parametrize(("code", "elastic", "fault"), FAULTS)
def test_a_planted_fault_turns_a_pair(code, elastic, fault):
    needs(code)
    off = differences(code, (elastic,), fault)
    assert max(off.values()) > 2.0 * TOLERANCES[code][0 if elastic else 1]
