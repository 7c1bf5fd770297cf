"""Background and first half of the methods, equations (2) to (13): one grain on the incline."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from typing import Any

import numpy as np
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from harness.cases.bench import Bench
from harness.cases.incline.angle import CriticalAngle
from harness.cases.incline.search import angle_on, prepared, reference_measure, search
from harness.cases.incline.system import Incline, Route
from harness.cases.tower.impulse import STIFFNESSES
from harness.cases.tower.parameters import Tower
from harness.errors import EngineError, RequestError, Unsupported
from harness.model.conventions import Rules
from harness.model.law import Contact, damping_ratio
from harness.model.scene import Scene
from harness.reproduction import HALF_DIGIT, Floats, Statement, generator
from harness.results.rows import Kind
from harness.theory.chain import impulse_on_fixed, shock_from_restitution
from harness.theory.incline import after_next_shock, critical_angle, no_flight_bound, steady_energy

LONG = 2000  # shocks after which the energy has its limit
SAMPLES = 100
PRINTED_ANGLE = 10.21  # [deg]
OURS = "Errata, of our restatement"

# ---- energies of the incline [m g d]


def energies() -> Iterator[Statement]:
    """Yield table I and the text to figure 3: energies between well and crest."""
    angles = generator().uniform(0.1, 29.9, SAMPLES)
    yield Statement("table-1-well", "Background, Table I", "C = m g r (1 - cos(pi/6 - theta))",
        [depth_of_well(angle) for angle in angles], 1 - np.cos(np.pi / 6 - np.radians(angles)),
        unit="m g d",
        note="r is the distance of the centres; the radius, as eq. (11) needs it, gives half of it",
    )  # fmt: skip
    drops = [height(0.0, 0.0, angle) - height(1.0, 0.0, angle) for angle in angles]
    yield Statement("table-1-gain", "Background, Table I", "dE = m g r sin(theta)", drops,
        np.sin(np.radians(angles)), unit="m g d", note="drop from sphere to sphere")  # fmt: skip
    energy, tilt = steady_energy(PRINTED_ANGLE, 0.25), PRINTED_ANGLE
    from_vertical = np.radians(np.linspace(-(30 - tilt), 30 + tilt, 2001))
    fallen = math.cos(math.radians(30 - tilt)) - np.cos(from_vertical)
    share = 1 - 2 * (energy + fallen) / np.cos(from_vertical)
    yield Statement("constant-contact", "Background, text to Fig. 3",
        "the grain crosses without leaving the row, under less than the normal component of "
        "gravity", share.min() > 0 and share.max() <= 1,
        note=f"in steady motion the contact carries {share.min():.3f} to {share.max():.3f} of it"
        f"; contact lasts up to {no_flight_bound():.2f} deg")  # fmt: skip


def height(along: float, normal: float, angle_deg: float) -> float:
    """Return the height [d] of a point of the row's own frame once the row is tilted."""
    tilt = math.radians(angle_deg)
    return normal * math.cos(tilt) - along * math.sin(tilt)


def depth_of_well(angle_deg: float) -> float:
    """Return the height [d] of a crest over the well before it, from coordinates.

    Spheres are at 0 and 1; the grain's centre is the tip of an equilateral triangle in the well,
    and one diameter above the second sphere on the crest.
    """
    crest = height(1.0, 0.0, angle_deg) + 1.0
    return crest - height(0.5, math.sqrt(3) / 2, angle_deg)


