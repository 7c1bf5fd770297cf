"""What is known exactly of a head-on impact."""

from __future__ import annotations

import math

from harness.cases.contact_base.parameters import ContactSystem
from harness.theory.dashpot import damping_ratio as ratio_of
from harness.theory.dashpot import restitution_clipped, restitution_unclipped


def closed_forms(parameters: ContactSystem, speed: float) -> dict[str, float]:
    """Return exact quantities of an impact at a speed [m/s], by their names."""
    if parameters.normal == "hooke" and parameters.damping != "viscoelastic":
        return _linear(parameters, speed)
    if parameters.normal == "hertz" and not parameters.clipped:
        if parameters.damping == "none":
            return {"restitution": 1.0}
        if parameters.damping == "coeff_restitution":
            assert parameters.restitution is not None
            return {"restitution": parameters.restitution}
    return {}


def damping_ratio(parameters: ContactSystem) -> float:
    """Return zeta = eta_n / (2 sqrt(k m*)) of a linear contact."""
    k, m = parameters.normal_stiffness, parameters.reduced_mass
    assert k is not None
    if parameters.damping == "coeff_restitution":
        assert parameters.restitution is not None
        return ratio_of(parameters.restitution)
    mass = m if parameters.damping == "mass_velocity" else 1.0
    return (parameters.damping_coefficient or 0.0) * mass / 2.0 / math.sqrt(k * m)


def _linear(parameters: ContactSystem, speed: float) -> dict[str, float]:
    zeta = damping_ratio(parameters)
    k, m = parameters.normal_stiffness, parameters.reduced_mass
    assert k is not None
    if zeta >= 1.0:
        return {}
    omega, root = math.sqrt(k / m), math.sqrt(1.0 - zeta * zeta)
    # x = v/(omega root) exp(-zeta omega t) sin(omega root t) turns at tan(omega root t) = root/zeta
    turn = math.acos(zeta) / root
    overlap = speed / omega * math.exp(-zeta * turn)
    if parameters.clipped:
        return {"restitution": restitution_clipped(zeta), "largest_overlap_m": overlap}
    return {
        "restitution": restitution_unclipped(zeta),
        "contact_time_s": math.pi / omega / root,
        "largest_overlap_m": overlap,
    }
