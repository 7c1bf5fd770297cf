"""Introduction and background of the source: equations (1) to (9), and the incline as simulated."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from harness.cases.bench import Bench
from harness.cases.incline.angle import angle_on, reference_measure
from harness.cases.incline.search import CriticalAngle, prepared, search
from harness.cases.incline.system import Incline, Route
from harness.cases.tower.impulse import STIFFNESSES, impulse_angles
from harness.cases.tower.parameters import Tower
from harness.errors import RequestError
from harness.model.conventions import Rules
from harness.model.law import Contact, damping_ratio
from harness.model.scene import Scene
from harness.reproduction import samples
from harness.reproduction.statements import Outcome, Statement, holds
from harness.theory.chain import shock_from_restitution
from harness.theory.incline import after_next_shock, critical_angle, no_flight_bound, steady_energy

LONG = 2000  # shocks after which the energy has its limit
SAMPLES = 100
PRINTED_ANGLE = 10.21  # [deg]
HALF_DIGIT = "half of the last digit"
Floats = NDArray[np.float64]


@Statement("Introduction, eq. (1)", "k' = k/n for n springs in series", unit="k")
def _eq_1() -> Outcome:
    n = np.arange(1, 21)
    values = [samples.springs_in_series(count) for count in n.tolist()]
    return Outcome(values, 1.0 / n, note="equilibrium of n massless springs, n = 1 to 20")


@Statement("Introduction, after eq. (1)",
           "the effect stays significant and vanishes only at infinite stiffness", 1e-4,
           reason="the limit is reached within 1e-4")  # fmt: skip
def _limit() -> Outcome:
    def ratio(stiffness: float, case: Tower | None = None) -> float:
        table = impulse_angles(heights=(10,), stiffnesses=(stiffness,), speeds=(2.0,),
                               laws=("deformable",), case=case, solver="exact")  # fmt: skip
        return float(table["impulse_ratio"][0])

    # without gravity the stiffness drops out: a base that is rigid from the start would give 1
    return Outcome(ratio(1e12), ratio(1e6, Tower(gravity=0.0)), note="alpha(10) at 1e12 N/m")


# ---- energies of the incline [m g d]


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


@Statement("Background, Table I", "C = m g r (1 - cos(pi/6 - theta))", unit="m g d")
def _table_1_well() -> Outcome:
    angles = samples.generator().uniform(0.1, 29.9, SAMPLES)
    note = "r is the distance of the centres; the radius, as eq. (11) needs it, gives half of it"
    printed = 1 - np.cos(np.pi / 6 - np.radians(angles))
    return Outcome([depth_of_well(angle) for angle in angles], printed, note=note)


@Statement("Background, Table I", "dE = m g r sin(theta)", unit="m g d")
def _table_1_gain() -> Outcome:
    angles = samples.generator().uniform(0.1, 29.9, SAMPLES)
    values = [height(0.0, 0.0, angle) - height(1.0, 0.0, angle) for angle in angles]
    return Outcome(values, np.sin(np.radians(angles)), note="drop from sphere to sphere")


@Statement("Background, text to Fig. 3",
           "the grain crosses without leaving the row, under less than the normal component of "
           "gravity")  # fmt: skip
def _constant_contact() -> Outcome:
    energy, tilt = steady_energy(PRINTED_ANGLE, 0.25), PRINTED_ANGLE
    from_vertical = np.radians(np.linspace(-(30 - tilt), 30 + tilt, 2001))
    fallen = math.cos(math.radians(30 - tilt)) - np.cos(from_vertical)
    share = 1 - 2 * (energy + fallen) / np.cos(from_vertical)
    note = f"in steady motion the contact carries {share.min():.3f} to {share.max():.3f} of it"
    note += f"; contact lasts up to {no_flight_bound():.2f} deg"
    return holds(share.min() > 0 and share.max() <= 1, note)


def iterated(shocks: int, start: float, gained: float, shock: float) -> float:
    """Return E_n [m g d] by n steps of E[j+1] = (E[j] + dE) shock."""
    energy = start
    for _ in range(shocks):
        energy = (energy + gained) * shock
    return energy


@cache
def _sums() -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Return n, E_0, dE and shock of random cases, and E_n by the map."""
    random = samples.generator()
    cases = [
        (int(random.integers(3, 12)), *random.uniform([0.05, 0.05, 0.1], [1.0, 1.0, 0.9]))
        for _ in range(SAMPLES)
    ]
    n, start, gained, shock = np.array(cases).T
    return n, start, gained, shock, np.array([iterated(*case) for case in cases])


