"""What MFiX-DEM declares of itself: the rules that its recorded runs and its source show."""

from __future__ import annotations

from harness.engines.mfix.contacts import CONTACTS
from harness.engines.traits import Traits
from harness.parameters.contact import Contact

CONTACT = Contact(
    name="MFiX", restitution=1e-20, damping_ratio=None, tail="attractive", effective_mass="half"
)
"""The source's contact as MFiX has it: m_eff = m/2 also against a fixed sphere, not clipped."""

OBTAIN = (
    "build it (mfix.netl.doe.gov, MFiX 21.3.2, batch solver, cmake -DVERSION=21.3.2) "
    "and give --program mfix=PATH"
)

TRAITS = Traits(
    install_hint=OBTAIN,
    versions=("21.3.2",),
    integrator="mfix-euler",
    microseconds_per_step=32.0,
    tails=("attractive",),
    effective_masses=("half",),
    restitution_floor=1e-20,
    most_damping=CONTACT.zeta,
    digits=7,
    contact_models=CONTACTS,
    # velocities first, by the forces at the start of a step
    contact_powers=(1.0,),
    title="MFiX",
    caveats=(
        "The effective mass against a fixed sphere is m/2: a nominal restitution of 1e-20 "
        "is really about 0.044.",
        "DTSOLID_FACTOR divides the damped contact time: at e = 1e-20 its default of 50 is "
        "4.8 steps per pi sqrt(m/k).",
        "A restitution of 0 divides by zero.",
        "No keyword holds a particle: the fixed spheres hang at a mass outflow of no velocity.",
        "A restart file left in the folder makes a new run stop.",
        "A particle's place in the arrays changes as it crosses a boundary: its global id "
        "does not.",
        "The search for neighbours loses contacts where its cells are less than two diameters "
        "wide: the inputs set DESGRIDSEARCH_IMAX and _JMAX.",
        "Paths are written in single precision.",
    ),
)
