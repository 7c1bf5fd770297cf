"""The limit of small steps against the closed forms of the package, section by section."""
# ruff: noqa: I001

import math

import numpy as np
import pytest

from harness.model.law import Law, damping_ratio
from harness.model.scene import Scene, Wall, sphere
from harness.solvers import contacts, reference
from harness.theory import contact
from tests.theory import closed_forms
from tests.solvers.reference.scenes import (
    DAMPED, DMT, FLOOR, G, HERTZ, HOOKE, JKR, LINEAR, MASS, MDR, MINDLIN, R, RHO, ROLLS, STILL,
    TORQUE, TWISTS, VISCOUS, final, guided, impact, resting,
)  # fmt: skip

DOWN = (0.0, 0.0, -1.0)
UNDAMPED = HOOKE.replace(tangential="linear_history", tangential_stiffness=2e5 / 7, friction=0.3)


def restitution(law, speed=1.0, lasts=2.0, tolerance=3e-7, **more):
    def measure(steps):
        scene = impact(law, (0.0, 0.0, -speed), steps, lasts=lasts, **more)
        motion = reference.run(scene)
        v = motion.velocity[:, 0, 2]
        if len(scene.bodies) > 1:
            v = v - motion.velocity[:, 1, 2]
        return {"e": v[-1] / speed}

    return reference.limit(measure, tolerance, most=25_600)["e"]


def within(found, expected, bound):
    assert found.error <= bound
    assert found.value == pytest.approx(expected, abs=bound)