def _power_sums(more: int) -> tuple[Floats, list[float], Floats, Floats]:
    """Return n, 1 + x + ... to n - 1 + ``more`` powers, added one by one, and S_n and S_(n-1)."""
    n, _, _, x, _ = _sums()
    sums = [sum(r**p for p in range(int(k) + more)) for r, k in zip(x, n, strict=True)]
    return n, sums, (1 - x ** (n + 1)) / (1 - x), (1 - x**n) / (1 - x)


@Statement("Background, eq. (2)",
           "E_n = E_0 shock^n + dE shock (shock^(n-1) + shock^(n-1) + ... + 1)", unit="m g d",
           correction="second term shock^(n-2): every power from n - 1 to 0 once")  # fmt: skip
def _eq_2() -> Outcome:
    n, start, gained, shock, energy = _sums()
    bracket = 2 * shock ** (n - 1) + (1 - shock ** (n - 2)) / (1 - shock)
    printed, right = (
        start * shock**n + gained * shock * powers
        for powers in (bracket, (1 - shock**n) / (1 - shock))
    )
    note = f"n steps of the map at {SAMPLES} random n, E_0, dE and shocks"
    return Outcome(energy, printed, right, note)


@Statement("Background, eq. (3)", "1 + x + ... + x^n = (1 - x^(n+1))/(1 - x)")
def _eq_3() -> Outcome:
    _, sums, printed, _ = _power_sums(1)
    return Outcome(sums, printed, note="term by term")


@Statement("Background, eqs. (2) and (3)", "the bracket of eq. (2) is the S_n of eq. (3)",
           correction="it is S_(n-1), (1 - shock^n)/(1 - shock): it has n terms")  # fmt: skip
def _eq_3_index() -> Outcome:
    _, sums, printed, right = _power_sums(0)
    return Outcome(sums, printed, right)


@Statement("Background, eq. (4)", "E_n = E_1 shock^(n-1) + dE shock (1 - shock^(n-1))/(1 - shock)",
           unit="m g d")  # fmt: skip
def _eq_4() -> Outcome:
    n, start, gained, shock, energy = _sums()
    first, rest = (start + gained) * shock, (1 - shock ** (n - 1)) / (1 - shock)
    return Outcome(energy, first * shock ** (n - 1) + gained * shock * rest)


@Statement("Background, after eq. (4)",
           "E_n goes to infinity if the shock is above 1; else it approaches a constant",
           correction="from shock 1 on, there by dE each shock")  # fmt: skip
def _divergence() -> Outcome:
    above, at, below = (
        iterated(2 * LONG, 0.1, 0.2, shock) > 1.5 * iterated(LONG, 0.1, 0.2, shock)
        for shock in (1.01, 1.0, 0.99)
    )
    note = f"E_n grows at shock 1.01: {above}, 1: {at}, 0.99: {below}"
    return holds(above and not at and not below, note, corrected=above and at and not below)


@Statement("Background, eq. (5)", "lim E_n = dE shock/(1 - shock)", 1e-11, "m g d",
           "round-off of 2000 shocks")  # fmt: skip
def _eq_5() -> Outcome:
    gained, shock = samples.generator().uniform([0.05, 0.1], [1.0, 0.9], (SAMPLES, 2)).T
    values = [iterated(LONG, 0.3, *case) for case in zip(gained, shock, strict=True)]
    return Outcome(values, gained * shock / (1 - shock))


# ---- critical angle and shock


@cache
def fate_angle(shock: float = 0.25) -> float:
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


