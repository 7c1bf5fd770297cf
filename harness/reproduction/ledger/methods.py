"""The methods of the source, equations (10) to (17): scales of time, pairs, chains."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

from harness.cases.tower.impulse import STIFFNESSES
from harness.cases.tower.run import tower
from harness.observables.tower import impulse
from harness.parameters.tower import LAWS, Tower
from harness.reproduction.claims import SOURCES, Printed, Statement, claim, compare, untestable
from harness.reproduction.ledger.samples import (
    RADIUS,
    free_collision,
    generator,
    impulses,
    integrate,
    off_from_sweeps,
    rows,
    run,
    touching_chains,
)
from harness.solvers.chain import forces, motion
from harness.solvers.chain.forces import contact_forces
from harness.theory import chain
from harness.theory.chain import compliance, final_velocities, impulse_on_fixed
from harness.theory.incline import critical_angle, no_flight_bound, steady_energy

_STIFFNESS, _PAIR_MASS = 1e6, 1.0
_STEPS = 1e-4  # [s] of the fixed-step runs
PAIR = Tower(height=1, base="free", gravity=0.0)


def methods_pair_statements(printed: Printed) -> Iterator[Statement]:
    """Yield the rows of this part."""
    alone: dict[str, Any] = {}
    for law in LAWS:
        run = free_collision(3, law)
        alone[law] = float(np.mean(run.contacts[run.time_over_t0 < 0.3] <= 1))
    yield claim("text-overlap-scheme", **alone)
    yield from _forces()
    yield from _motion()
    yield from _errors(printed)


def pushes(x: np.ndarray, law_step: float = 1e-7) -> np.ndarray:
    """Return the forces [N] on particles at ``x`` (N,) [m] as the slope of the elastic energy.

    The energy sum f d/2 of contact forces f and overlaps d, differentiated centrally:
    no sign is put in by hand.
    """

    def energy(place: np.ndarray) -> float:
        force = contact_forces(place, 2 * RADIUS, _STIFFNESS)
        return float(0.5 * force @ (2 * RADIUS - np.diff(place)))

    steps = law_step * np.eye(x.size)
    return np.array([(energy(x - step) - energy(x + step)) / (2 * law_step) for step in steps])


def _forces() -> Iterator[Statement]:
    distances = 1.0 - generator().uniform(1e-4, 0.2, 50)
    pairs = [np.array([0.0, distance]) for distance in distances]
    forces = np.array([pushes(x) for x in pairs])
    inner = np.array([0.0, 0.93, 1.88])
    compressed = contact_forces(inner, 1.0, 1.0)
    yield compare(
        "eq-14",
        found=np.abs(forces[:, 0]),
        k=_STIFFNESS,
        dx=1.0 - distances,
        net=pushes(inner)[1],
        whole=_STIFFNESS * compressed.sum(),
    )
    deformed = np.array([float(contact_forces(x, 1.0, 1.0)[0]) for x in pairs])
    yield compare("eq-pair-distance", found=distances, r_0=RADIUS, dx=deformed)
    yield compare(
        "eq-15",
        found=forces / _PAIR_MASS,
        k=_STIFFNESS,
        m=_PAIR_MASS,
        r_0=RADIUS,
        x_1=0.0,
        x_2=distances[:, None],
        sign=np.array([1.0, -1.0]),
    )


def _motion() -> Iterator[Statement]:
    run = free_collision(2)
    t0 = chain.contact_time(_PAIR_MASS, _STIFFNESS)
    peak = chain.peak_overlap(_PAIR_MASS, _STIFFNESS, 2.0)
    rk4 = tower(PAIR, solver="rk4", duration=0.5, steps_per_contact=2000)
    inside = run.time <= t0
    off, stepped = (
        float(np.abs(compression - peak * np.sin(np.pi * time / t0)).max()) / peak
        for time, compression in (
            (run.time[inside], run.compression[inside]),
            (rk4.time, rk4.compression),
        )
    )
    yield claim("text-no-solution", off=off, stepped=stepped)
    final = run.final_velocity
    yield compare("text-exchange", printed=0.0, found=float(final[0]), other=final[1])


def peak_error(stiffness: float, steps_per_contact: float) -> float:
    """Return how far the largest deformation of an RK4 run lies from v sqrt(m/2k), in percent."""
    case = PAIR.replace(stiffness=stiffness)
    run = tower(
        case, solver="rk4", duration=1.0, steps_per_contact=steps_per_contact, samples=100_000
    )
    return 100 * abs(
        float(run.compression.max()) / chain.peak_overlap(_PAIR_MASS, stiffness, case.speed) - 1
    )


def _errors(printed: Printed) -> Iterator[Statement]:
    stiffnesses = (1e2, 1e3, 1e4, 1e5, 1e6)
    scaled = [peak_error(k, 50.0) for k in stiffnesses]
    fixed = [peak_error(k, np.pi / np.sqrt(k) / _STEPS) for k in stiffnesses]
    errors: dict[str, Any] = {"scaled": scaled, "fixed": fixed, "step": _STEPS}
    start = int(np.argmin(np.abs(np.array(stiffnesses) - printed.error_stiffness)))
    ratio = printed.stiffnesses[0] / printed.error_stiffness
    yield claim("text-error-size", printed=printed, start=start, ratio=ratio, **errors)
    yield claim("text-error-falls", **errors)


def methods_chain_statements(_: Printed) -> Iterator[Statement]:
    """Yield the rows of this part."""
    yield from _three_particles()
    yield from _deformations()
    yield from _chains()
    yield _closest_pair()
    yield from _stiffness()


def _three_particles() -> Iterator[Statement]:
    ends = [final_velocities(3, deformable=law) for law in (False, True)]
    yield claim("text-not-unique", ends=ends)
    velocities = free_collision(3).final_velocity / 2.0
    yield claim("text-incomplete", found=velocities, expected=ends[1])
    both = free_collision(2), free_collision(3)
    yield claim(
        "text-stored",
        total=[float(collision.deformations.sum(axis=1).max()) for collision in both],
        stored=[
            float(collision.elastic_energy.max() / collision.kinetic_energy[0])
            for collision in both
        ],
    )


def _deformations() -> Iterator[Statement]:
    three = free_collision(3)
    first, second, third = three.deformations.T
    both = (three.profiles.forces > 0).all(axis=1) if three.profiles else np.zeros(0, bool)
    start = int(np.argmax(both))
    yield claim(
        "text-asymmetric",
        joins=three.time_over_t0[start],
        before=float(np.abs(first - second)[:start].max() / first.max()),
        more=bool((second[both] > first[both]).all()),
    )
    yield claim("text-least-deformed", least=third[both] < first[both])


def _chains() -> Iterator[Statement]:
    triples = touching_chains(particles=(3,))
    yield compare(
        "text-partial-equal",
        printed=[chain.deformations[2] for chain in triples],
        found=[forces.compressions(chain.centres, 2 * RADIUS)[1] for chain in triples],
    )
    chains = touching_chains()
    law = SOURCES["eq-16"]
    yield compare(
        law,
        printed=[law.printed(**c.symbols) for c in chains],
        found=[float(c.boundaries[0]) for c in chains],
        corrected=[motion.first_boundary(c.centres, RADIUS) for c in chains],
    )
    yield compare(
        "eq-17",
        found=[float(c.boundaries[-1]) for c in chains],
        x=np.array([c.centres[-1] for c in chains]),
        b=np.array([c.boundaries[-2] for c in chains]),
    )
    lowest = min(float(np.linalg.eigvalsh(compliance(n, True))[0]) for n in range(1, 20))
    yield claim("text-unique", lowest=lowest, off=off_from_sweeps(rows()), rows=len(rows()))


def _closest_pair() -> Statement:
    """Try whether the closest two particles touch, anywhere in a row."""
    near, far = rows(closest=(0.9, 1.1)), rows(closest=(1.0001, 1.2))
    touch = {row: bool(row.compressions[np.argmin(row.distances)] > 0) for row in (*near, *far)}
    return claim(
        "text-closest-pair",
        near=[touch[row] for row in near],
        within=[touch[row] for row in near if row.distances.min() < 1.0],
        far=[touch[row] for row in far],
    )


def _stiffness() -> Iterator[Statement]:
    softer = []
    for stiffness in (1e6, 1e6 / 2, 1e6 / 3):
        pair = Tower(stiffness=(1e6, stiffness), base="free", gravity=0.0)
        softer.append(float(run(pair, 1.5).final_velocity[0]) / pair.speed)
    rebound = float(final_velocities(3, deformable=True)[0])
    yield claim("text-softer", softer=softer, rebound=rebound)

    def alphas(base_times: float) -> list[float]:
        """Return alpha(2) and alpha(10) above a base so many times as stiff."""
        single, two, ten = (
            impulse(run(Tower(height=n, stiffness=(*(1e6,) * n, 1e6 * base_times))))
            for n in (1, 2, 10)
        )
        return [two / single, ten / single]

    yield untestable("text-fixed-particle", soft=alphas(1.0), hard=alphas(1e6))


_MASS, _DIAMETER = 1.0, 1.0  # [kg], [m] of the source's towers
_GLASS_MODULUS, _GLASS_DENSITY, _PACKING = 70e9, 2500.0, 0.6  # [Pa], [kg/m3], [1] usual values
_RATIOS = np.linspace(0.3, 1.0, 15)
_REACHED = 0.54  # of tall towers, for the numbers in words


def methods_scales_statements(printed: Printed) -> Iterator[Statement]:
    """Yield the rows of this part."""
    yield from _rigidity(printed)
    yield from _stiffnesses(printed)
    yield from _crest(printed)
    yield from _contact(printed)
    yield from _shock()


def _rigidity(printed: Printed) -> Iterator[Statement]:
    metres = {"k": 1e5, "P": 9.81, "d": _DIAMETER}  # N/m, N/m2, m
    centimetres = {"k": 1e5 / 100, "P": 9.81 / 100**2, "d": _DIAMETER * 100}
    law = SOURCES["eq-10"]
    ratios = [law.printed(**unit) for unit in (metres, centimetres)]
    repaired = [law.corrected(**unit) for unit in (metres, centimetres)]
    yield claim(
        law,
        corrected_holds=math.isclose(*repaired, rel_tol=1e-12),
        ratios=ratios,
        repaired=repaired,
    )
    pressure = _GLASS_DENSITY * _PACKING * printed.gravity * printed.glass_depth
    yield compare(
        "text-glass-bead",
        printed=printed.glass_rigidity,
        found=(_GLASS_MODULUS / pressure) ** (2 / 3),
        modulus=_GLASS_MODULUS,
        pressure=pressure,
        density=_GLASS_DENSITY,
        packing=_PACKING,
    )
    yield compare(
        "text-orders-of-magnitude",
        printed=printed.orders_of_magnitude,
        found=float(np.log10(printed.rigidities[1] / printed.rigidities[0])),
        corrected=float(len(STIFFNESSES) - 1),  # steps of ten between its values
        printed_range=printed.rigidities,
    )


def _stiffnesses(printed: Printed) -> Iterator[Statement]:
    weight = _MASS * printed.gravity / _DIAMETER  # N/m, the pressure of a row of disks
    pairs = zip(printed.rigidities, printed.stiffnesses, strict=True)
    for name, (kappa, stiffness) in zip(("lowest", "highest"), pairs, strict=True):
        yield compare(f"text-stiffness-{name}", printed=kappa, found=stiffness / weight)
    median = float(np.median(STIFFNESSES))
    middle = median * (printed.rigidities[0] / printed.stiffnesses[0])
    yield compare(
        "text-median-rigidity", printed=printed.median_rigidity, found=middle, stiffness=median
    )


def rise_time(angle_deg: float) -> float:
    """Return the time [s] from well to crest in steady motion, by quadrature over the arc."""
    rise = math.radians(30 - angle_deg)
    energy = steady_energy(angle_deg, 0.25)

    def slowness(angle: float) -> float:
        return 1 / math.sqrt(2 * (energy - math.cos(angle) + math.cos(rise)))

    return float(quad(slowness, 0.0, rise)[0]) * math.sqrt(_DIAMETER / 9.81)


def _crest(printed: Printed) -> Iterator[Statement]:
    drop = 1 - math.sqrt(3) / 2  # [d] from crest to well of a level row, Pythagoras
    escape = math.sqrt(2 * printed.gravity * drop * 2.0)
    evaluated = escape / 8 / printed.gravity
    formula = SOURCES["eq-11"].printed
    yield compare("eq-11", found=evaluated, r=1.0, g=printed.gravity, escape=escape)
    needed = brentq(lambda r: formula(r=r, g=printed.gravity) - printed.crest_time, 1e-3, 1e6)
    yield compare("text-t-c", printed=printed.crest_time, found=evaluated, needed=needed)
    flight = no_flight_bound()
    fastest, slow = rise_time(flight), rise_time(critical_angle() + 1e-6)
    times: dict[str, Any] = {"fastest": fastest, "flight": flight, "slow": slow}
    yield claim("text-crest-time", printed=printed, **times)
    yield claim(
        "text-separation",
        printed=printed,
        formula=formula(r=1.0, g=printed.gravity),
        fastest=fastest,
        longest=max(row.window_s for row in impulses()),
    )


def _contact(printed: Printed) -> Iterator[Statement]:
    random = generator()
    k, m, gamma = random.uniform([50, 0.3, 0.5], [200, 1.0, 5.0], (50, 3)).T
    times = [integrate(*case).time for case in zip(k, m, gamma, strict=True)]
    yield compare("eq-12", found=times, k=k, m=m, gamma=gamma, factor=printed.damping_factor)
    stiffness = printed.stiffnesses[0]
    modes = np.linalg.eigvalsh(stiffness / _MASS * np.array([[1.0, -1.0], [-1.0, 1.0]]))
    yield compare("text-effective-mass", found=float(stiffness / modes[1]), m_1=_MASS, m_2=_MASS)
    yield compare(
        "text-t-n",
        printed=printed.contact_time,
        found=math.pi / math.sqrt(modes[1]),
        held=Tower(stiffness=stiffness, gravity=0.0).contact_time,
    )


def _shock() -> Iterator[Statement]:
    """Hold the shock to the velocity it is made of, and to what an impulse in vectors leaves."""
    speed, after = 1.0, 0.5
    yield compare(
        "eq-13-reference",
        printed=impulse_on_fixed(_MASS, 1e6, speed, 0.0),  # the two-particle run is elastic
        found=_MASS * speed,  # what stops the normal velocity at e_n = 0
    )
    lost, ends = SOURCES["eq-13"].printed, np.array([1.0, _REACHED])
    yield compare(
        "eq-13",
        found=(after * _RATIOS) ** 2,  # of the second line's velocity
        v_0=speed,
        v_s=after,
        alpha=_RATIOS,
        falls=[critical_angle(e) for e in lost(v_0=speed, v_s=after, alpha=ends)],
        rises=[critical_angle(e) for e in (after * ends) ** 2],
        reached=_REACHED,
    )
    normal, tangential = math.sqrt(3) / 2, 0.5

    def remaining_energy(ratio: float) -> float:
        return (normal * (1 - ratio)) ** 2 + tangential**2

    yield compare(
        "eq-13-direction",
        found=[remaining_energy(a) for a in _RATIOS],
        alpha=_RATIOS,
        remaining=remaining_energy(_REACHED),
        as_printed=SOURCES["eq-13-direction"].printed(alpha=_REACHED),
        reached=_REACHED,
        angle=critical_angle(remaining_energy(_REACHED)),
    )