def energy_sums() -> Iterator[Statement]:
    """Yield equations (2) to (5): the energy after n shocks, E[j+1] = (E[j] + dE) shock."""
    random = generator()
    cases = [
        (int(random.integers(3, 12)), *random.uniform([0.05, 0.05, 0.1], [1.0, 1.0, 0.9]))
        for _ in range(SAMPLES)
    ]
    n, start, gained, shock = np.array(cases).T
    energy = [iterated(*case) for case in cases]

    def power_sum(count: Floats) -> Floats:  # 1 + shock + ..., so many powers
        return np.asarray((1 - shock**count) / (1 - shock))

    def term_by_term(more: int) -> list[float]:
        return [sum(r**p for p in range(int(k) + more)) for r, k in zip(shock, n, strict=True)]

    yield Statement("eq-2", "Background, eq. (2)",
        "E_n = E_0 shock^n + dE shock (shock^(n-1) + shock^(n-1) + ... + 1)", energy,
        start * shock**n + gained * shock * (2 * shock ** (n - 1) + power_sum(n - 2)),
        start * shock**n + gained * shock * power_sum(n), unit="m g d",
        note=f"n steps of the map at {SAMPLES} random n, E_0, dE and shocks",
        correction="second term shock^(n-2): every power from n - 1 to 0 once")  # fmt: skip
    yield Statement("eq-3", "Background, eq. (3)", "1 + x + ... + x^n = (1 - x^(n+1))/(1 - x)",
                    term_by_term(1), power_sum(n + 1), note="term by term")  # fmt: skip
    yield Statement("eq-3-index", "Background, eqs. (2) and (3)",
        "the bracket of eq. (2) is the S_n of eq. (3)",
        term_by_term(0), power_sum(n + 1), power_sum(n),
        correction="it is S_(n-1), (1 - shock^n)/(1 - shock): it has n terms")  # fmt: skip
    first = (start + gained) * shock
    yield Statement("eq-4", "Background, eq. (4)",
        "E_n = E_1 shock^(n-1) + dE shock (1 - shock^(n-1))/(1 - shock)", energy,
        first * shock ** (n - 1) + gained * shock * power_sum(n - 1), unit="m g d")  # fmt: skip
    above, at, below = (
        iterated(2 * LONG, 0.1, 0.2, shock) > 1.5 * iterated(LONG, 0.1, 0.2, shock)
        for shock in (1.01, 1.0, 0.99)
    )
    yield Statement("divergence", "Background, after eq. (4)",
        "E_n goes to infinity if the shock is above 1; else it approaches a constant",
        above and not at and not below, corrected=above and at and not below,
        note=f"E_n grows at shock 1.01: {above}, 1: {at}, 0.99: {below}",
        correction="from shock 1 on, there by dE each shock")  # fmt: skip
    gained, shock = generator().uniform([0.05, 0.1], [1.0, 0.9], (SAMPLES, 2)).T
    yield Statement("eq-5", "Background, eq. (5)", "lim E_n = dE shock/(1 - shock)",
        [iterated(LONG, 0.3, *case) for case in zip(gained, shock, strict=True)],
        gained * shock / (1 - shock), tolerance=1e-11, unit="m g d",
        reason="round-off of 2000 shocks")  # fmt: skip


def iterated(shocks: int, start: float, gained: float, shock: float) -> float:
    """Return E_n [m g d] by n steps of E[j+1] = (E[j] + dE) shock."""
    energy = start
    for _ in range(shocks):
        energy = (energy + gained) * shock
    return energy


# ---- critical angle and shock


def angles() -> Iterator[Statement]:
    """Yield equation (6), theta_c, and the angle at which a grain at rest starts."""

    def margin(angle: float, divisor: float) -> float:
        tilt = math.radians(angle)
        return 1 / 3 - 2 * math.sin(math.pi / 12 - tilt / divisor) ** 2 / math.sin(tilt)

    fate = fate_angle(0.25)
    printed, right = (float(brentq(margin, 0.5, 29.5, args=(part,))) for part in (4.0, 2.0))
    yield Statement(
        "eq-6", "Background, eq. (6)", "shock/(1 - shock) >= 2 sin^2(pi/12 - theta/4)/sin(theta)",
        fate, printed, right, tolerance=1e-5, unit="deg",
        reason="the fate of the energy map is bisected to 1e-6 deg",
        note=f"closed form {critical_angle():.4f} deg",
        correction="theta/2: 1 - cos(a) = 2 sin^2(a/2) with a = pi/6 - theta")  # fmt: skip
    yield Statement(
        "critical-angle", "Background, after eq. (9)", "theta_c = 10.21 deg", fate, PRINTED_ANGLE,
        tolerance=0.005, unit="deg", reason=HALF_DIGIT,
        note="bisection of the fate of the energy map")  # fmt: skip