@Statement("Background, eq. (6)", "shock/(1 - shock) >= 2 sin^2(pi/12 - theta/4)/sin(theta)", 1e-5,
           "deg", "the fate of the energy map is bisected to 1e-6 deg",
           correction="theta/2: 1 - cos(a) = 2 sin^2(a/2) with a = pi/6 - theta")  # fmt: skip
def _eq_6() -> Outcome:
    def margin(angle: float, divisor: float) -> float:
        tilt = math.radians(angle)
        return 1 / 3 - 2 * math.sin(math.pi / 12 - tilt / divisor) ** 2 / math.sin(tilt)

    printed, right = (float(brentq(margin, 0.5, 29.5, args=(part,))) for part in (4.0, 2.0))
    return Outcome(fate_angle(), printed, right, f"closed form {critical_angle():.4f} deg")


@Statement("Background, after eq. (9)", "theta_c = 10.21 deg", 0.005, "deg", HALF_DIGIT)
def _critical_angle() -> Outcome:
    return Outcome(fate_angle(), PRINTED_ANGLE, note="bisection of the fate of the energy map")


RESTITUTIONS = np.linspace(0.0, 1.0, 21)


@cache
def _velocities_after() -> Floats:
    """Return velocities after collisions at unit speed, 60 deg off the new tangent, in vectors."""
    normal, before = np.array([-1.0, 0.0]), np.array([math.sqrt(3) / 2, -0.5])
    return np.asarray(before - np.outer(1 + RESTITUTIONS, float(before @ normal) * normal))


def _kept_energies() -> Floats:
    return np.asarray(np.sum(_velocities_after() ** 2, axis=1))


@Statement("Background, eq. (7)",
           "shock = |(v' - v)/v'|^2 is the kinetic energy after over that before the shock",
           correction="shock = (v/v')^2; the two agree at e_n = 0 alone")  # fmt: skip
def _eq_7() -> Outcome:
    after = np.hypot(*_velocities_after().T)
    return Outcome(_kept_energies(), (1 - after) ** 2, after**2)


@Statement("Background, eq. (8)", "v = sqrt((v'/2)^2 + (e_n v' sqrt(3)/2)^2)", unit="v'")
def _eq_8() -> Outcome:
    printed = np.sqrt(0.25 + (RESTITUTIONS * math.sqrt(3) / 2) ** 2)
    return Outcome(np.hypot(*_velocities_after().T), printed)


@Statement("Background, eq. (9)", "shock = (1 - sqrt(1/4 + 3/4 e_n^2))^2",
           correction="shock = 1/4 + 3/4 e_n^2; the formula gives 0 where nothing is lost, at "
           "e_n = 1")  # fmt: skip
def _eq_9() -> Outcome:
    kept = 0.25 + 0.75 * RESTITUTIONS**2
    return Outcome(_kept_energies(), (1 - np.sqrt(kept)) ** 2, kept)


@Statement("Background, on the MFiX runs", "normal restitution is nearly zero (1e-20)", 1e-4,
           reason="the energy kept is 1/4 + 3/4 e^2: below 1e-4, e moves it by 1e-8",
           correction="the effective mass on a fixed sphere is m, not MFiX's m/2")  # fmt: skip
def _restitution() -> Outcome:
    zeta = damping_ratio(1e-20)
    _, restitution = samples.damped_contact(1.0, 1.0, 2 * zeta * math.sqrt(0.5))
    note = f"damping ratio {zeta * math.sqrt(0.5):.4f} in place of {zeta:.4f}"
    return Outcome(restitution, 1e-20, note=note)


@Statement("Background, last paragraphs", "at rest the grain starts above 30 deg only: hysteresis",
           0.5, "deg", HALF_DIGIT)  # fmt: skip
def _rest_angle() -> Outcome:
    def upper_contact(angle: float) -> float:
        directions, tilt = np.radians([60.0, 120.0]), math.radians(angle)
        normals = np.array([np.cos(directions), np.sin(directions)])
        return float(np.linalg.solve(normals, [-math.sin(tilt), math.cos(tilt)])[0])

    angle = float(brentq(upper_contact, 0.0, 60.0))
    return Outcome(angle, 30.0, note="equilibrium: the contact uphill is without force there")


