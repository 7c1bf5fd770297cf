"""The three kinds of friction of a contact, tangential, rolling and twisting, as sliders.

A slider is a spring and a dashpot in parallel under Coulomb's limit. With a velocity u and a
displacement q (vectors in the frame that turns with the contact)

    T = -kappa q,   q' = gain u + rescale q,   f = T - eta u,   |f| <= cap.

At the limit the spring is cut back so that |f| stays there (Luding 2008, section 4.2): with
f = cap e, T = cap e + eta u, and the direction turns as

    cap e' = the part across e of (T' - (eta u)'),   T' = -kappa' q - kappa q',

T' the rate of the spring if it stuck. Sliding ends when that rate no longer reaches the limit,
e . (T' - (eta u)') < cap'. While a slider slides, its state holds e instead of q. Where the dashpot
is limited until it slides only, T = cap e from then on: the spring jumps. It slides as long as
|cap e - eta u| > cap, whatever way it moves.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from harness.solvers.pair.geometry import Geometry, GeometryRates
from harness.solvers.pair.normal import MDR, Elastic, dashpot, grown, pressed, pull_off_force
from harness.solvers.pair.records import (
    ROLLING,
    TANGENTIAL,
    TWIST_MARSHALL,
    Records,
    System,
    Vector,
    across,
    compiled,
    cross,
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


# ---- the sliders of a contact
#
# tangential: linear, kappa = k_t; Mindlin, kappa = 8 G* a (Mindlin 1949; Johnson 1985, section
# 7.2), a that of the contact; beside mdr G* is twice as large at a wall, which is rigid; or, by a
# rule, both are Hertz's: a^2 = R* overlap, of radii as they have grown, and a wall of the same
# material. It holds for the total displacement (mindlin) or for its increments (mindlin/force,
# whose state is the integral of a u). The rescaled ones shrink the state with a while the contact
# opens (Thornton, Cummins and Cleary 2013). eta_t = x_t eta_n.
#
# rolling (sds): u = R* (omega_i - omega_j) x n (Wang, Alonso-Marroquin and Guo, Particuology 23,
# 49 (2015)), the torque on i is R* n x f.
#
# twisting: u = (omega_i - omega_j) . n along n, the torque on i is f. marshall (Marshall 2009,
# section 2.6): kappa = K a^2 / 2, eta = eta_t a^2 / 2, friction 2/3 a mu, K the tangential
# stiffness.


class Normal(NamedTuple):
    """The normal force of a contact [N] with dashpot, what loads friction, and their parts."""

    force: float
    load: float  # of Coulomb's law: |force|, or elastic force + 2 pull-off force with cohesion
    elastic: Elastic
    eta: float
    eta_slope: float
    growth: float  # d(ln a)/dt


@compiled
def normal_force(g: Geometry, system: System, contact: int, sign: int) -> Normal:
    """Return the normal force; ``sign`` is that of the force, which makes |force| smooth."""
    law = system.law
    curvature = system.contacts[contact].curvature
    bare = pressed(law, system.contacts[contact], g.overlap)
    mass = system.contacts[contact].mass
    modulus = law.stiffness * (2.0 if system.contacts[contact].second < 0 else 1.0)  # mdr's E_eff
    eta, slope = dashpot(law.damping, law.damping_coefficient, mass, g.overlap, bare, modulus)
    force = bare.force + eta * g.closing
    pull = pull_off_force(law.normal, law.surface, curvature)
    load = sign * force
    if pull > 0.0:
        load = bare.force + 2.0 * pull if law.pull_loads else abs(bare.force)
    return Normal(force, load, bare, eta, slope, bare.growth * g.closing)


@compiled
def load_rate(normal: Normal, g: Geometry, closing_rate: float, law: Records, sign: int) -> float:
    """Return the rate of the load [N/s]; ``closing_rate`` is the overlap's acceleration."""
    rate = normal.elastic.slope * g.closing
    if law.surface > 0.0:
        return rate if law.pull_loads or normal.elastic.force >= 0.0 else -rate
    rate += normal.eta_slope * g.closing**2 + normal.eta * closing_rate
    return sign * rate