def fate_angle(shock: float) -> float:
    """Return the smallest angle [deg] at which motion lasts, to 1e-6 deg, by the energy map."""

    def lasts(angle: float) -> bool:
        depth = depth_of_well(angle)
        energy = 2 * depth
        for _ in range(LONG):
            if energy < depth:
                return False
            energy = after_next_shock(energy, angle, shock)
        return True

    low, high = 0.0, 30.0
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if lasts(middle) else (middle, high)
    return 0.5 * (low + high)


def shocks() -> Iterator[Statement]:
    """Yield equations (7) to (9): collisions at unit speed, 60 deg off the new tangent."""
    restitution = np.linspace(0.0, 1.0, 21)
    normal, before = np.array([-1.0, 0.0]), np.array([math.sqrt(3) / 2, -0.5])
    velocity = before - np.outer(1 + restitution, float(before @ normal) * normal)
    energy, speed = np.sum(velocity**2, axis=1), np.hypot(*velocity.T)
    yield Statement("eq-7", "Background, eq. (7)",
        "shock = |(v' - v)/v'|^2 is the kinetic energy after over that before the shock", energy,
        (1 - speed) ** 2, speed**2,
        correction="shock = (v/v')^2; the two agree at e_n = 0 alone")  # fmt: skip
    yield Statement(
        "eq-8", "Background, eq. (8)", "v = sqrt((v'/2)^2 + (e_n v' sqrt(3)/2)^2)", speed,
        np.sqrt(0.25 + (restitution * math.sqrt(3) / 2) ** 2), unit="v'")  # fmt: skip
    kept = 0.25 + 0.75 * restitution**2
    yield Statement("eq-9", "Background, eq. (9)", "shock = (1 - sqrt(1/4 + 3/4 e_n^2))^2", energy,
        (1 - np.sqrt(kept)) ** 2, kept,
        correction="shock = 1/4 + 3/4 e_n^2; the formula gives 0 where nothing is lost, at e_n = 1",
    )  # fmt: skip


def contact_and_rest() -> Iterator[Statement]:
    """Yield the restitution of the source's contact, and the angle at which a grain starts."""
    zeta = damping_ratio(1e-20)
    _, restitution = damped_contact(1.0, 1.0, 2 * zeta * math.sqrt(0.5))
    yield Statement(
        "restitution", "Background, on the MFiX runs", "normal restitution is nearly zero (1e-20)",
        restitution, 1e-20, tolerance=1e-4,
        reason="the energy kept is 1/4 + 3/4 e^2: below 1e-4, e moves it by 1e-8",
        note=f"damping ratio {zeta * math.sqrt(0.5):.4f} in place of {zeta:.4f}",
        correction="the effective mass on a fixed sphere is m, not MFiX's m/2")  # fmt: skip

    def upper_contact(angle: float) -> float:
        directions, tilt = np.radians([60.0, 120.0]), math.radians(angle)
        normals = np.array([np.cos(directions), np.sin(directions)])
        return float(np.linalg.solve(normals, [-math.sin(tilt), math.cos(tilt)])[0])

    yield Statement("rest-angle", "Background, last paragraphs",
        "at rest the grain starts above 30 deg only: hysteresis",
        float(brentq(upper_contact, 0.0, 60.0)), 30.0, tolerance=0.5, unit="deg",
        reason=HALF_DIGIT, note="equilibrium: the contact uphill is without force there",
    )  # fmt: skip


def damped_contact(
    stiffness: float, mass: float, damping: float, *, clipped: bool = False
) -> tuple[float, float]:
    """Return duration [s] and restitution of m x'' + gamma x' + k x = 0, which touches at 1 m/s.

    It is integrated until the overlap is gone, a ``clipped`` contact until its force is. Errors
    are below 1e-10 of both numbers.
    """

    def end(_: float, state: Any) -> float:
        return float(stiffness * state[0] + damping * state[1] if clipped else state[0])

    end.terminal, end.direction = True, -1  # type: ignore[attr-defined]
    period = (mass / stiffness) ** 0.5
    solution = solve_ivp(
        lambda _, s: [s[1], -(stiffness * s[0] + damping * s[1]) / mass],
        (0.0, 100 * period), [1e-13 * period, 1.0],
        method="DOP853", events=end, rtol=1e-11, atol=1e-14 * period)  # fmt: skip
    return float(solution.t[-1]), -float(solution.y[1, -1])


