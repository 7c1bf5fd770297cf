"""Introduction and background of the source: energy, angle, shock; the incline in MFiX, LAMMPS.

Equations (1) to (9), and the angle of rest.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from harness.cases.incline.angle import CriticalAngle
from harness.cases.incline.angle import critical_angle as measured_critical_angle
from harness.cases.incline.system import Incline
from harness.cases.tower.impulse import impulse_table
from harness.engines.contract import Engine
from harness.errors import EngineError
from harness.parameters.law import SOURCE, Contact
from harness.parameters.tower import Tower
from harness.reproduction.claims import SOURCES, Printed, Statement, claim, compare, untestable
from harness.reproduction.ledger.samples import generator, integrate
from harness.reproduction.mfix import COARSE, FINE, STIFFNESSES, angle_in_scheme
from harness.theory.incline import after_next_shock, critical_angle, no_flight_bound, steady_energy

_HEIGHTS = range(1, 21)


def introduction_statements(_: Printed) -> Iterator[Statement]:
    """Yield the rows of this part."""
    yield compare(
        "eq-1", found=[stiffness_of_springs(n) for n in _HEIGHTS], k=1.0, n=np.array(_HEIGHTS)
    )

    def ratio(stiffness: float, case: Tower | None = None) -> float:
        return impulse_table(
            heights=(10,), stiffnesses=(stiffness,), speeds=(2.0,), laws=("deformable",), case=case
        )[0].ratio

    ratios = {k: ratio(k) for k in (1e6, 1e9, 1e12)}
    rigid = ratio(1e6, Tower(gravity=0.0))
    yield claim(
        "text-limit",
        stiffest=ratios[1e12],
        ratios=[f"{a:.5f} at {k:.0e} N/m" for k, a in ratios.items()],
        rigid=rigid,
    )


def stiffness_of_springs(springs: int) -> float:
    """Return the end-to-end stiffness of equal springs in series, by solving their equilibrium.

    The first end is held, the last one pushed with a unit force; k = 1.
    """
    balance = 2 * np.eye(springs) - np.eye(springs, k=1) - np.eye(springs, k=-1)
    balance[-1, -1] = 1.0
    push = np.zeros(springs)
    push[-1] = 1.0
    return float(1 / np.linalg.solve(balance, push)[-1])


_SAMPLES = 100
_LONG = 2000  # shocks
_RESTITUTIONS = np.linspace(0.0, 1.0, 21)


def background_energy_statements(printed: Printed) -> Iterator[Statement]:
    """Yield the rows of this part."""
    yield from _table(printed)
    yield from _sums()
    yield from _limits(printed)
    yield from _angle(printed)
    yield from _shock(printed)


def iterated(shocks: int, start: float, gained: float, shock: float) -> float:
    """Return E_n by n steps of E[j+1] = (E[j] + dE) shock."""
    energy = start
    for _ in range(shocks):
        energy = (energy + gained) * shock
    return energy


def height(along: float, normal: float, angle_deg: float) -> float:
    """Return the height [d] of a point of the row's own frame once the row is tilted."""
    tilt = math.radians(angle_deg)
    return normal * math.cos(tilt) - along * math.sin(tilt)


def depth_of_well(angle_deg: float) -> float:
    """Return how far a crest stands above the well before it [d], from coordinates.

    Spheres at 0 and 1; the grain's centre is the tip of an equilateral triangle in the
    well and one diameter above the second sphere on the crest.
    """
    crest = height(1.0, 0.0, angle_deg) + 1.0
    return crest - height(0.5, math.sqrt(3) / 2, angle_deg)


def _table(printed: Printed) -> Iterator[Statement]:
    gain = SOURCES["table-1-gain"]
    angles = generator().uniform(0.1, 29.9, _SAMPLES)
    yield compare("table-1-well", found=[depth_of_well(a) for a in angles], theta=angles)
    yield compare(
        "table-1-gain",
        found=[height(0.0, 0.0, a) - height(1.0, 0.0, a) for a in angles],
        theta=angles,
    )
    starts = generator().uniform(0.06, 0.2, _SAMPLES)
    yield compare(
        "table-1-first-shock",
        found=[after_next_shock(e, 10.5, 0.25) for e in starts],
        E_0=starts,
        dE=gain.printed(theta=10.5),
        shock=0.25,
    )
    angle = printed.critical_angle_deg
    depth = SOURCES["table-1-well"].printed(theta=angle)
    # contact is weakest where the grain is fastest, just before the shock
    most = 0.5 * math.cos(math.radians(30 + angle)) - gain.printed(theta=angle)
    yield claim(
        "text-constant-contact",
        angle=angle,
        depth=depth,
        most=most,
        contact=_extremes_of_contact(angle),
        flight=no_flight_bound(),
    )


