"""The formulas of a contact law in a line each, as a page of the matrix states them."""

from __future__ import annotations

from collections.abc import Iterator

from harness.parameters.contact_law import ContactLaw

_EQUAL = "E* = E / (2 (1 - nu^2))"
_TWO = "1/E* = (1 - nu_1^2) / E_1 + (1 - nu_2^2) / E_2"
NORMAL = {
    "hooke": "F = k_n delta, delta the overlap",
    "hertz": f"F = 4/3 E* a delta, a = sqrt(R* delta), {_EQUAL}",
    "dmt": f"F = 4/3 E* a delta - 4 pi gamma R*, a = sqrt(R* delta), {_EQUAL}",
    "jkr": "F = 4 E* a^3 / (3 R*) - 4 sqrt(pi gamma E* a^3), with "
    f"delta = a^2 / R* - 2 sqrt(pi gamma a / E*), {_EQUAL}",
    "mdr": "F = 2 R^2 E / (1 - nu^2) (theta - sin theta cos theta) on each side of a rigid flat, "
    "cos theta = 1 - d / (2 R), d the depth of the flat: half the overlap, all of it at a wall; of "
    "two sizes the mean of both sides, the flat where the surfaces cross at the largest overlap",
}
_ON_FLAT = "on each side of a rigid flat at the depth d"
YIELD = (
    f"{_ON_FLAT}: as above up to Hertz's mean pressure p = Y (1 + 1.75 exp(-4.4 d / R)); from "
    "there F = p pi a^2, a^2 = 2 R d - d^2 - d_Y (R_0 - d_Y), with a radius R that grows so that "
    "the volume stays, less its elastic strain; back along an ellipse of the half axes "
    "2 p a (1 - nu^2) / E and a"
)
ADHESION = (
    f"{_ON_FLAT}: as above while it is pressed in; pulled, "
    "F = 2 R^2 E' (theta - sin theta cos theta) - 2 E' a l, a = R sin theta, "
    "d = 2 R (1 - cos theta) - l, l = sqrt(2 pi a gamma / E'), E' = E / (1 - nu^2)"
)
BULK = (
    f"{_ON_FLAT}: F = K A^2 d / (4/3 pi R^3 - pi/3 d^2 (3 R - d)), A = pi R d, "
    "K = E / (3 (1 - 2 nu)), in place of the force above"
)
_SECANT = "sqrt(m* F / delta), zeta = -ln e / sqrt(pi^2 + ln^2 e)"
DAMPING = {
    "none": "none: the normal force is the elastic one",
    "velocity": "eta_n = eta_0",
    "mass_velocity": "eta_n = eta_0 m*",
    "viscoelastic": "eta_n = eta_0 m* a, a the contact radius",
    "tsuji": "eta_n = alpha(e) sqrt(2 m* F / delta), alpha the polynomial that is fitted to Tsuji "
    "et al. (1992)",
    "coeff_restitution": f"eta_n = c zeta {_SECANT}, c = 2 for hooke, sqrt(5) for hertz",
    "mdr": "eta_n = eta_0 sqrt(m* k), k = 2 E_eff a, a the contact radius, E_eff = E / (1 - nu^2) "
    "at a wall and half of it between spheres: the slope of the elastic force",
}
_EQUALLY = "G* = E / (4 (2 - nu) (1 + nu))"
_BOTH = "1/G* = (2 - nu_1) / G_1 + (2 - nu_2) / G_2, G = E / (2 (1 + nu))"
_MINDLIN = f"8 G* a, {_EQUALLY}"
_ADDED = f"the spring force grows by k_t times each displacement, k_t = {_MINDLIN}"
_TOTAL = f"spring k_t xi of the whole displacement xi, k_t = {_MINDLIN}"
_SHRINKS = "; it shrinks with a while the contact opens (Thornton et al. 2013)"
TANGENTIAL = {
    "linear_nohistory": "eta_t v_t alone, without a spring",
    "linear_history": "spring k_t xi, xi the displacement along the surface",
    "linear_history_classic": "spring k_t xi, xi the displacement along the surface, as in the "
    "earlier styles",
    "mindlin": _TOTAL,
    "mindlin_classic": f"{_TOTAL}, as in the earlier styles",
    "mindlin_rescale": _TOTAL + _SHRINKS,
    "mindlin/force": _ADDED,
    "mindlin_rescale/force": _ADDED + _SHRINKS,
}
RIGID = ", at a wall, which is rigid, of twice that G*"
ROLLING = {
    "sds": "spring and dashpot on the rolling displacement, whose velocity is R* (w_i - w_j) x n; "
    "the torque is at most mu_r R* |F_n|"
}
TWISTING = {
    "sds": "spring and dashpot on the angle about the normal; the torque is at most mu_w |F_n|",
    "marshall": "stiffness k_t a^2 / 2, dashpot eta_t a^2 / 2; the torque is at most "
    "2/3 a mu |F_n| (Marshall 2009)",
}


def formulas(law: ContactLaw) -> Iterator[tuple[str, str]]:
    """Yield each part of a law that is there, and its formula."""
    for part, formula in _parts(law):
        two = formula.replace(_EQUAL, _TWO).replace(_EQUALLY, _BOTH)
        yield part, two if law.two_materials else formula


def _parts(law: ContactLaw) -> Iterator[tuple[str, str]]:
    """Yield parts and formulas for two bodies of one material."""
    yield "normal force", NORMAL[law.normal]
    if law.yield_stress is not None:
        yield "yield", YIELD
    if law.normal == "mdr" and law.surface_energy:
        yield "adhesion", ADHESION
    if law.bulk_response:
        yield "bulk response", BULK
    dashpot = DAMPING[law.damping]
    if law.damping != "none":
        ends = ", and no attraction" if law.clipped else ""
        dashpot = f"F_n = F + eta_n d(delta)/dt{ends}; {dashpot}"
    yield "normal damping", dashpot
    if law.tangential != "none":
        limit = "F_t is at most mu |F_n|"
        mine = RIGID if law.normal == "mdr" and "mindlin" in law.tangential else ""
        told = f"{TANGENTIAL[law.tangential]}{mine}; eta_t = x_t eta_n; {limit}"
        yield "tangential force", told
    if law.rolling != "none":
        yield "rolling resistance", ROLLING[law.rolling]
    if law.twisting != "none":
        yield "twisting resistance", TWISTING[law.twisting]