# ---- the incline in MFiX's scheme, by the reference

MFIX_RUNS = "Background, on the MFiX runs, and Fig. 4"
MFIX_CONTACT = Contact(
    name="MFiX", restitution=1e-20, effective_mass="half"
)  # m/2 on a fixed sphere
COARSE, FINE = 50, 5000  # ``DTSOLID_FACTOR``: MFiX's default, and a hundred times it
FROM_PASSAGE = 1000  # factor from which a passage gives the same angle for a tenth of the steps
RESOLUTION_DEG = 1e-3
WITHIN = 0.01  # [deg] "to one-hundredth of a degree"
AGREEMENT = "the agreement that the source states"


def mfix_scheme() -> Iterator[Statement]:
    """Yield the agreement with MFiX, and what a refined step makes of it."""
    angle = mfix_angle(1e7, COARSE)
    yield Statement("mfix-angle", MFIX_RUNS,
        "the smallest angle of steady motion in MFiX is 10.21 deg to a hundredth of a degree",
        angle.value if angle else math.nan, PRINTED_ANGLE, tolerance=WITHIN, unit="deg",
        uncertainty=angle.uncertainty if angle else 0.0, reason=AGREEMENT,
        note="reference in MFiX's scheme at its default step, 1e7 N/m; the source names no "
        "stiffness")  # fmt: skip

    def errors(factor: int) -> list[float]:
        angles = [mfix_angle(stiffness, factor) for stiffness in STIFFNESSES]
        return [math.nan if a is None else a.value - critical_angle() for a in angles]

    coarse, fine = errors(COARSE), errors(FINE)
    words = [", ".join(f"{error:+.4f}" for error in some) for some in (coarse, fine)]
    yield Statement("mfix-validation", MFIX_RUNS, "the agreement validates the analysis",
        all(abs(b) <= abs(a) for a, b in zip(coarse, fine, strict=True)),
        reason="a refined step must not be further from the closed form",
        note=f"{words[0]} deg at the default step, {words[1]} deg at a hundredth (1e5 to 1e7 N/m)",
        correction="take the step to zero first, then the stiffness to infinity")  # fmt: skip


class MfixConventions(Bench):
    """A bench without a program whose reference takes the steps of MFiX's Euler scheme."""

    def rules(self, scene: Scene) -> Rules:  # noqa: ARG002 - of every scene
        """Return the conventions of MFiX 21.3.2."""
        # spheres that just touch, as at the start, are apart
        return Rules(scheme="mfix_euler", frozen_mass="own", least_overlap=1e-15)


@cache
def mfix_angle(stiffness: float, factor: int) -> CriticalAngle | None:
    """Return the critical angle in MFiX's scheme, None where its step is unstable.

    The incline is the source's (1 m, 1 kg) at k [N/m]; ``factor``, ``DTSOLID_FACTOR``, divides the
    duration of the damped contact of m/2, pi sqrt(m/k) / sqrt(2 (1 - zeta^2)). Coarse steps are
    searched by steady motion, fine ones by passage. The source starts a grain at 1.5 m/s, a case
    here at 1.503 m/s: that moves the angle of a coarse step by 1.5e-3 deg at most.
    """
    steps = factor * math.sqrt(2.0 * (1.0 - MFIX_CONTACT.zeta**2))
    case = Incline(stiffness=stiffness, contact=MFIX_CONTACT, steps_per_contact=steps)
    method: Route = "passage" if factor >= FROM_PASSAGE else "steady"
    try:
        measure = reference_measure(MfixConventions(None), method)
        return search(measure, prepared(case, method), method, RESOLUTION_DEG)
    except RequestError:
        return None


# ---- an engine in MFiX's place

STEPS = (50.0, 100.0, 200.0, 400.0)  # per contact time
IN_ITS_PLACE = "Background, on the MFiX runs; an engine in its place"


