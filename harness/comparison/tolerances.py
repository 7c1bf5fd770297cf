"""The one table of tolerances: how much, and why it is what it is."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Tolerance:
    """An absolute and a relative tolerance; a difference within their sum passes."""

    unit: str
    absolute: float
    relative: float
    reason: str

    def width(self, expected: float) -> float:
        """Return the tolerance about an expected value."""
        return self.absolute + self.relative * abs(expected)


TOLERANCES: dict[str, Tolerance] = {
    "closed form": Tolerance(
        "deg", 1e-9, 0.0, "two routes to the same formula in double precision: round-off only"
    ),
    "chain, final velocity": Tolerance(
        "m/s",
        1e-10,
        0.0,
        "speed 1 m/s; the exact propagator has no step: round-off, events located to 1e-13",
    ),
    "chain, closed form": Tolerance(
        "",
        0.0,
        1e-10,
        "the exact propagator has no step: round-off, and the events located to 1e-13",
    ),
    "critical angle, extrapolated": Tolerance(
        "deg",
        3e-4,
        0.0,
        "plastic contact, step to zero and stiffness to infinity: the sum of the last "
        "corrections that the ladder resolves",
    ),
    "two routes": Tolerance(
        "deg", 0.0, 0.0, "passage and steady must agree within the sum of their uncertainties"
    ),
    "same script, two ways to run it": Tolerance(
        "J", 0.0, 1e-12, "the same LAMMPS instructions: round-off of a different build at most"
    ),
    "scale invariance": Tolerance(
        "deg",
        1e-9,
        0.0,
        "only k d/(m g) enters: the same motion in other units, up to the round-off "
        "of about 1e5 steps",
    ),
    "critical angle, reference DEM": Tolerance(
        "deg",
        5e-4,
        0.0,
        "the same steps in two codes: round-off, but where it moves a contact's end to another "
        "step the angle jumps within its jitter",
    ),
    "path, reference DEM": Tolerance(
        "",
        1e-6,
        0.0,
        "the same steps in two codes: round-off of 1e-15, which a crest passed slowly multiplies "
        "by up to e for each sqrt(d/g)",
    ),
    "restitution, adaptive": Tolerance(
        "",
        1e-8,
        0.0,
        "no step, events located: tolerance 1e-11 of each of a few hundred steps, and the "
        "overlap cancels five digits of the position",
    ),
    "tower force, overlap law": Tolerance(
        "",
        1e-5,
        0.0,
        "velocity Verlet at 1000 steps per contact: second order, (omega h)^2 = 1e-5; "
        "RK4 at 4000 steps meets contact changes at second order too",
    ),
    "tower force, deformable law": Tolerance(
        "",
        1e-4,
        0.0,
        "as for the overlap law, but the highest frequency grows with the touching chain: "
        "ten times the room",
    ),
    "contact changes": Tolerance(
        "t0",
        2e-3,
        0.0,
        "a thousand samples per t0: a change is known to a sample in each of the two runs",
    ),
    "tower impulse": Tolerance(
        "N s", 0.0, 1e-5, "an integral of the force, hence at least as close as the force"
    ),
    "impulse ratio": Tolerance(
        "", 1e-5, 0.0, "two impulses at 1000 steps per contact, each good to 1e-5 at worst"
    ),
    "tall tower in LAMMPS": Tolerance(
        "", 1e-5, 0.0, "velocity Verlet at 1000 steps per contact: (omega h)^2 = 1e-5"
    ),
    "critical angle, engines, plastic contact": Tolerance(
        "deg",
        3e-3,
        0.0,
        "k = 1e6 N/m or more, 50 steps or more: first order in the step, -2e-3 deg at 50, and "
        "in 1/k, -5e-4 deg at 1e6; both together, and the jitter of a contact's begin",
    ),
    "critical angle, engines of one class": Tolerance(
        "deg",
        2e-3,
        0.0,
        "same law, step and scheme: each is within 5e-4 deg of the reference DEM, and six "
        "digits of an output are worth 1.4e-3",
    ),
    "critical angle, recorded MFiX": Tolerance(
        "deg", 3e-3, 0.0, "bisected to 2e-3 deg there and 1e-3 deg here"
    ),
    "tower, engines": Tolerance(
        "",
        0.0,
        2e-5,
        "10000 steps per contact: a second-order scheme is off by (omega h)^2 = 1e-7; one that "
        "starts half a step of gravity late, by g h / (2 v0) per t0, some 1e-6; six digits 5e-6",
    ),
}
"""Keyed by what is compared. A zero width means that the check brings its own."""