@compiled
def slider_of(
    kind: int, g: Geometry, normal: Normal, system: System, contact: int, opening: bool
) -> Slider:
    """Return one of the sliders of a contact; ``opening``: its overlap shrinks."""
    law = system.law
    if kind == TANGENTIAL:
        return _tangential(g, normal, system, contact, opening)
    if kind == ROLLING:
        stiffness, eta, friction = law.rolling_coefficients
        u = scaled(system.contacts[contact].curvature, cross(g.spin, g.normal))
        return Slider(stiffness, 0.0, eta, 0.0, friction, 0.0, u, 1.0, 0.0)
    u = scaled(dot(g.spin, g.normal), g.normal)
    if law.twisting != TWIST_MARSHALL:
        stiffness, eta, friction = law.twisting_coefficients
        return Slider(stiffness, 0.0, eta, 0.0, friction, 0.0, u, 1.0, 0.0)
    return _marshall(normal, system, contact, g, u)


@compiled
def _tangential(g: Geometry, normal: Normal, system: System, contact: int, opening: bool) -> Slider:
    law = system.law
    stiffness, (a, growth) = _stiffness(system, contact), contact_radius(g, normal, system, contact)
    rate, gain = 0.0, 1.0
    if law.by_radius and law.by_force:
        gain = a
    elif law.by_radius:
        stiffness *= a
        rate = stiffness * growth
    rescale = growth if law.rescaled and opening else 0.0
    x = law.tangential_damping
    return Slider(
        stiffness,
        rate,
        x * normal.eta,
        x * normal.eta_slope * g.closing,
        law.friction,
        0.0,
        g.slip,
        gain,
        rescale,
    )


@compiled
def _stiffness(system: System, contact: int) -> float:
    """Return k_t [N/m], or 8 G* [Pa]: twice that of equal materials at the rigid wall of mdr."""
    law = system.law
    rigid = law.normal == MDR and not law.hertzian and system.contacts[contact].second < 0
    return float(law.tangential_stiffness * (2.0 if rigid and law.by_radius else 1.0))


@compiled
def contact_radius(
    g: Geometry, normal: Normal, system: System, contact: int
) -> tuple[float, float]:
    """Return the contact radius that friction takes [m], and d(ln a)/dt [1/s]."""
    record = system.contacts[contact]
    if not system.law.hertzian or g.overlap <= 0.0:
        return normal.elastic.radius, normal.growth
    flats = 1.0 if record.second < 0 else 2.0
    more, rate = grown(system.law, record, g.overlap)
    curvature, overlap = record.curvature + more / flats, g.overlap + flats * more
    growth = 0.5 * (rate / flats / curvature + (1.0 + flats * rate) / overlap)
    return math.sqrt(curvature * overlap), growth * g.closing


@compiled
def _marshall(normal: Normal, system: System, contact: int, g: Geometry, u: Vector) -> Slider:
    law = system.law
    a, growth = contact_radius(g, normal, system, contact)
    stiffness, powers = 0.5 * _stiffness(system, contact) * a * a, 2.0
    if law.marshall_by_radius:
        stiffness, powers = stiffness * a, 3.0
    eta = 0.5 * law.tangential_damping * normal.eta * a * a
    eta_rate = 0.5 * law.tangential_damping * normal.eta_slope * g.closing * a * a
    friction = 2.0 / 3.0 * law.friction * a
    return Slider(
        stiffness,
        powers * stiffness * growth,
        eta,
        eta_rate + 2.0 * growth * eta,
        friction,
        friction * growth,
        u,
        1.0,
        0.0,
    )


@compiled
def limits(kind: int, law: Records) -> tuple[bool, int]:
    """Return whether the limit cuts the spring back, and where the dashpot stands.

    A force without a spring is its dashpot under the limit, whatever the rules.
    """
    if kind == TANGENTIAL and law.tangential_stiffness == 0.0:
        return False, INSIDE
    return law.cut_back, law.damping_in_cap


@compiled
def velocity_rate(
    kind: int, change: GeometryRates, g: Geometry, system: System, contact: int
) -> Vector:
    """Return u' of a slider in the turning frame."""
    if kind == TANGENTIAL:
        return change.slip
    if kind == ROLLING:
        return scaled(system.contacts[contact].curvature, cross(change.spin, g.normal))
    return scaled(dot(change.spin, g.normal), g.normal)


@compiled
def torque(kind: int, force: Vector, g: Geometry, curvature: float) -> Vector:
    """Return the torque [N m] on body i of a rolling or twisting force; that on j is opposite."""
    return scaled(curvature, cross(g.normal, force)) if kind == ROLLING else force
