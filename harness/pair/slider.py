"""A spring and a dashpot in parallel under Coulomb's limit: what all three kinds of friction are.

With a velocity u and a displacement q (vectors in the frame that turns with the contact)

    T = -kappa q,   q' = gain u + rescale q,   f = T - eta u,   |f| <= cap.

At the limit the spring is cut back so that |f| stays there (Luding 2008, section 4.2): with
f = cap e, T = cap e + eta u, and the direction turns as

    cap e' = the part across e of (T' - (eta u)'),   T' = -kappa' q - kappa q',

T' the rate of the spring if it stuck. Sliding ends when that rate no longer reaches the limit,
e . (T' - (eta u)') < cap'. While a slider slides, its state holds e instead of q.

Where the dashpot is limited until it slides only, T = cap e from then on: the spring jumps. It
slides as long as |cap e - eta u| > cap, whatever way it moves.
"""

from __future__ import annotations

from typing import NamedTuple

from harness.pair.vectors import (
    Vector,
    across,
    compiled,
    direction,
    dot,
    length,
    plus,
    scaled,
)

OFF, STICK, SLIDE = range(3)
INSIDE, OUTSIDE, STICKING_ONLY, UNTIL_SLIDING = range(4)

IN_CAP = {
    "inside": INSIDE,
    "outside": OUTSIDE,
    "sticking_only": STICKING_ONLY,
    "until_sliding": UNTIL_SLIDING,
}

ALIGNED = 1e-13
"""[rad] between a sliding force and what drives it that is round-off, of a force as large as those
of the contact; of a smaller one as much more, for its direction is followed less closely."""

FAINTEST = 1e8
"""Times that, at most."""

FELT = 1e-8
"""[limit] least jump of the force as a slider sticks whose dashpot was off: else it chatters."""


class Slider(NamedTuple):
    """Coefficients of a slider at one instant, and their rates; without a spring kappa is 0."""

    stiffness: float
    stiffness_rate: float
    dashpot: float
    dashpot_rate: float
    friction: float
    friction_rate: float
    velocity: Vector
    gain: float
    rescale: float


@compiled
def spring(slider: Slider, q: Vector, mode: int, cap: float, damping: int) -> Vector:
    """Return the elastic part T of the force from the state of a cut-back slider."""
    if mode == SLIDE:
        force = scaled(cap, direction(q))
        return plus(force, slider.dashpot, slider.velocity) if damping == INSIDE else force
    return scaled(-slider.stiffness, q)


@compiled
def displacement(slider: Slider, q: Vector, mode: int, cap: float, damping: int) -> Vector:
    """Return q of a slider, whatever its state holds."""
    if mode == SLIDE:
        if slider.stiffness == 0.0:  # Mindlin's where a contact begins
            return (0.0, 0.0, 0.0)
        return scaled(-1.0 / slider.stiffness, spring(slider, q, mode, cap, damping))
    return q


@compiled
def limited(slider: Slider, q: Vector, damping: int) -> Vector:
    """Return what Coulomb's limit applies to before it slides, from a state that holds q."""
    held = scaled(-slider.stiffness, q)
    within = damping in (INSIDE, UNTIL_SLIDING)
    return plus(held, -slider.dashpot, slider.velocity) if within else held


@compiled
def sliding_direction(slider: Slider, q: Vector, damping: int) -> Vector:
    """Return the direction of the force that begins to slide, from a state that holds q.

    A spring that is slack takes that of the slip, as its next stretch does.
    """
    pull, both = scaled(-slider.stiffness, q), limited(slider, q, damping)
    slack = length(pull) <= FELT * length(both)
    return direction(pull if damping == UNTIL_SLIDING and not slack else both)


@compiled
def force(slider: Slider, q: Vector, mode: int, cap: float, rules: tuple[bool, int]) -> Vector:
    """Return the force f of a slider; ``rules`` are whether the limit cuts back, and damping."""
    cut_back, damping = rules
    if mode == OFF:
        return (0.0, 0.0, 0.0)
    if mode == SLIDE:
        held = direction(q) if cut_back else direction(limited(slider, q, damping))
        held = scaled(cap, held)
        return plus(held, -slider.dashpot, slider.velocity) if damping == OUTSIDE else held
    return plus(scaled(-slider.stiffness, q), -slider.dashpot, slider.velocity)


@compiled
def spring_rate(slider: Slider, q: Vector) -> Vector:
    """Return T' of a slider that sticks, in the turning frame."""
    moved = plus(scaled(slider.gain, slider.velocity), slider.rescale, q)
    return plus(scaled(-slider.stiffness_rate, q), -slider.stiffness, moved)


@compiled
def drive(slider: Slider, q: Vector, change: Vector, damping: int) -> Vector:
    """Return the rate of what the limit applies to, if it stuck; ``change`` is u'."""
    rate = spring_rate(slider, q)
    if damping != INSIDE:
        return rate
    rate = plus(rate, -slider.dashpot_rate, slider.velocity)
    return plus(rate, -slider.dashpot, change)


@compiled
def state_rate(
    slider: Slider,
    q: Vector,
    mode: int,
    cap: tuple[float, float],
    rules: tuple[bool, int],
    change: Vector,
) -> Vector:
    """Return the rate of the state in the turning frame.

    ``cap`` is the limit, and a limit so small that the direction no longer matters, 1e-8 of those
    of the contact: at the limit 0 it would turn infinitely fast.
    """
    cut_back, damping = rules
    if mode == OFF:
        return (0.0, 0.0, 0.0)
    if mode == SLIDE and cut_back:
        held = displacement(slider, q, mode, cap[0], damping)
        e = direction(q)
        driven = drive(slider, held, change, damping)
        turning = across(driven, e)
        # a force that is aligned stays so, however fast it would turn: no stiffness from round-off
        aligned = ALIGNED * max(1.0, FAINTEST * cap[1] / max(cap[0], cap[1]))
        if length(turning) <= aligned * length(driven):
            return (0.0, 0.0, 0.0)
        return scaled(1.0 / max(cap[0], cap[1]), turning)
    return plus(scaled(slider.gain, slider.velocity), slider.rescale, q)


@compiled
def beyond(
    slider: Slider,
    q: Vector,
    mode: int,
    cap: tuple[float, float],
    rules: tuple[bool, int],
    change: Vector,
) -> float:
    """Return a number that turns positive when the slider leaves its mode; cap has its rate."""
    cut_back, damping = rules
    if mode == STICK:
        return length(limited(slider, q, damping)) - cap[0]
    if mode == SLIDE and cut_back and damping == UNTIL_SLIDING and slider.dashpot > 0.0:
        stuck = plus(scaled(cap[0], direction(q)), -slider.dashpot, slider.velocity)
        return (1.0 - FELT) * cap[0] - length(stuck)
    if mode == SLIDE and cut_back:
        held = displacement(slider, q, mode, cap[0], damping)
        return cap[1] - dot(direction(q), drive(slider, held, change, damping))
    return cap[0] - length(limited(slider, q, damping))
