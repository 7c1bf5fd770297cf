"""Section Methods: two deformable particles, equations (14) and (15)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from harness.cases.tower.run import tower
from harness.chain.complementarity import contact_forces
from harness.parameters.tower import LAWS, Tower
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, claim, compare
from harness.reproduction.ledger.runs import free_collision
from harness.reproduction.ledger.samples import RADIUS, generator
from harness.theory import two_spheres

_STIFFNESS, _MASS = 1e6, 1.0
_STEPS = 1e-4  # [s] of the fixed-step runs
PAIR = Tower(height=1, base="free", gravity=0.0)


def statements(printed: Printed) -> Iterator[Statement]:
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
        found=forces / _MASS,
        k=_STIFFNESS,
        m=_MASS,
        r_0=RADIUS,
        x_1=0.0,
        x_2=distances[:, None],
        sign=np.array([1.0, -1.0]),
    )


def _motion() -> Iterator[Statement]:
    """Hold the closed form, half a wave, to the exact propagator and to RK4."""
    run = free_collision(2)
    t0 = two_spheres.contact_time(_MASS, _STIFFNESS)
    peak = two_spheres.peak_overlap(_MASS, _STIFFNESS, 2.0)
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
        float(run.compression.max()) / two_spheres.peak_overlap(_MASS, stiffness, case.speed) - 1
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
