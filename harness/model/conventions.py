"""Conventions in which codes differ on one contact law, and known defects of their releases.

Each field moves a result; its description gives formula, code and the size of what it moves, as
``tests/solvers/reference/test_rules.py`` and ``test_faults.py`` show for one scene each. Symbols:
n normal, u slip velocity, q spring, h step, w angular velocity, r radius, d overlap, M torque.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from harness.model.base import ZERO, Parameters, Vector

Scheme = Literal["velocity_verlet", "mfix_euler", "mfix_adams_bashforth"]
Steps = tuple[Annotated[int, Field(ge=0)], ...]


class Rules(Parameters):
    """Conventions of a code; the defaults are those of LAMMPS's pair style granular.

    Conventions marked with a power of h have one limit of small steps, the others do not.
    """

    scheme: Scheme = Field(
        "velocity_verlet",
        description="[-] v' = v + h/2 a, x+ = x + h v', a+ = a(x+, v'), v+ = v' + h/2 a+ (LAMMPS, "
        "LIGGGHTS, Yade, Kratos); MFiX's EULER: v+ = v + h a(x, v), x+ = x + h v+; its "
        "ADAMS_BASHFORTH: v+ = v + h/2 (3 a - a_before), x+ = x + h/2 (v + v+); h",
    )
    damping_in_cap: Literal["inside", "sticking_only"] = Field(
        "inside",
        description="[-] Coulomb's limit holds for |k q + eta u| (LAMMPS, Kratos), or for |k q|, "
        "with eta u added while it sticks (LIGGGHTS, Yade); up to 1",
    )
    torque_lever: Literal["contact_point", "radius"] = Field(
        "contact_point",
        description="[-] lever of friction between spheres: r - d/2, or r (LAMMPS's gran/*); d/r",
    )
    velocity_lever: Literal["radius", "contact_point"] = Field(
        "radius",
        description="[-] lever of w in u between spheres: r (LAMMPS), or r - d/2 (LIGGGHTS, Yade, "
        "Kratos); d/r",
    )
    wall_lever: Literal["radius", "contact_point", "height"] = Field(
        "radius",
        description="[-] both levers at a wall: r (LAMMPS), r - d/2 (LIGGGHTS), r - d (Yade, "
        "Kratos); d/r",
    )
    wall_spin: Literal["spin", "levered"] = Field(
        "spin",
        description="[-] of rolling and twisting at a wall: w, or (r - d/2) / (r - d) w (LIGGGHTS, "
        "epsd*); d/r",
    )
    frozen_mass: Literal["infinite", "own"] = Field(
        "infinite",
        description="[-] mass of a frozen partner in m*: infinite, or its own (MFiX); up to 1",
    )
    wall_curvature: float = Field(
        0.0,
        ge=0.0,
        description="[1/r] curvature of a plane in R* = r / (1 + c): 1e-8 of a wall whose radius "
        "is 1e8 r (Yade); c",
    )
    least_overlap: float = Field(
        0.0,
        ge=0.0,
        lt=1.0,
        description="[-] overlaps up to this share of r_i + r_j are no contact: 1e-15 (MFiX, "
        "SMALL_NUMBER); what rounding makes of bodies that just touch",
    )
    wall_touches_at_zero: bool = Field(
        False, description="[-] a wall acts at d = 0 (LIGGGHTS, LAMMPS 2022); one step; h"
    )
    spring_frame: Literal["turned", "projected", "rotated"] = Field(
        "turned",
        description="[-] how q follows n, before it grows by h u: (1 - n n) q of the old length "
        "(LAMMPS, Kratos); after it: (1 - n n) q (LIGGGHTS); before it: q - q x (n_old x n), "
        "then a spin about n_old (Yade); h^2",
    )
    torsion_frame: Literal["turned", "room", "rotated"] = Field(
        "turned",
        description="[-] of rolling and twisting springs: turned with n; torques k R* h w_t that "
        "keep their direction in room (LIGGGHTS, epsd*); rotated as q is (Yade); 1e-5",
    )
    spring_spin: Literal["none", "mean"] = Field(
        "none",
        description="[-] springs turn about n: never, or with (w_i + w_j)/2 . n (Yade); 1e-2",
    )
    slip_step: Literal["velocity", "turned_arms"] = Field(
        "velocity",
        description="[-] slip of a step: h u, or h (v_i - v_j) - (R(h w_i) - 1) r_i + "
        "(R(h w_j) - 1) r_j with arms turned by R (Kratos); h^2",
    )
    rescaled_from: Literal["last_radius", "displacement"] = Field(
        "last_radius",
        description="[-] mindlin_rescale: q times a / a_last, or sqrt(d / (d + n . dx)) of the "
        "displacement dx of the step (Kratos, previous_indentation); h",
    )
    forgets_setup: bool = Field(
        False,
        description="[-] the first force of a run stores no spring, yet has torques "
        "M + k R* h w (LIGGGHTS, epsd*); h",
    )
    mdr_wall_force: Literal["plain", "magnified"] = Field(
        "magnified",
        description="[-] of mdr at a wall: F, or (1 + exp(10.7 d/r_0 - 10)) F (LAMMPS); 9e-4",
    )
    mdr_growth: Literal["whole", "screened"] = Field(
        "screened",
        description="[-] radii of mdr grow by the volume, or by that times "
        "1 / (1 + exp(-75 (psi - 0.2))), up to 1.5 r_0 (LAMMPS)",
    )
    mdr_growth_steps: float = Field(
        10.0, ge=1.0, description="[step] over which growth is averaged: 10 (LAMMPS); 7e-5, h"
    )


class Faults(Parameters):
    """Switches of known defects; without any of them a code follows its law and conventions."""

    tsuji_effective_mass: bool = Field(
        False, description="[-] tsuji has sqrt(m* F/d), not sqrt(2 m* F/d) (LAMMPS 2022 to 2025)"
    )
    marshall_without_radius: bool = Field(
        False,
        description="[-] Marshall's stiffness with Mindlin is 8 G* a^2/2, not 8 G* a a^2/2 "
        "(LAMMPS 2023 to 2025)",
    )
    twisting_limit_by_rate: bool = Field(
        False,
        description="[-] a twisting torque at its limit has the sign of the rate (LAMMPS 2022 to "
        "2025)",
    )
    tangential_radius: Literal["none", "walls", "all"] = Field(
        "none",
        description="[-] where a linear tangential spring is k_t a q, a in m (LAMMPS 2023 to 2025: "
        "walls of the old styles, linear_history_classic)",
    )
    cap_without_radius: Literal["none", "walls", "all"] = Field(
        "none",
        description="[-] where a spring that Coulomb's limit cuts back is left as a q (LAMMPS "
        "2023 to 2025: classic styles)",
    )
    shear_factor: float = Field(
        1.0, gt=0.0, description="[-] on G* (LAMMPS 2023 to 2025: mixed materials)"
    )
    wall_modulus_factor: float = Field(
        1.0, gt=0.0, description="[-] on E* at walls (LAMMPS 2022: 1 + nu)"
    )
    wall_shear_factor: float = Field(
        1.0, gt=0.0, description="[-] on G* at walls (LAMMPS 2022: (2 - nu)^2 (1 + nu)^2 / 8)"
    )
    dmt_limit_without_pull_off: bool = Field(
        False, description="[-] Coulomb's limit of dmt and jkr is mu |F| (LAMMPS 2022)"
    )
    longest_neck: float | None = Field(
        None,
        ge=0.0,
        description="[m] of jkr: a longer neck parts; 0 at region walls and the neighbour skin in "
        "LAMMPS before 22 Jul 2025 Update 1",
    )
    torsion_reversed_at: Steps = Field(
        (),
        description="[step] springs of rolling and twisting change their sign, as a contact "
        "changes hands by a sort or between processors (LAMMPS)",
    )
    springs_lost_in_setup: bool = Field(
        False, description="[-] a later setup forgets tangential springs (LAMMPS, old restarts)"
    )
    wall_at_rest_in_setup: bool = Field(
        False, description="[-] a setup takes moving walls as at rest (LAMMPS, region walls)"
    )
    tsuji_again_in_setup: bool = Field(
        False, description="[-] a later setup takes alpha(e) of tsuji for e (LAMMPS, walls)"
    )
    setup_torque: Vector = Field(
        ZERO,
        description="[N m] added to the first body in the first setup, of memory that was never "
        "set (LAMMPS 2023, 2024: rolling at walls)",
    )
    cylinder_shear: Vector = Field(
        ZERO,
        description="[m/s] velocity of the surface of cylinders that turn, beside the turning "
        "(LAMMPS: fix wall/gran zcylinder shear)",
    )
    small_angle_quaternion: bool = Field(
        False,
        description="[-] turned_arms: arms turn by the quaternion (1 + t^2/2, t - t^3/6), t half "
        "the angle, whose cosine is 1 - t^2/2 (Kratos, GeometryFunctions.h)",
    )
    mdr_damping_interchanged: bool = Field(
        False,
        description="[-] the dashpot of mdr has twice, at a wall half of its value (LAMMPS 2025)",
    )
    mdr_sticking_share: float = Field(
        1.0,
        gt=0.0,
        le=1.0,
        description="[-] of mdr's contact radius that sticks (LAMMPS 2025: 0.99)",
    )
    mdr_newton_error: float = Field(
        0.0, ge=0.0, description="[m] at which mdr's search of the sticking radius ends (1e-10)"
    )
    mdr_parts_at_zero: bool = Field(
        False, description="[-] adhesion of mdr has no neck (LAMMPS 2025)"
    )