@pytest.mark.parametrize("ratio", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("partner", ["wall", "sphere", "frozen"])
def test_linear_dashpots(ratio, partner):
    mass = 0.5 * MASS if partner == "sphere" else MASS
    eta = 2 * ratio * math.sqrt(1e5 * mass)
    for name, coefficient in (
        ("damping_ratio", ratio), ("velocity", eta), ("mass_velocity", eta / mass)
    ):  # fmt: skip
        law = HOOKE.replace(damping=name, damping_coefficient=coefficient)
        time = contact.duration_unclipped(ratio) / math.sqrt(1e5 / mass)  # one phase of its end
        expected = contact.restitution_unclipped(ratio)
        within(restitution(law, partner=partner, time=time), expected, 1e-6)


@pytest.mark.parametrize("ratio", [0.2, 0.99768, 1.0, 1.5, 5.0])
def test_linear_clipped(ratio):
    law = Law.linear(1e5, ratio, clipped=True)
    within(restitution(law, lasts=10.0), contact.restitution_clipped(ratio), 1e-6)
    if ratio == 1.5:
        assert contact.restitution_clipped(ratio) == pytest.approx(0.075588, abs=1e-6)


@pytest.mark.parametrize("normal", [HOOKE, HERTZ])
@pytest.mark.parametrize("e", [0.2, 0.5, 0.9])
def test_coefficient_of_restitution(normal, e):
    law = normal.replace(damping="coeff_restitution", restitution=e)
    time = None
    if law.normal == "hooke":
        time = contact.duration_unclipped(damping_ratio(e)) / math.sqrt(1e5 / MASS)
    within(restitution(law, lasts=4.0, time=time), e, 2e-5)


@pytest.mark.parametrize("e", [0.3, 0.5, 0.8])
def test_tsuji(e):
    law = HERTZ.replace(damping="tsuji", restitution=e)
    within(restitution(law, lasts=4.0, tolerance=1e-5), e, 0.01)  # of the fitted polynomial


@pytest.mark.parametrize("clipped", [False, True])
def test_viscoelastic(clipped):
    law = HERTZ.replace(**VISCOUS, clipped=clipped)
    k = contact.stiffness(law.moduli[0], R)
    relaxation = closed_forms.relaxation(4e5, MASS, R, k)
    damping = relaxation / contact.largest_hertz_overlap(MASS, k, 1.0)
    expected = closed_forms.impact(damping, clipped=clipped).restitution
    within(restitution(law, lasts=3.0), expected, 1e-6)


def largest(law, speed, density, radius, partner):
    """Return force [N], overlap [m] and duration [s] of an impact of equal spheres or at a wall."""
    other = partner == "sphere"

    def measure(steps):
        mass = 4 / 3 * math.pi * radius**3 * density
        k = contact.stiffness(law.moduli[0], radius * (0.5 if other else 1.0))
        lasts = contact.contact_time(mass * (0.5 if other else 1.0), k, speed)
        step = lasts / steps
        bodies = [sphere(radius, density, position=(0, 0, radius + 0.5 * step * speed),
                         velocity=(0.0, 0.0, -speed))]  # fmt: skip
        if other:
            bodies.append(sphere(radius, density, position=(0, 0, -radius)))
        scene = Scene(bodies=tuple(bodies), walls=() if other else FLOOR, law=law, step=step,
                      steps=steps + 2)  # fmt: skip
        motion = reference.run(scene)
        gap = motion.position[:, 0, 2] - (motion.position[:, 1, 2] + radius if other else 0.0)
        return {"force": motion.force[:, 0, 2].max(), "overlap": (radius - gap).max()}

    return reference.limit(measure, 0.0, first=200, most=3200)


@pytest.mark.parametrize(
    ("law", "radius", "density", "speed", "partner", "force", "overlap", "lasts"),
    [
        ((48e9, 0.2), 0.01, 2800.0, 20.0, "sphere", 10_697.0, 274.1e-6, 40.34e-6),
        ((140e9, 0.3), 0.1, 2699.0, 0.2, "wall", 11_370.0, 49.72e-6, 731.6e-6),
    ],
    ids=["chung-ooi-1", "chung-ooi-2"],
)
def test_hertz_impacts_of_chung_and_ooi(
    law, radius, density, speed, partner, force, overlap, lasts
):
    material = Law(normal="hertz", youngs_modulus=law[0], poisson_ratio=law[1])
    found = largest(material, speed, density, radius, partner)
    shared = 0.5 if partner == "sphere" else 1.0
    mass = 4 / 3 * math.pi * radius**3 * density * shared
    k = contact.stiffness(material.moduli[0], shared * radius)
    assert found["force"].value == pytest.approx(contact.largest_force(mass, k, speed), rel=1e-6)
    assert found["overlap"].value == pytest.approx(
        contact.largest_hertz_overlap(mass, k, speed), rel=1e-6
    )
    assert found["force"].value == pytest.approx(force, rel=1e-3)
    assert found["overlap"].value == pytest.approx(overlap, rel=1e-3)
    assert contact.contact_time(mass, k, speed) == pytest.approx(lasts, rel=1e-3)


def test_bounce_under_gravity():
    law = HOOKE.replace(**DAMPED)
    omega = math.sqrt(1e5 / MASS)
    ratio = 2.0 / (2 * math.sqrt(1e5 * MASS))
    expected = contact.rebound(omega, ratio, G, 0.5)

    def measure(steps):
        scene = impact(law, (0.0, 0.0, -0.5), steps, gravity=(0.0, 0.0, -G), time=expected.duration)
        motion = reference.run(scene)
        after = scene.duration - 0.5 * scene.step - expected.duration
        return {"speed": motion.velocity[-1, 0, 2] + G * after}

    within(reference.limit(measure, 1e-9)["speed"], expected.speed, 1e-6)


# ---- adhesion


def pull(law, start, end, partner="wall", steps=4000):
    """Return overlaps [m] from start to end and forces [N] of a contact that is pulled apart."""
    rise = (start - end) / steps / 1e-6
    scene = guided(law, (steps, (0.0, 0.0, rise), STILL), overlap=start, partner=partner)
    motion = reference.run(scene)
    return R - motion.position[:, 0, 2], motion.force[:, 0, 2]


@pytest.mark.parametrize("partner", ["wall", "sphere"])
def test_jkr_pull_off(partner):
    radius = R if partner == "wall" else 0.5 * R
    end = contact.jkr_overlap("largest tension", 0.5, JKR.moduli[0], radius)
    overlap, force = pull(JKR, -end, 2.0 * end, partner)
    assert -force.min() == pytest.approx(contact.jkr_pull_off(0.5, radius), rel=1e-5)
    assert overlap[force < 0.0].min() == pytest.approx(end, abs=2e-3 * abs(end))
    a = contacts.jkr_radius(JKR.moduli[0], 0.5, radius, end)
    size = contact.jkr_contact_radius("largest tension", 0.5, JKR.moduli[0], radius)
    assert a == pytest.approx(size, rel=1e-9)
    rest = contact.jkr_overlap("without load", 0.5, JKR.moduli[0], radius)
    scene = guided(JKR, (1, STILL, STILL), overlap=rest, partner=partner)
    balance = reference.run(scene).force[-1, 0, 2]
    assert abs(balance) < 1e-9 * contact.jkr_pull_off(0.5, radius)


def test_dmt_pull_off():
    _, force = pull(DMT, 1e-6, -1e-6)
    assert -force.min() == pytest.approx(contact.dmt_pull_off(0.5, R), rel=1e-2)
    scene = guided(DMT, (1, STILL, STILL), overlap=1e-14)
    lightest = reference.run(scene).force[-1, 0, 2]
    assert -lightest == pytest.approx(contact.dmt_pull_off(0.5, R), rel=1e-6)


def test_mdr_pull_off():
    law, modulus = MDR.replace(surface_energy=0.5), 2.0 * MDR.moduli[0]
    tension, last = contact.mdr_pull_off(0.5, modulus, R)
    overlap, force = pull(law, -10.0 * last, 2.0 * last, steps=20_000)
    plain = force / (1 + np.exp(10.7 * overlap / R - 10))
    assert -plain.min() == pytest.approx(tension, rel=1e-6)
    assert overlap[force < 0.0].min() == pytest.approx(last, abs=1e-3 * abs(last))


# ---- friction


@pytest.mark.parametrize("law", [LINEAR, MINDLIN], ids=["linear", "mindlin"])
@pytest.mark.parametrize("partner", ["wall", "sphere"])
def test_slides_throughout(law, partner):
    law = law.replace(damping="none", damping_coefficient=None, tangential_damping=0.0)
    if partner == "sphere":  # stiff, as the contact turns while it lasts
        stiff = {"normal_stiffness": 1e15} if law.normal == "hooke" else {"youngs_modulus": 1e20}
        law = law.replace(**stiff)
        law = law.replace(tangential_stiffness=3e14) if law.tangential_stiffness else law
    vx = 4.0 * closed_forms.slides_throughout(0.3, 1.0)

    def measure(steps):
        velocity, rim = final(impact(law, (vx, 0.0, -1.0), steps, partner=partner))
        return {"slowed": vx - velocity[0], "rim": rim[1]}

    found, share = reference.limit(measure, 1e-6), 0.5 if partner == "sphere" else 1.0
    loss = closed_forms.sliding_impulse(0.3, 1.0, 1.0) * share
    assert found["slowed"].value == pytest.approx(loss, abs=2e-5)
    assert found["rim"].value == pytest.approx(2.5 * loss, abs=5e-5)


@pytest.mark.parametrize("damping", [0.0, 0.5])
def test_sticks_throughout_as_walton(damping):
    law = LINEAR.replace(friction=1e3, tangential_damping=damping)
    ratio, omega = 1.0 / math.sqrt(1e5 * MASS), math.sqrt(1e5 / MASS)
    lasts = contact.duration_unclipped(ratio) / omega
    expected = closed_forms.held(3.5 * 2e5 / 7 / MASS, 3.5 * damping * 2.0 / MASS, lasts)

    def measure(steps):
        velocity, rim = final(impact(law, (0.1, 0.0, -1.0), steps, time=lasts))
        return {"left": (velocity[0] - rim[1]) / 0.1}

    within(reference.limit(measure, 1e-7)["left"], expected, 1e-6)


@pytest.mark.parametrize("name", ["mindlin", "mindlin_rescale", "mindlin_rescale/force"])
def test_curve_of_maw(name):
    """One spring is beside partial slip by at most psi = 1/2, and slides as it does."""
    law = HERTZ.replace(tangential=name, friction=0.3)
    kappa = contact.stiffness_ratio(0.3)
    psi = np.linspace(0.0, 7.0 * kappa - 1.0, 101)[1:]
    back = contact.partial_slip_rebound(psi, 0.3)
    for incidence in (0.2, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0):
        u = incidence * 0.3 / kappa
        velocity, rim = final(impact(law, (u, 0.0, -1.0), 3200))
        found, slides = (velocity[0] - rim[1]) / u * incidence, incidence > psi[-1]
        exact = incidence - 7.0 * kappa if slides else np.interp(incidence, psi, back)
        assert found == pytest.approx(exact, abs=1e-7 if slides else 0.5)


def test_oblique_impact_of_chung_and_ooi_slides_from_its_angle_on():
    tangent = closed_forms.slides_throughout(0.092, 0.98)
    assert math.degrees(math.atan(tangent)) == pytest.approx(32.52, abs=0.01)
    law = Law(normal="hertz", youngs_modulus=760e9, poisson_ratio=0.23, friction=0.092,
              damping="coeff_restitution", restitution=0.98, tangential="mindlin")  # fmt: skip
    velocity, rim = final(impact(law, (1.5 * tangent, 0.0, -1.0), 6400))
    assert 1.5 * tangent - velocity[0] == pytest.approx(0.092 * 1.98, rel=1e-3)
    assert rim[1] == pytest.approx(2.5 * 0.092 * 1.98, rel=1e-3)


@pytest.mark.parametrize(
    ("name", "power"),
    [("mindlin", 1), ("mindlin/force", 0), ("mindlin_rescale", 2), ("mindlin_rescale/force", 1)],
)
def test_unloading_of_mindlin(name, power):
    """Sheared at a_0 and opened to a_1 the force is 8 G* a_0 s (a_1 / a_0)^p (Thornton 2013)."""
    law = HERTZ.replace(tangential=name, friction=1e6)
    scene = guided(law, (100, (0.01, 0.0, 0.0), STILL), (100, (0.0, 0.0, 0.05), STILL))
    force, ratio = reference.run(scene).force[-1, 0, 0], math.sqrt(0.5)
    first = 8.0 * law.moduli[1] * math.sqrt(R * 1e-5) * 1e-6
    assert -force == pytest.approx(first * ratio**power, rel=1e-9)


def test_linear_slider_under_a_constant_limit():
    law = HOOKE.replace(**DAMPED, tangential="linear_history", tangential_stiffness=2e4,
                        tangential_damping=0.2, friction=0.3)  # fmt: skip
    speeds = (0.02, 0.05, -0.03, 0.01)
    scene = guided(law, *((200, (v, 0.0, 0.0), STILL) for v in speeds), step=1e-7)
    expected = contact.limited_forces(2e4, 0.4, 0.3, [(v * 2e-5, 2e-5) for v in speeds])
    found = reference.run(scene.replace(every=200)).force[1:, 0, 0]
    assert found == pytest.approx(expected, rel=1e-9)


# ---- rolling, twisting


@pytest.mark.parametrize("friction", [0.1, 0.5])
def test_slip_to_roll(friction):
    law = LINEAR.replace(friction=friction, tangential_damping=20.0)
    until = 2.0 * 0.1 / (7.0 * friction * G)

    def measure(steps):
        half = final(resting(law, 0.5 * until, steps // 2, velocity=(0.1, 0.0, 0.0)))[0]
        end, rim = final(resting(law, 6.0 * until, 6 * steps, velocity=(0.1, 0.0, 0.0)))
        return {"half": half[0], "end": end[0], "rim": rim[1]}

    found = reference.limit(measure, 1e-7, first=6400)
    assert found["half"].value == pytest.approx(0.1 - 0.5 * friction * G * until, abs=1e-5)
    assert found["end"].value == pytest.approx(5 / 7 * 0.1, abs=1e-6)
    assert found["end"].value + 0.4 * found["rim"].value == pytest.approx(0.1, abs=1e-9)


@pytest.mark.parametrize("angle", [20.0, 60.0])
def test_down_an_incline(angle):
    tilt = math.radians(angle)
    pull = (G * math.sin(tilt), 0.0, -G * math.cos(tilt))
    expected = contact.down_an_incline(tilt, 0.3, G)
    motion = reference.run(resting(LINEAR, 1.0, 50_000, gravity=pull, every=25_000))
    speeds, rims = motion.velocity[:, 0, 0], R * motion.angular_velocity[:, 0, 1]
    assert expected.rolls == (angle == 20.0)
    assert 2.0 * (speeds[2] - speeds[1]) == pytest.approx(expected.acceleration, rel=1e-8)
    assert 2.0 * (rims[2] - rims[1]) == pytest.approx(expected.turning, rel=1e-8)


def test_rolling_resistance():
    law = LINEAR.replace(rolling="sds", rolling_stiffness=1e6, rolling_damping=0.0,
                         rolling_friction=0.05)  # fmt: skip
    velocity, _ = final(resting(law, 0.1, 40_000, velocity=(0.1, 0.0, 0.0), spin=(0.0, 10.0, 0.0)))
    assert 0.1 - velocity[0] == pytest.approx(5 / 7 * 0.05 * G * 0.1, rel=2e-3)


def test_constant_torque_of_rolling():
    law, time = UNDAMPED.replace(**TORQUE), 0.01
    moved = contact.against_constant_torque(time, 0.1, 0.0, MASS, 2e5 / 7, (
        0.3 * MASS * G, 0.05 * MASS * G))  # fmt: skip
    start = {"velocity": (0.1, 0.0, 0.0), "spin": (0.0, 10.0, 0.0)}

    def measure(steps):
        velocity, rim = final(resting(law, time, steps, **start))
        return {"speed": velocity[0], "rim": rim[1]}

    limits = reference.limit(measure, 1e-9, first=1000)
    assert (limits["speed"].value, limits["rim"].value) == pytest.approx(moved, abs=2e-9)


@pytest.mark.parametrize("angle", [1.0, 2.5])
def test_sphere_that_a_constant_torque_holds_creeps_down_by_the_step(angle):
    """The sign of the torque changes from step to step: by 5/2 g sin(angle) h, to 0 with h."""
    law, tilt = UNDAMPED.replace(**TORQUE), math.radians(angle)
    assert math.tan(tilt) < 0.05
    pull, creep = (G * math.sin(tilt), 0.0, -G * math.cos(tilt)), []
    for steps in (20_000, 40_000):
        motion = reference.run(resting(law, 0.4, steps, gravity=pull, every=steps // 2))
        way = float(motion.position[2, 0, 0] - motion.position[1, 0, 0])
        creep.append(way / 0.2 / (0.4 / steps * pull[0]))
    assert creep == pytest.approx([2.5, 2.5], rel=0.1)


def test_rests_on_an_incline():
    law, tilt, limits = LINEAR.replace(**ROLLS), math.radians(2.0), 0.05 * MASS * G
    pull = (G * math.sin(tilt), 0.0, -G * math.cos(tilt))
    load = MASS * -pull[2]
    states = contact.on_an_incline(
        [0.002], pull[0], MASS, (2e5 / 7, 1.0), (2e4, 0.5), (0.3 * load, 0.05 * load)
    )
    velocity, rim = final(resting(law, 0.002, 40_000, gravity=pull))
    assert limits > MASS * pull[0]
    assert velocity[0] == pytest.approx(states[0][1], rel=2e-3)
    assert rim[1] == pytest.approx(states[0][3], rel=2e-3)


@pytest.mark.parametrize("time", [0.002, 0.01, 0.03])
def test_twisting(time):
    law = LINEAR.replace(**TWISTS)
    inertia = 0.4 * MASS * R**2
    expected = contact.twisting_spin(time, 5.0, inertia, (1.0, 1e-4), 1e-4 * MASS * G)
    _, rim = final(resting(law, time, 40_000, spin=(0.0, 0.0, 5.0)))
    assert rim[2] / R == pytest.approx(expected, abs=5e-3)
    assert contact.twisting_deceleration(1e-4, R, G) == pytest.approx(1e-4 * MASS * G / inertia)


def test_marshall():
    law, a = MINDLIN.replace(twisting="marshall"), math.sqrt(R * 1e-5)
    stiffness = 8.0 * law.moduli[1] * a * 0.5 * a * a
    eta = 0.5 * 4e5 * MASS * a * 0.5 * a * a
    scene = guided(law, (100, STILL, (0.0, 0.0, 20.0)), (1000, STILL, (0.0, 0.0, 200.0)))
    torque = reference.run(scene).torque[:, 0, 2]
    assert -torque[100] == pytest.approx(stiffness * 2e-3 + 20.0 * eta, rel=1e-9)
    load = 4 / 3 * law.moduli[0] * math.sqrt(R) * 1e-5**1.5
    assert -torque[-1] == pytest.approx(2 / 3 * a * 0.3 * load, rel=1e-9)


# ---- surroundings


def test_drag():
    scene = Scene(bodies=(sphere(R, RHO, position=(0, 0, 1.0)),), gravity=(0, 0, -G), drag=0.1,
                  step=1e-5, steps=20_000, every=20_000)  # fmt: skip
    speed, fallen = contact.dragged(0.2 * 0.1 / MASS)
    terminal = MASS * G / 0.1
    motion = reference.run(scene)
    assert -motion.velocity[-1, 0, 2] == pytest.approx(speed * terminal, rel=1e-4)
    distance = fallen * terminal * MASS / 0.1
    assert 1.0 - motion.position[-1, 0, 2] == pytest.approx(distance, rel=1e-4)


@pytest.mark.parametrize(("model", "coefficient"), [("radius", 50.0), ("area", 2e5)])
def test_heat(model, coefficient):
    law = HERTZ.replace(heat=model, conductance=coefficient)
    rate = contact.cooling_rate(
        contact.conductance(model, coefficient, math.sqrt(0.5 * R * 1e-5)), (500.0 * MASS,) * 2
    )
    scene = guided(law, (10_000, STILL, STILL), partner="sphere", step=1.0 / rate / 10_000)
    bodies = tuple(
        body.replace(temperature=t, heat_capacity=500.0)
        for body, t in zip(scene.bodies, (400.0, 300.0), strict=True)
    )
    warm = reference.run(scene.replace(bodies=bodies, every=10_000)).temperature[-1]
    assert warm[0] - warm[1] == pytest.approx(100.0 * math.exp(-1.0), rel=1e-3)
    assert warm.sum() == pytest.approx(700.0, rel=1e-12)


@pytest.mark.parametrize("along", [True, False])
def test_wall_that_oscillates(along):
    drive, reach, seconds = 600.0, 2e-6, 0.01
    swing = (reach, 0.0, 0.0) if along else (0.0, 0.0, reach)
    wall = Wall(amplitude=swing, frequency=drive)
    scene = resting(LINEAR, seconds, 40_000).replace(walls=(wall,))
    factor, k, eta = (3.5, 2e5 / 7, 1.0) if along else (1.0, 1e5, 2.0)
    decay, omega = 0.5 * factor * eta / MASS, math.sqrt(factor * k / MASS)
    _, rate = contact.driven(np.array([seconds]), omega, decay, reach * drive**2, drive)
    expected = (rate[0] + reach * drive * math.sin(drive * seconds)) / factor
    if along:  # the slip moves, of which the sphere has 2/7
        expected = (rate[0] + reach * drive * math.sin(drive * seconds)) / 3.5
    assert final(scene)[0][0 if along else 2] == pytest.approx(expected, abs=1e-3 * reach * drive)


@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
def test_bowl(shape):
    """Without friction a sphere swings as a pendulum; in a bowl R* is r W / (W - r)."""
    inside = Wall(shape=shape, radius=0.05, hollow=True, direction=(0.0, 1.0, 0.0))
    law = HERTZ.replace(**VISCOUS)
    curvature = 0.5 if shape == "cylinder" else 1.0
    radius = R * 0.05 / (0.05 - curvature * R)
    overlap = (MASS * G / contact.stiffness(law.moduli[0], radius)) ** (2 / 3)
    length, seconds = 0.04 + overlap, 0.2
    x = 1e-4 * length
    body = sphere(R, RHO, position=(x, 0.0, -math.sqrt(length**2 - x**2)))
    scene = Scene(bodies=(body,), walls=(inside,), law=law, gravity=(0, 0, -G), step=5e-6,
                  steps=40_000)  # fmt: skip
    motion = reference.run(scene.replace(every=100))
    swing = x * np.cos(math.sqrt(G / length) * motion.time)
    assert motion.position[:, 0, 0] == pytest.approx(swing, abs=2e-4 * x)
    assert motion.force[0, 0, 2] == pytest.approx(MASS * G, rel=1e-6)
    assert seconds == pytest.approx(scene.duration)


def test_turning_cylinder_takes_a_sphere_along():
    """Pressed in without weight, it ends where the rims move as one: no slip."""
    wall = Wall(shape="cylinder", radius=0.05, hollow=True, spin=(0.0, 0.0, 2.0))
    law = LINEAR.replace(**DAMPED)
    body = sphere(R, RHO, position=(0.04 + 1e-6, 0.0, 0.0), motion="held")
    scene = Scene(bodies=(body, sphere(R, RHO, position=(0, 0, 1))), walls=(wall,), law=law,
                  step=1e-6, steps=1)  # fmt: skip
    free = scene.replace(bodies=(body.replace(motion="free", axes=(False, False, False)),),
                         steps=200_000, every=200_000)  # fmt: skip
    spin = reference.run(free).angular_velocity[-1, 0, 2]
    assert spin * R == pytest.approx(2.0 * 0.05, rel=1e-6)