def _extremes_of_contact(angle_deg: float) -> tuple[float, float]:
    """Return the contact force over the normal component of gravity, extremes of a cycle."""
    energy = steady_energy(angle_deg, 0.25)
    from_vertical = np.radians(np.linspace(-(30 - angle_deg), 30 + angle_deg, 2001))
    fallen = math.cos(math.radians(30 - angle_deg)) - np.cos(from_vertical)
    part = 1 - 2 * (energy + fallen) / np.cos(from_vertical)
    return float(part.min()), float(part.max())


def _sums() -> Iterator[Statement]:
    random = generator()
    cases = [
        (int(random.integers(3, 12)), *random.uniform([0.05, 0.05, 0.1], [1.0, 1.0, 0.9]))
        for _ in range(_SAMPLES)
    ]
    direct = [iterated(*case) for case in cases]
    n, start, gained, shock = np.array(cases).T
    yield compare("eq-2", found=direct, n=n, E_0=start, dE=gained, shock=shock)
    ratios = [(shock, n) for n, _, _, shock in cases]
    yield compare("eq-3", found=[sum(x**p for p in range(n + 1)) for x, n in ratios], x=shock, n=n)
    yield compare(
        "eq-3-index", found=[sum(x**p for p in range(n)) for x, n in ratios], x=shock, n=n
    )
    first = SOURCES["table-1-first-shock"].printed(E_0=start, dE=gained, shock=shock)
    yield compare("eq-4", found=direct, n=n, E_1=first, dE=gained, shock=shock)


def _limits(printed: Printed) -> Iterator[Statement]:
    def grows(shock: float) -> bool:
        late, later = iterated(_LONG, 0.1, 0.2, shock), iterated(2 * _LONG, 0.1, 0.2, shock)
        return later > 1.5 * late

    shocks = [printed.diverges_above + off for off in (0.01, 0.0, -0.01)]
    yield claim(
        "text-divergence",
        long=_LONG,
        shocks=shocks,
        grow=[grows(shock) for shock in shocks],
        end=iterated(_LONG, 0.0, 0.2, 0.25),
        limit=SOURCES["eq-5"].printed(dE=0.2, shock=0.25),
    )
    random = generator()
    gained, shock = random.uniform([0.05, 0.1], [1.0, 0.9], (_SAMPLES, 2)).T
    ends = [iterated(_LONG, 0.3, *case) for case in zip(gained, shock, strict=True)]
    yield compare("eq-5", found=ends, dE=gained, shock=shock, long=_LONG)


def fate(angle_deg: float, shock: float) -> bool:
    """Return whether a grain that starts with twice the well's depth still moves in the end."""
    depth = depth_of_well(angle_deg)
    energy = 2 * depth
    for _ in range(_LONG):
        if energy < depth:
            return False
        energy = after_next_shock(energy, angle_deg, shock)
    return True


def fate_angle(shock: float) -> float:
    """Return the smallest angle [deg] at which motion lasts, by bisection of the fate."""
    low, high = 0.0, 30.0
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if fate(middle, shock) else (middle, high)
    return 0.5 * (low + high)


def _angle(printed: Printed) -> Iterator[Statement]:
    lasting = fate_angle(0.25)

    def root(divisor: float) -> float:
        margin = SOURCES["eq-6"].printed
        return float(brentq(lambda a: margin(theta=a, shock=0.25, divisor=divisor), 0.5, 29.5))

    printed_root, closed = root(printed.well_divisor), critical_angle()
    yield compare("eq-6", printed=printed_root, found=lasting, corrected=root(2.0), closed=closed)
    yield compare("text-critical-angle", printed=printed.critical_angle_deg, found=lasting)


def collide(velocity: NDArray[np.float64], restitution: float) -> NDArray[np.float64]:
    """Return the velocity after the grain hits the next sphere, in vectors.

    The new contact's normal stands 60 deg off the old one's; the normal part of
    the velocity is turned back and multiplied by ``restitution``.
    """
    normal = np.array([-1.0, 0.0])
    approach = float(velocity @ normal)
    return np.asarray(velocity - (1 + restitution) * approach * normal)