def on_engine(bench: Bench | None) -> Iterator[Statement]:
    """Yield what an engine makes of the incline; not tested are those whose own runs failed."""
    cases = [Incline(steps_per_contact=steps) for steps in STEPS]
    cases.append(Incline(contact=Contact(restitution=0.1)))
    outcomes = [angle_or_error(bench, case) for case in cases]
    failures = [None if isinstance(angle, CriticalAngle) else angle for angle in outcomes]
    angles = [math.nan if isinstance(angle, Exception) else angle.value for angle in outcomes]
    spreads = [0.0 if isinstance(angle, Exception) else angle.uncertainty for angle in outcomes]
    run: dict[str, Any] = {"unit": "deg", "kind": Kind.CROSS_CODE}
    if bench is not None:
        run["engine"] = bench.name
        with suppress(EngineError):  # which is that of every run as well
            run["version"] = bench.engine.identify().engine_version
    yield Statement("engine-angle", IN_ITS_PLACE,
        "theta_c is 10.21 deg to a hundredth of a degree, 1e6 N/m", failures[0] or angles[0],
        PRINTED_ANGLE, tolerance=WITHIN, reason=AGREEMENT, uncertainty=spreads[0],
        note="the source's contact, tail kept, 50 steps per contact, passage", **run)  # fmt: skip
    words = ["no angle" if math.isnan(angle) else f"{angle:.4f} deg" for angle in angles]
    over_steps = ", ".join(f"{w} at {steps:g}" for w, steps in zip(words, STEPS, strict=False))
    yield Statement("engine-step", IN_ITS_PLACE, "the angle does not depend on the step",
        failures[0] or failures[3] or angles[3], angles[0], tolerance=WITHIN, reason=AGREEMENT,
        note=f"{over_steps} steps per contact",
        correction="extrapolate step and stiffness, no tail and no rebound", **run)  # fmt: skip
    kept, lost = (critical_angle(shock_from_restitution(0.1, r)) for r in ("kept", "lost"))
    yield Statement("engine-restitution",
        "Background, eqs. (6) and (9); an engine in MFiX's place",
        "at e_n = 0.1 theta_c follows from the shock of eq. (9)", failures[4] or angles[4], lost,
        tolerance=0.05, reason="effect of step and stiffness at 1e6 N/m", uncertainty=spreads[4],
        note=f"{lost:.3f} deg by eq. (9), {kept:.3f} deg by 1/4 + 3/4 e^2",
        correction="neither reading: rebounds end within a well, and theta_c stays",
        **run)  # fmt: skip


def angle_or_error(bench: Bench | None, case: Incline) -> CriticalAngle | Unsupported | EngineError:
    """Return the critical angle of a case in an engine, or why it has none."""
    if bench is None:
        return Unsupported("no engine was given to run the incline")
    try:
        return angle_on(bench, case)
    except RequestError as error:  # a passage that cannot be measured
        return Unsupported(str(error))
    except (Unsupported, EngineError) as error:
        return error


# ---- rigidity and times

GRAVITY, CONTACT_TIME, CREST_TIME = 9.81, 0.007, 0.41  # [m/s2], [s], [s] as printed
GLASS_MODULUS, GLASS_DENSITY, PACKING, DEPTH = 70e9, 2500.0, 0.6, 0.5  # [Pa], [kg/m3], [1], [m]
RIGIDITY = "Methods, after eq. (10)"


def rigidity() -> Iterator[Statement]:
    """Yield equation (10), the rigidity, and the stiffnesses that follow from it."""
    metres, centimetres = (1e5, 9.81, 1.0), (1e5 / 100, 9.81 / 100**2, 100.0)  # k, P, d
    printed = [k / pressure for k, pressure, _ in (metres, centimetres)]
    right = [k / (pressure * d) for k, pressure, d in (metres, centimetres)]
    yield Statement("eq-10", "Methods, eq. (10)", "kappa = k/P is a number without dimension",
        math.isclose(*printed, rel_tol=1e-12), corrected=math.isclose(*right, rel_tol=1e-12),
        note=f"k/P is {printed[0]:.5g} in metres and {printed[1]:.5g} in centimetres: a length",
        correction="kappa = k/(P d); as printed for disks, whose P is per length")  # fmt: skip
    pressure = GLASS_DENSITY * PACKING * GRAVITY * DEPTH
    yield Statement(
        "glass-bead", RIGIDITY, "a glass bead under 50 cm of beads has a rigidity of 40,000",
        (GLASS_MODULUS / pressure) ** (2 / 3), 40_000.0, tolerance=5000.0, reason=HALF_DIGIT,
        note="Hertz, (E/P)^(2/3)")  # fmt: skip
    yield Statement("orders-of-magnitude", f"{RIGIDITY}; Results, before Fig. 10",
        "rigidities of 1e4 to 1e6 span three orders of magnitude", math.log10(1e6 / 1e4), 3.0,
        float(len(STIFFNESSES) - 1), tolerance=0.5, reason=HALF_DIGIT,
        correction="three values, two orders of magnitude")  # fmt: skip
    weight = 1.0 * GRAVITY / 1.0  # [N/m] pressure of a row of disks, 1 kg and 1 m
    yield Statement("stiffness", RIGIDITY,
        "rigidities 1e4 and 1e6 are stiffnesses of 1e5 and 1e7 N/m at 9.81 m/s2",
        [1e5 / weight / 1e4, 1e7 / weight / 1e6], [1.0, 1.0], tolerance=0.5,
        reason="half of the last digit, of each rigidity", note="over the printed")  # fmt: skip


