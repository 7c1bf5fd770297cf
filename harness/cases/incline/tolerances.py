"""How close results of the incline must be, and why: of checks, and of the baseline."""

from __future__ import annotations

from harness.comparison.tolerances import Tolerance

CLOSED_FORM = Tolerance(
    "deg", 1e-9, 0.0, "two routes to the same formula in double precision: round-off only"
)
EXTRAPOLATED = Tolerance(
    "deg",
    3e-4,
    0.0,
    "plastic contact, step to zero and stiffness to infinity: the sum of the last "
    "corrections that the ladder resolves",
)
MOST_ROUTE_JITTER = 2e-3
"""[deg] a stated uncertainty may add to the resolution of a search: where in a step a contact
begins moves the angle of the source's contact by 1e-3 deg at 50 steps in the reference DEM."""

ALL_WELLS = Tolerance("", 0.0, 0.0, "a count: above the critical angle no well traps the grain")

TWO_WAYS = Tolerance(
    "J", 0.0, 1e-12, "the same instructions: round-off of a different build at most"
)
SCALES = Tolerance(
    "deg",
    1e-9,
    0.0,
    "only k d/(m g) enters: the same motion in other units, up to the round-off of about 1e5 steps",
)
REFERENCE_ANGLE = Tolerance(
    "deg",
    5e-4,
    0.0,
    "the same steps in two codes: round-off, but where it moves a contact's end to another "
    "step the angle jumps within its jitter",
)
REFERENCE_PATH = Tolerance(
    "",
    1e-6,
    0.0,
    "the same steps in two codes: round-off of 1e-15, which a crest passed slowly multiplies "
    "by up to e for each sqrt(d/g)",
)
REFERENCE_SPEED = Tolerance(
    "",
    1e-4,
    0.0,
    "as for the path, times the rate of the contact, omega sqrt(d/g) = 3e2 at k = 1e6 N/m",
)
REFERENCE_PASSAGE = Tolerance(
    "",
    1e-8,
    0.0,
    "the same steps in two codes, one well: round-off of 1e-15, times 20 at the shock and the rate "
    "of the contact, 3e2, in a velocity",
)
REFERENCE_FIRST_CRESTS = Tolerance(
    "m g d",
    1e-8,
    0.0,
    "the same steps in two codes, five wells: round-off of 1e-15, which each shock multiplies by "
    "20, as it shifts where in a step the next contact begins",
)
REFERENCE_CRESTS = Tolerance(
    "m g d",
    2e-5,
    0.0,
    "the same steps in two codes, ten wells: round-off has grown to what a step is worth in "
    "energy at 200 steps per contact, 2e-6 m g d, times 10",
)
TOLD_ENERGY = Tolerance(
    "m g d",
    1e-8,
    0.0,
    "the same state, or a part of a sampling interval later, where the contact has settled and "
    "its dashpot takes next to nothing: round-off",
)
ADAPTIVE_RESTITUTION = Tolerance(
    "",
    1e-8,
    0.0,
    "no step, events located: tolerance 1e-11 of each of a few hundred steps, and the "
    "overlap cancels five digits of the position",
)
ENGINES_PLASTIC = Tolerance(
    "deg",
    3e-3,
    0.0,
    "k = 1e6 N/m or more, 50 steps or more: first order in the step, -2e-3 deg at 50, and "
    "in 1/k, -5e-4 deg at 1e6; both together, and the jitter of a contact's begin",
)
ENGINES_OF_ONE_CLASS = Tolerance(
    "deg",
    2e-3,
    0.0,
    "same law, step and scheme: each is within 5e-4 deg of the reference DEM, and six "
    "digits of an output are worth 1.4e-3",
)
RECORDED = Tolerance("deg", 3e-3, 0.0, "bisected to 2e-3 deg there and 1e-3 deg here")

RIGID = Tolerance(
    "deg",
    1e-2,
    0.0,
    "angles of finite stiffness are measured to 1e-4 deg by passage and 4e-4 deg by steady motion "
    "and lie up to 0.04 deg from rigid spheres; two terms in the stiffness leave a few 1e-3",
)

REGRESSION: dict[str, Tolerance] = {
    "critical_angle_deg": Tolerance(
        "deg",
        1e-9,
        0.0,
        "a root of the margin or a bisection, the same numbers every time: round-off of about "
        "1e5 steps, measured at 2e-13 deg by a change of units",
    ),
    "extrapolated_angle_deg": Tolerance(
        "deg",
        1e-8,
        0.0,
        "a weighted fit through the rungs passes their round-off on, enlarged less than ten times",
    ),
    "margin_over_mgd": Tolerance(
        "",
        1e-11,
        0.0,
        "energy of one passage over m g d: round-off of 1e4 steps on numbers of order 1; the "
        "most sensitive number there is",
    ),
    "step_s": Tolerance("s", 0.0, 1e-12, "time over steps, a quotient of two exact counts"),
    "series": Tolerance(
        "",
        0.0,
        1e-9,
        "over the largest value of the column: round-off of 1e4 steps; written to 12 digits",
    ),
}
"""Of the baseline's records, by quantity."""
