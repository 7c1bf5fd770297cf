"""How close results of the tower must be, and why: of checks, and of the baseline."""

from __future__ import annotations

from harness.comparison.tolerances import Tolerance
from harness.parameters.tower import Law

FINAL_VELOCITY = Tolerance(
    "m/s",
    1e-10,
    0.0,
    "speed 1 m/s; the exact propagator has no step: round-off, events located to 1e-13",
)
CLOSED_FORM = Tolerance(
    "", 0.0, 1e-10, "the exact propagator has no step: round-off, and the events located to 1e-13"
)
FORCE: dict[Law, Tolerance] = {
    "overlap": Tolerance(
        "",
        1e-5,
        0.0,
        "velocity Verlet at 1000 steps per contact: second order, (omega h)^2 = 1e-5; "
        "RK4 at 4000 steps meets contact changes at second order too",
    ),
    "deformable": Tolerance(
        "",
        1e-4,
        0.0,
        "as for the overlap law, but the highest frequency grows with the touching chain: "
        "ten times the room",
    ),
}
CONTACT_CHANGES = Tolerance(
    "t0",
    5e-4,
    0.0,
    "located between a thousand samples per t0: to 1e-4 as measured, where a contact opens or "
    "closes for longer than that, and to 2.3e-4 where it touches for about one sample",
)
IMPULSE = Tolerance(
    "N s", 0.0, 1e-5, "an integral of the force, hence at least as close as the force"
)
IMPULSE_RATIO = Tolerance(
    "", 1e-5, 0.0, "two impulses at 1000 steps per contact, each good to 1e-5 at worst"
)
TALL_TOWER = Tolerance(
    "", 1e-5, 0.0, "velocity Verlet at 1000 steps per contact: (omega h)^2 = 1e-5"
)
ORDER = Tolerance(
    "",
    0.15,
    0.0,
    "a change of contacts falls anywhere within a step, which costs second order and scatters the "
    "errors: measured slopes are within 0.07 of 2; first and third order are far outside",
)
FINEST = Tolerance(
    "",
    0.0,
    2e-5,
    "10000 steps per contact: a second-order scheme is off by (omega h)^2 = 1e-7; one that "
    "starts half a step of gravity late, by g h / (2 v0) per t0, some 1e-6; six digits 5e-6",
)

REGRESSION: dict[str, Tolerance] = {
    "step_s": Tolerance("s", 0.0, 1e-12, "time over steps, a quotient of two exact counts"),
    "peak_force_N": Tolerance(
        "N",
        0.0,
        1e-9,
        "overlap times stiffness: positions to 20 m round at 4e-15 m, 4e-9 N of 2e3 N, and add up",
    ),
    "impulse_Ns": Tolerance(
        "N s", 0.0, 1e-9, "momentum at a root of the compression rate: round-off of 3e3 steps"
    ),
    "last_change_s": Tolerance(
        "s",
        0.0,
        1e-6,
        "a root of the force between samples: rounding of 1e-12 of the peak over the slope there, "
        "and 1e-8 where it moves the last sample before the change to the next one",
    ),
    "contact_changes": Tolerance("", 0.0, 0.0, "a count: one change more or less is a change"),
    "impulse_ratio": Tolerance("", 0.0, 1e-9, "a quotient of two impulses, each to round-off"),
    "series": Tolerance(
        "",
        0.0,
        1e-9,
        "over the largest value of the column: round-off of 1e4 steps; written to 12 digits",
    ),
}
"""Of the baseline's records, by quantity; ``series`` is the band about every series."""
