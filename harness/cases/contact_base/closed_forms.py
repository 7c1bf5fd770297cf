"""What is known exactly of the normal motion of an impact, by the names of quantities."""

from __future__ import annotations

import math

from harness.cases.contact_base.parameters import ContactSystem, hertz_spring
from harness.theory import bounce, dashpot, hertz_impact


def head_on(parameters: ContactSystem, speed: float) -> dict[str, float]:
    """Return what is known of an impact at a speed [m/s] without gravity."""
    if parameters.normal == "hooke" and parameters.damping != "viscoelastic":
        return _linear(parameters, speed)
    if parameters.normal != "hertz" or parameters.clipped:
        return {}
    if parameters.damping == "none":
        return _hertz(parameters, speed)
    if parameters.damping == "coeff_restitution":
        assert parameters.restitution is not None
        return {"restitution": parameters.restitution}
    return {}


def rebound(parameters: ContactSystem, height: float, gravity: float) -> dict[str, float]:
    """Return what is known of a fall from a height [m] under gravity [m/s2] on a floor."""
    elastic = {"rebound_ratio": 1.0} if parameters.damping == "none" else {}
    if parameters.normal != "hooke" or parameters.damping == "viscoelastic" or parameters.clipped:
        return elastic
    zeta, omega = oscillator(parameters)
    speed = math.sqrt(2.0 * gravity * height)
    left = bounce.rebound(omega, zeta, gravity, speed) if zeta < 1.0 else None
    if left is None:
        return elastic
    ratio = left.speed**2 / (2.0 * gravity * height)
    return {"rebound_ratio": ratio, "contact_time_s": left.duration, **elastic}


def _hertz(parameters: ContactSystem, speed: float) -> dict[str, float]:
    told = parameters.reduced_mass, hertz_spring(parameters), speed
    return {
        "restitution": 1.0,
        "contact_time_s": hertz_impact.contact_time(*told),
        "largest_overlap_m": hertz_impact.largest_overlap(*told),
        "largest_force_N": hertz_impact.largest_force(*told),
    }


def _linear(parameters: ContactSystem, speed: float) -> dict[str, float]:
    zeta, omega = oscillator(parameters)
    if zeta >= 1.0:
        return {}
    overlap = speed / omega * dashpot.largest_overlap(zeta)
    if parameters.clipped:
        return {
            "restitution": dashpot.restitution_clipped(zeta),
            "largest_overlap_m": overlap,
        }
    return {
        "restitution": dashpot.restitution_unclipped(zeta),
        "contact_time_s": dashpot.duration_unclipped(zeta) / omega,
        "largest_overlap_m": overlap,
    }


def oscillator(parameters: ContactSystem) -> tuple[float, float]:
    """Return zeta = eta_n / (2 sqrt(k m*)) and omega = sqrt(k / m*) [1/s] of a linear contact."""
    k, m = parameters.normal_stiffness, parameters.reduced_mass
    assert k is not None
    omega = math.sqrt(k / m)
    if parameters.damping == "coeff_restitution":
        assert parameters.restitution is not None
        return dashpot.damping_ratio(parameters.restitution), omega
    mass = m if parameters.damping == "mass_velocity" else 1.0
    return (parameters.damping_coefficient or 0.0) * mass / 2.0 / math.sqrt(k * m), omega
