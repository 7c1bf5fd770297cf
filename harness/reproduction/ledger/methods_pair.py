"""Section Methods: two deformable particles, equations (14) and (15)."""

from __future__ import annotations

import numpy as np

from harness.cases.tower.run import tower
from harness.chain.complementarity import contact_forces
from harness.parameters.tower import Tower
from harness.reproduction import as_printed
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, bounded, claim, compare
from harness.reproduction.ledger.runs import free_collision
from harness.reproduction.ledger.samples import RADIUS, generator
from harness.reproduction.source import SOURCES
from harness.theory import two_spheres

_STIFFNESS, _MASS = 1e6, 1.0
_STEPS = 1e-4  # [s] of the fixed-step runs
PAIR = Tower(height=1, base="free", gravity=0.0)


def statements(printed: Printed) -> list[Statement]:
    """Return the rows of this part."""
    pairs = [np.array([0.0, 1.0 - depth]) for depth in generator().uniform(1e-4, 0.2, 50)]
    return [
        _overlap_scheme(),
        _force(pairs),
        _distance(pairs),
        _accelerations(pairs),
        _no_solution(),
        _exchange(),
        *_errors(printed),
    ]


def pushes(x: np.ndarray, law_step: float = 1e-7) -> np.ndarray:
    """Return the forces [N] on particles at ``x`` (N,) [m] as the slope of the elastic energy.

    The energy sum f d/2 of contact forces f and overlaps d, differentiated centrally:
    no sign is put in by hand.
    """

    def energy(place: np.ndarray) -> float:
        force = contact_forces(place, 2 * RADIUS, _STIFFNESS)
        return float(0.5 * force @ (2 * RADIUS - np.diff(place)))

    result = np.empty(x.size)
    for i in range(x.size):
        step = law_step * np.eye(x.size)[i]
        result[i] = (energy(x - step) - energy(x + step)) / (2 * law_step)
    return result


def _overlap_scheme() -> Statement:
    def part_alone(law: str) -> float:
        run = free_collision(3, law)
        early = run.time_over_t0 < 0.3
        return float(np.mean(run.contacts[early] <= 1))

    deformable, overlap = part_alone("deformable"), part_alone("overlap")
    return claim(
        SOURCES["text-overlap-scheme"],
        holds=deformable > 0.95 and overlap < 0.05,
        computed="three particles, first 0.3 t0: the grain's chain is its own contact alone for "
        f"{100 * deformable:.0f} % of the samples under the deformable law (the third particle is "
        f"left behind), for {100 * overlap:.0f} % under the overlap law",
    )


def _force(pairs: list[np.ndarray]) -> Statement:
    inner = np.array([0.0, 0.93, 1.88])
    net = pushes(inner)
    compressed = contact_forces(inner, 1.0, 1.0)
    whole = as_printed.dashpot_force(_STIFFNESS, float(compressed.sum()))
    return compare(
        SOURCES["eq-14"],
        printed=[as_printed.dashpot_force(_STIFFNESS, 1.0 - float(x[1] - x[0])) for x in pairs],
        found=[abs(pushes(x)[0]) for x in pairs],
        computed="slope of the elastic energy at 50 compressions; a particle between two others "
        f"feels the difference of its partial compressions, not its deformation ({net[1]:.4g} N "
        f"where k dx is {whole:.4g} N); there is no dashpot in it",
    )


def _distance(pairs: list[np.ndarray]) -> Statement:
    deformed = [float(contact_forces(x, 1.0, 1.0)[0]) for x in pairs]
    return compare(
        SOURCES["eq-pair-distance"],
        printed=[(1 - d) / 2 + (1 - d) / 2 for d in deformed],
        found=[float(x[1] - x[0]) for x in pairs],
        computed="deformations from the complementarity problem, equal for both particles",
    )


def _accelerations(pairs: list[np.ndarray]) -> Statement:
    printed = [as_printed.pair_accelerations(x, RADIUS, _STIFFNESS, _MASS) for x in pairs]
    found = np.array([pushes(x) / _MASS for x in pairs])
    return compare(
        SOURCES["eq-15"],
        printed=printed,
        found=found,
        computed="slope of the elastic energy: particle 1 is pushed back, particle 2 on",
        corrected=-np.array(printed),
    )


def _no_solution() -> Statement:
    run = free_collision(2)
    t0 = two_spheres.contact_time(_MASS, _STIFFNESS)
    peak = two_spheres.peak_overlap(_MASS, _STIFFNESS, 2.0)
    inside = run.time <= t0
    wave = peak * np.sin(np.pi * run.time[inside] / t0)
    off = float(np.abs(run.compression[inside] - wave).max()) / peak
    rk4 = tower(PAIR, solver="rk4", duration=0.5, steps_per_contact=2000)
    closed = peak * np.sin(np.pi * rk4.time / t0)
    stepped = float(np.abs(rk4.compression - closed).max()) / peak
    return claim(
        SOURCES["text-no-solution"],
        holds=off > 1e-6,
        computed="dx = v sqrt(m/2k) sin(sqrt(2k/m) t) differs from the exact propagator "
        f"by {bounded(off)} and from RK4 by {bounded(stepped)} of the peak, "
        "all through the contact",
    )


def _exchange() -> Statement:
    final = free_collision(2).final_velocity
    return compare(
        SOURCES["text-exchange"],
        printed=0.0,
        found=float(final[0]),
        computed=f"velocities at the end {bounded(final[0])} and {final[1]:.6f} m/s at 1e6 N/m",
    )


def peak_error(stiffness: float, steps_per_contact: float) -> float:
    """Return how far the largest deformation of an RK4 run lies from v sqrt(m/2k), in percent."""
    case = PAIR.replace(stiffness=stiffness)
    run = tower(
        case, solver="rk4", duration=1.0, steps_per_contact=steps_per_contact, samples=100_000
    )
    return 100 * abs(
        float(run.compression.max()) / two_spheres.peak_overlap(_MASS, stiffness, case.speed) - 1
    )


def _errors(printed: Printed) -> list[Statement]:
    stiffnesses = (1e2, 1e3, 1e4, 1e5, 1e6)
    scaled = [peak_error(k, 50.0) for k in stiffnesses]
    fixed = [peak_error(k, np.pi / np.sqrt(k) / _STEPS) for k in stiffnesses]
    start = stiffnesses.index(min(stiffnesses, key=lambda k: abs(k - printed.error_stiffness)))
    ratio = printed.stiffnesses[0] / printed.error_stiffness
    lists = (
        f"steps of contact time/50: {', '.join(f'{e:.1e}' for e in scaled)} %; of {_STEPS:g} s: "
        f"{', '.join(f'{e:.1e}' for e in fixed)} % (1e2 to 1e6 N/m)"
    )
    return [
        claim(
            SOURCES["text-error-size"],
            holds=max(scaled[start:]) < printed.error_percent and ratio == 10,
            computed=f"two particles by RK4, {lists}; lowest stiffness over it: {ratio:g}",
        ),
        claim(
            SOURCES["text-error-falls"],
            holds=scaled[-1] < 0.1 * scaled[0] or fixed[-1] < 0.1 * fixed[0],
            computed=lists,
        ),
    ]
