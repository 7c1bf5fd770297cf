"""What of mdr is stated together: its branches, dashpots, and friction beside them."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from harness.parameters.contact_law import ContactLaw

DAMPINGS = ("none", "velocity", "mdr")


def check(law: ContactLaw) -> None:
    """Raise ValueError for what mdr is not stated with, and for what is stated with mdr alone."""
    if law.normal != "mdr":
        if law.bulk_response:
            raise ValueError(
                f"bulk_response = True: normal = {law.normal!r} has none (normal = mdr does)"
            )
        if law.damping == "mdr":
            raise ValueError("damping = 'mdr': needs normal = mdr")
        return
    if law.damping not in DAMPINGS:
        raise ValueError(f"damping = {law.damping!r}: normal = mdr takes none, velocity or mdr")
    if law.bulk_response and law.damping == "mdr":
        raise ValueError(
            "damping = 'mdr': must be none or velocity beside bulk_response = True: its stiffness "
            "is that of the elastic contact, of which the bulk's leaves nothing"
        )
    _resists(law)
    _adheres(law)
    poisson = law.poisson_ratio or 0.0
    if law.lags and not 0.0 <= poisson < 0.5:
        branch = _named(law)[0]
        raise ValueError(
            f"poisson_ratio = {poisson!r}: must be from 0 to below 0.5 beside {branch}: "
            "the bulk modulus must be finite"
        )


def _named(law: ContactLaw) -> list[str]:
    """Return the branches beside the elastic one that a law of mdr has, with their values."""
    given = {
        "yield_stress": law.yield_stress is not None,
        "surface_energy": law.surface_energy is not None,
        "bulk_response": law.bulk_response,
    }
    return [f"{name} = {getattr(law, name)!r}" for name, is_given in given.items() if is_given]


def _resists(law: ContactLaw) -> None:
    """Raise ValueError for rolling or twisting resistance of a sphere that swells or is squeezed.

    Their levers are R* and the contact radius, which no source defines for it.
    """
    for part in ("rolling", "twisting"):
        if law.lags and getattr(law, part) != "none":
            raise ValueError(
                f"{part} = {getattr(law, part)!r}: must be none beside {_named(law)[0]}"
            )


def _adheres(law: ContactLaw) -> None:
    """Raise ValueError for adhesion beside something else.

    The only code with mdr, LAMMPS, is without adhesion in the limit of a small step
    (mdr-adhesion-fades): whatever adhesion is stated with, the comparison would find that alone.
    Besides, a contact that yields begins apart here, as pull-off does not; Coulomb's limit under a
    tension has no definition in the source; a bulk that responds alone leaves no springs that hold.
    """
    if law.surface_energy is None:
        return
    branches = _named(law)
    beside = [
        f"{part} = {getattr(law, part)!r}"
        for part in ("damping", "tangential", "rolling", "twisting")
        if getattr(law, part) != "none"
    ]
    others = [one for one in branches if not one.startswith("surface_energy")] + beside
    if others:
        raise ValueError(
            f"surface_energy = {law.surface_energy!r}: normal = mdr is stated with it alone, not "
            f"beside {others[0]}: LAMMPS's adhesion fades with the step (mdr-adhesion-fades), so "
            "that nothing could be held against it"
        )