# ---- the incline in MFiX's scheme, by the reference

MFIX_CONTACT = Contact(
    name="MFiX", restitution=1e-20, effective_mass="half"
)  # m/2 on a fixed sphere
COARSE, FINE = 50, 5000  # ``DTSOLID_FACTOR``: MFiX's default, and a hundred times it
FROM_PASSAGE = 1000  # factor from which a passage gives the same angle for a tenth of the steps
RESOLUTION_DEG = 1e-3
WITHIN = 0.01  # [deg] "to one-hundredth of a degree"
AGREEMENT = "the agreement that the source states"


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


@Statement("Background, on the MFiX runs, and Fig. 4",
           "the smallest angle of steady motion in MFiX is 10.21 deg to a hundredth of a degree",
           WITHIN, "deg", AGREEMENT)  # fmt: skip
def _mfix_angle() -> Outcome:
    angle = mfix_angle(1e7, COARSE)
    value, uncertainty = (angle.value, angle.uncertainty) if angle else (math.nan, 0.0)
    note = "reference in MFiX's scheme at its default step, 1e7 N/m; the source names no stiffness"
    return Outcome(value, 10.21, note=note, uncertainty=uncertainty)


@Statement("Background, on the MFiX runs, and Fig. 4", "the agreement validates the analysis",
           reason="a refined step must not be further from the closed form",
           correction="take the step to zero first, then the stiffness to infinity")  # fmt: skip
def _mfix_validation() -> Outcome:
    def errors(factor: int) -> list[float]:
        angles = [mfix_angle(stiffness, factor) for stiffness in STIFFNESSES]
        return [math.nan if a is None else a.value - critical_angle() for a in angles]

    coarse, fine = errors(COARSE), errors(FINE)
    words = [", ".join(f"{error:+.4f}" for error in some) for some in (coarse, fine)]
    note = f"{words[0]} deg at the default step, {words[1]} deg at a hundredth (1e5 to 1e7 N/m)"
    return holds(all(abs(b) <= abs(a) for a, b in zip(coarse, fine, strict=True)), note)


# ---- an engine in MFiX's place

STEPS = (50.0, 100.0, 200.0, 400.0)  # per contact time


@Statement("Background, on the MFiX runs; an engine in its place",
           "theta_c is 10.21 deg to a hundredth of a degree, 1e6 N/m", WITHIN, "deg", AGREEMENT,
           engine=True)  # fmt: skip
def _engine_angle(bench: Bench) -> Outcome:
    angle = angle_on(bench, Incline(steps_per_contact=STEPS[0]))
    note = "the source's contact, tail kept, 50 steps per contact, passage"
    return Outcome(angle.value, 10.21, note=note, uncertainty=angle.uncertainty)


@Statement("Background, on the MFiX runs; an engine in its place",
           "the angle does not depend on the step", WITHIN, "deg", AGREEMENT, engine=True,
           correction="extrapolate step and stiffness, no tail and no rebound")  # fmt: skip
def _engine_step(bench: Bench) -> Outcome:
    angles = [angle_on(bench, Incline(steps_per_contact=steps)).value for steps in STEPS]
    note = ", ".join(f"{a:.4f} deg at {n:g}" for a, n in zip(angles, STEPS, strict=True))
    return Outcome(angles[-1], angles[0], note=f"{note} steps per contact")


@Statement("Background, eqs. (6) and (9); an engine in MFiX's place",
           "at e_n = 0.1 theta_c follows from the shock of eq. (9)", 0.05, "deg",
           "effect of step and stiffness at 1e6 N/m", engine=True,
           correction="neither reading: rebounds end within a well, and theta_c stays")  # fmt: skip
def _engine_restitution(bench: Bench) -> Outcome:
    angle = angle_on(bench, Incline(contact=Contact(restitution=0.1)))
    kept, lost = (critical_angle(shock_from_restitution(0.1, r)) for r in ("kept", "lost"))
    note = f"{lost:.3f} deg by eq. (9), {kept:.3f} deg by 1/4 + 3/4 e^2"
    return Outcome(angle.value, lost, note=note, uncertainty=angle.uncertainty)
