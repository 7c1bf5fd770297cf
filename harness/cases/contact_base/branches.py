"""What LAMMPS's mdr has beside its plain elastic branch, as submodels of the contact cases."""

from __future__ import annotations

from harness.cases.contact_base.submodels import MDR, Submodel

STIFF = {"damping": "mdr", "damping_coefficient": 0.25}
_ONE_FLAT = ("wall", "two spheres", "frozen sphere")

BRANCHES = (
    Submodel("mdr, mdr damping", {**MDR, **STIFF}, _ONE_FLAT, quick=False),
    Submodel("mdr, yield", {**MDR, "yield_stress": 1e6}, _ONE_FLAT, quick=False),
    Submodel("mdr, bulk", {**MDR, "bulk_response": True}, _ONE_FLAT, quick=False),
)
"""What mdr has beside its elastic branch, of one contact, and the dashpot that goes with it."""

STICKING_FLAT = Submodel("mdr, adhesion", {**MDR, "surface_energy": 0.5}, _ONE_FLAT, quick=False)
"""mdr's adhesion."""