def times() -> Iterator[Statement]:
    """Yield equations (11) and (12): from well to crest, and of a contact."""
    drop = 1 - math.sqrt(3) / 2  # [d] from crest to well of a level row, Pythagoras
    escape = math.sqrt(2 * GRAVITY * drop * 2.0) / 8 / GRAVITY
    yield Statement(
        "eq-11", "Methods, eq. (11)", "t_c = 1/4 sqrt(2g 2r (1 - sin 60)) cos 60/g", escape,
        crest_time(1.0), unit="s", note="an eighth of the speed of escape over g, r = 1 m",
    )  # fmt: skip
    needed = float(brentq(lambda r: crest_time(r) - CREST_TIME, 1e-3, 1e6))
    yield Statement(
        "t-c", "Methods, eq. (11)", "the formula gives t_c = 0.41 s", crest_time(1.0), CREST_TIME,
        tolerance=0.005, unit="s", reason=HALF_DIGIT,
        note=f"0.41 s needs a radius of {needed:.0f} m",
        correction="t_c = 0.029 s by the formula")  # fmt: skip
    fastest, slow = rise_time(no_flight_bound()), rise_time(critical_angle() + 1e-6)
    yield Statement("crest-time", "Methods, before eq. (11)",
        "the grain takes about 0.41 s from well to crest", fastest <= CREST_TIME <= slow,
        reason="between the shortest and the longest rise in steady motion",
        note=f"steady motion takes {fastest:.3f} s at the flight bound and {slow:.2f} s just above "
        "theta_c")  # fmt: skip
    k, m, gamma = generator().uniform([50, 0.3, 0.5], [200, 1.0, 5.0], (50, 3)).T
    yield Statement("eq-12", "Methods, eq. (12)", "t_n = pi (k/m_eff - (gamma/m_eff)^2)^(-1/2)",
        [damped_contact(*case)[0] for case in zip(k, m, gamma, strict=True)],
        np.pi / np.sqrt(k / m - (gamma / m) ** 2), np.pi / np.sqrt(k / m - (gamma / (2 * m)) ** 2),
        tolerance=1e-8, unit="s", reason="integration with a relative tolerance of 1e-11",
        correction="(gamma/(2 m_eff))^2; without damping, as here, nothing changes")  # fmt: skip
    fixed = Tower(stiffness=1e5, gravity=0.0).contact_time
    yield Statement(
        "t-n", "Methods, eq. (12)", "t_n = 0.007 s at 100,000 N/m", math.pi / math.sqrt(2 * 1e5),
        CONTACT_TIME, tolerance=5e-4, unit="s", reason=HALF_DIGIT,
        note=f"two free particles; {fixed:.5f} s on a fixed one")  # fmt: skip


def crest_time(radius: float) -> float:
    """Return t_c [s] by eq. (11) as printed, for spheres of a radius [m]."""
    rise = 1 - math.sin(math.pi / 3)
    return 0.25 * math.sqrt(2 * GRAVITY * 2 * radius * rise) * math.cos(math.pi / 3) / GRAVITY


