"""Rules in which codes that state one contact law differ; each of them moves the results.

Whether Mindlin's spring is total or incremental, and what becomes of it when the overlap shrinks,
is in the name of the law (``mindlin``, ``mindlin/force``, ``mindlin_rescale``, ...). Turning the
spring with the contact or projecting it differs by the square of the angle turned in a step only:
both have one limit, so that they are one rule here.
"""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from harness.parameters.base import Parameters


class Rules(Parameters):
    """What a code does where the law leaves a choice; the defaults are LAMMPS's.

    Four defaults are the literature's where LAMMPS's releases depart from it: ``tsuji_mass``,
    ``marshall_stiffness``, ``wall_force`` and ``mdr_friction``. The last four rules are choices of
    no code: known defects of releases, whose size they give.
    """

    cap: Literal["cut_back", "force_only"] = Field(
        "cut_back",
        description="[-] Coulomb's limit: cuts the spring back, or the force only (it goes on)",
    )
    damping_in_cap: Literal["inside", "outside", "sticking_only", "until_sliding"] = Field(
        "inside",
        description="[-] dashpot: limited with the spring, added to the limited spring, off "
        "while sliding, or that and limited with the spring before",
    )
    mindlin_factor: Literal["1", "2/3"] = Field(
        "1", description="[-] factor on Mindlin's stiffness 8 G* a"
    )
    torque_lever: Literal["contact_point", "radius", "share", "circle"] = Field(
        "contact_point",
        description="[-] lever of the tangential force between spheres: r - overlap/2, r, r less "
        "its share r_i/(r_i + r_j) of the overlap, or as far as the circle in which they cut",
    )
    velocity_lever: Literal["contact_point", "radius", "share", "circle"] = Field(
        "radius", description="[-] lever of omega in the velocity at the contact, likewise"
    )
    wall_lever: Literal["radius", "contact_point", "height"] = Field(
        "radius",
        description="[-] both levers at a wall: r, r - overlap/2, or r - overlap",
    )
    wall_turning: Literal["spin", "levered"] = Field(
        "spin",
        description="[-] rolling and twisting at a wall: with the spin, or with that times "
        "(r - overlap/2)/(r - overlap)",
    )
    wall_force: Literal["plain", "magnified"] = Field(
        "plain",
        description="[-] mdr at a wall: the law's force, or times 1 + exp(10.7 overlap/r - 10)",
    )
    mdr_friction: Literal["contact", "hertz"] = Field(
        "contact",
        description="[-] G* and contact radius of friction beside mdr: those of its own contact, "
        "whose wall is rigid, or Hertz's, sqrt(R* overlap) and a wall of the same material",
    )
    spring_spin: Literal["none", "mean"] = Field(
        "none",
        description="[-] springs turn about the normal: never, or with the bodies' mean spin",
    )
    spring_frame: Literal["contact", "room"] = Field(
        "contact",
        description="[-] the tangential spring turns with the normal, or keeps its direction",
    )
    pull_off: Literal["largest_tension", "fold"] = Field(
        "largest_tension",
        description="[-] jkr parts at its largest tension 3 pi gamma R*, or where no area is left",
    )
    frozen_mass: Literal["infinite", "own"] = Field(
        "infinite", description="[-] mass of a frozen partner in m*"
    )
    tsuji_mass: Literal["twice_effective", "effective"] = Field(
        "twice_effective",
        description="[-] M in Tsuji's eta_n = alpha sqrt(M F/overlap): 2 m* gives the restitution",
    )
    hertz_restitution: Literal["exact", "linear"] = Field(
        "exact",
        description="[-] coeff_restitution with Hertz's spring: zeta is multiplied by sqrt(5), "
        "which gives the restitution, or by 2 as for a linear one",
    )
    marshall_stiffness: Literal["spring", "coefficient"] = Field(
        "spring",
        description="[-] K in Marshall's twisting stiffness K a^2/2: 8 G* a, or 8 G* without a",
    )
    modulus_factor: float = Field(
        1.0, gt=0.0, description="[-] on E*, by which a defect is too stiff along the normal"
    )
    shear_factor: float = Field(
        1.0, gt=0.0, description="[-] on G*, by which a defect is too stiff along the surface"
    )
    pair_factor: float = Field(
        1.0, gt=0.0, description="[-] on k_n of spheres with one another; walls are without it"
    )
    cohesive_load: Literal["with_pull_off", "elastic"] = Field(
        "with_pull_off",
        description="[-] what mu is multiplied by beside dmt and jkr: elastic force + 2 pull-off "
        "force, or the size of the elastic force, with its attraction, alone",
    )