def _shock(printed: Printed) -> Iterator[Statement]:
    before = np.array([math.sqrt(3) / 2, -0.5])  # unit speed, 60 deg off the new tangent
    after = [collide(before, e) for e in _RESTITUTIONS]
    speeds = [float(np.hypot(*v)) for v in after]
    kept = [float(v @ v) / float(before @ before) for v in after]
    vector = float(np.sum((before - after[0]) ** 2))
    yield compare(
        "eq-7",
        found=kept,
        before=1.0,
        after=np.array(speeds),
        vector=vector,
        angle=critical_angle(vector),
    )
    yield compare("eq-8", found=speeds, before=1.0, e=_RESTITUTIONS)
    after_8 = SOURCES["eq-8"].printed(before=7.0, e=_RESTITUTIONS)
    yield compare(
        "text-substitution",
        printed=SOURCES["eq-9"].printed(e=_RESTITUTIONS),
        found=SOURCES["eq-7"].printed(before=7.0, after=after_8),
    )
    yield compare("eq-9", found=kept, e=_RESTITUTIONS)
    without_rebound = float(np.sum(collide(before, 0.0) ** 2))
    yield compare("text-shock", printed=printed.shock, found=without_rebound)


_STEPS = (50.0, 100.0, 200.0, 400.0)  # per contact time
_REBOUND = 0.1
_OF_THE_ENGINE = ("text-lammps-angle", "text-lammps-step", "text-restitution-angle")


def background_incline_statements(printed: Printed, engine: Engine | None) -> Iterator[Statement]:
    """Yield the rows of this part."""
    full = SOURCE.replace(restitution=printed.restitution).zeta
    half = full * np.sqrt(0.5)
    restitution = integrate(1.0, 1.0, 2 * half).restitution
    yield compare(
        "text-restitution", printed=printed.restitution, found=restitution, half=half, full=full
    )
    yield from _mfix(printed)
    try:
        if engine is None:
            raise EngineError("no engine was given to run the incline in")
        yield from _lammps(printed, engine)
    except EngineError as error:
        why = str(error) if engine is None else f"the engine failed: {error}"
        yield from (untestable(key, why) for key in _OF_THE_ENGINE)
    rest = float(brentq(_upper_contact, 0.0, 60.0))
    yield compare(
        "text-rest-angle", printed=printed.rest_angle_deg, found=rest, above=rest - critical_angle()
    )


def _upper_contact(angle_deg: float) -> float:
    """Return the force [m g] on the contact uphill of a grain at rest in a well."""
    directions = np.radians([60.0, 120.0])  # from the row, downhill, to the grain
    normals = np.array([np.cos(directions), np.sin(directions)])
    tilt = np.radians(angle_deg)
    return float(np.linalg.solve(normals, [-np.sin(tilt), np.cos(tilt)])[0])


def angles_at(factor: int) -> NDArray[np.float64]:
    """Return the critical angle [deg] in MFiX's scheme for each of ``STIFFNESSES``."""
    found = [angle_in_scheme(stiffness, factor) for stiffness in STIFFNESSES]
    return np.array([math.nan if angle is None else angle.value_deg for angle in found])


def _mfix(printed: Printed) -> Iterator[Statement]:
    off = {factor: angles_at(factor) - critical_angle() for factor in (COARSE, FINE)}
    coarse, fine = (
        [f"{d:+.4f} deg off at {k:.0e} N/m" for d, k in zip(each, STIFFNESSES, strict=True)]
        for each in off.values()
    )
    yield compare(
        "text-mfix-angle",
        printed=printed.critical_angle_deg,
        found=float(angles_at(COARSE)[-1]),
        tolerance=printed.simulated_within_deg,
        listing=coarse,
        stiffest=STIFFNESSES[-1],
    )
    yield claim("text-mfix-validation", coarse=off[COARSE], fine=off[FINE], listing=fine)


def _lammps(printed: Printed, engine: Engine) -> Iterator[Statement]:
    def measured(steps: float, contact: Contact = SOURCE) -> CriticalAngle:
        case = Incline(steps_per_contact=steps, contact=contact)
        return measured_critical_angle(case, engine=engine)

    measurements = [measured(steps) for steps in _STEPS]
    rebound = measured(_STEPS[0], Contact(restitution=_REBOUND))
    angles = [f"{angle.value_deg:.4f} +- {angle.uncertainty_deg:.4f} deg" for angle in measurements]
    yield compare(
        "text-lammps-angle",
        printed=printed.critical_angle_deg,
        found=measurements[0].value_deg,
        tolerance=printed.simulated_within_deg,
        angle=angles[0],
        steps=_STEPS[0],
    )
    yield claim(
        "text-lammps-step",
        found=measurements,
        within=printed.simulated_within_deg,
        angles=[f"{a} at {s:g} steps per contact" for s, a in zip(_STEPS, angles, strict=True)],
    )
    yield compare(
        "text-restitution-angle",
        printed=critical_angle(SOURCES["eq-9"].printed(e=_REBOUND)),
        found=rebound.value_deg,
        corrected=critical_angle(SOURCES["eq-9"].corrected(e=_REBOUND)),
        uncertainty=rebound.uncertainty_deg,
    )
