"""The three kinds of friction of a contact as sliders: tangential, rolling, twisting.

tangential: linear, kappa = k_t; Mindlin, kappa = 8 G* a (Mindlin 1949; Johnson 1985, section 7.2),
a that of the contact; beside mdr G* is twice as large at a wall, which is rigid; or, by a rule,
both are Hertz's: a^2 = R* overlap, of radii as they have grown, and a wall of the same material. It
holds for the total displacement (``mindlin``) or for its increments (``mindlin/force``,
whose state is the integral of a u). The rescaled ones shrink the state with a while the contact
opens (Thornton, Cummins and Cleary 2013). eta_t = x_t eta_n.

rolling (sds): u = R* (omega_i - omega_j) x n (Wang, Alonso-Marroquin and Guo, Particuology 23, 49
(2015)), the torque on i is R* n x f.

twisting: u = (omega_i - omega_j) . n along n, the torque on i is f. marshall (Marshall 2009,
section 2.6): kappa = K a^2 / 2, eta = eta_t a^2 / 2, friction 2/3 a mu, K the tangential stiffness.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from harness.pair.damping import dashpot
from harness.pair.flat import pressed
from harness.pair.geometry import Change, Geometry
from harness.pair.normal import MDR, Elastic, pull_off_force
from harness.pair.plastic import grown
from harness.pair.records import ROLLING, TANGENTIAL, TWIST_MARSHALL, Records, System
from harness.pair.slider import INSIDE, Slider
from harness.pair.vectors import Vector, compiled, cross, dot, scaled


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
    one = system.contacts[contact]
    if not system.law.hertzian or g.overlap <= 0.0:
        return normal.elastic.radius, normal.growth
    flats = 1.0 if one.second < 0 else 2.0
    more, rate = grown(system.law, one, g.overlap)
    curvature, overlap = one.curvature + more / flats, g.overlap + flats * more
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
def velocity_rate(kind: int, change: Change, g: Geometry, system: System, contact: int) -> Vector:
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