def rise_time(angle_deg: float) -> float:
    """Return the time [s] from well to crest in steady motion, spheres of 1 m, by quadrature."""
    rise, energy = math.radians(30 - angle_deg), steady_energy(angle_deg, 0.25)

    def slowness(angle: float) -> float:
        return 1 / math.sqrt(2 * (energy - math.cos(angle) + math.cos(rise)))

    return float(quad(slowness, 0.0, rise)[0]) * math.sqrt(1.0 / GRAVITY)


def rescaled_impulse() -> Iterator[Statement]:
    """Yield equation (13): how an impulse ratio alpha changes the shock."""
    alpha = np.linspace(0.3, 1.0, 15)
    yield Statement("eq-13-reference", "Methods, eq. (13); Results, before Fig. 10",
        "J_0, the impulse of the ideal shock, is that of the two-particle run", 1.0,
        impulse_on_fixed(1.0, 1e6, 1.0, 0.0), unit="m v",
        note="the ideal shock has e_n = 0, the two-particle run rebounds",
        correction="alpha(n) = J(n)/J(1), a ratio of two elastic runs")  # fmt: skip
    third, second = (critical_angle(shock) for shock in ((1 - 0.27) ** 2, 0.27**2))
    yield Statement("eq-13", "Methods, eq. (13)",
        "v_i(n) = v_i alpha(n), hence shock(n) = |(v_0 - v_s alpha(n))/v_0|^2",
        (0.5 * alpha) ** 2, (1 - 0.5 * alpha) ** 2,
        note=f"at alpha = 0.54 theta_c = {third:.2f} deg (third line), {second:.2f} (second)",
        correction="alpha scales the loss: v_i(n) = v_0 - alpha (v_0 - v_i)")  # fmt: skip
    normal, tangential = math.sqrt(3) / 2, 0.5
    yield Statement("eq-13-direction", "Methods, eq. (13)",
        "a contact that gives alpha of the impulse leaves |1 - alpha/2|^2 of the energy",
        (normal * (1 - alpha)) ** 2 + tangential**2, (1 - alpha / 2) ** 2,
        0.25 + 0.75 * (1 - alpha) ** 2,
        correction="1/4 + 3/4 (1 - alpha)^2: the impulse acts along the normal")  # fmt: skip


# ---- corrections with a computation of their own


def errata() -> Iterator[Statement]:
    """Yield what was wrong in the restatement of the source: clipped contact, order of MFiX."""
    _, restitution = damped_contact(1.0, 1.0, 2 * damping_ratio(0.0), clipped=True)
    yield Statement("clipped-restitution", OURS,
        "a clipped contact rebounds with 0.1367 at nominal restitution 0", restitution, 0.1367,
        math.exp(-2), tolerance=5e-5, reason=HALF_DIGIT, correction="exp(-2) = 0.1353")  # fmt: skip
    steps = [50, 100, 200, 400, 800]

    def order(shifted: bool) -> float:
        errors = [symplectic_euler_error(n, shifted) for n in steps]
        return -float(np.polyfit(np.log(steps), np.log(errors), 1)[0])

    yield Statement(
        "mfix-order", OURS, "MFiX's Euler scheme is of first order", [order(False), order(True)],
        [1.0, 1.0], [1.0, 2.0], tolerance=0.1, reason="a tenth of an order",
        note="leapfrog, started half a step late",
        correction="second order but for the first half step of gravity")  # fmt: skip


def symplectic_euler_error(steps: int, shifted: bool) -> float:
    """Return the error of the displacement [v0/omega] after 0.7 of half a period.

    Velocity first, then position, for a grain with weight on a spring (omega = v0 = 1, g = 0.3),
    as the power of a matrix. ``shifted`` takes the first velocity as that of half a step before.
    """
    weight, end = 0.3, 0.7 * math.pi
    h = end / steps
    advance = np.array([[1 - h * h, h, h * h * weight], [-h, 1.0, h * weight], [0.0, 0.0, 1.0]])
    start = np.array([0.0, 1.0 - (0.5 * h * weight if shifted else 0.0), 1.0])
    exact = weight * (1 - math.cos(end)) + math.sin(end)
    return abs(float((np.linalg.matrix_power(advance, steps) @ start)[0]) - exact)
