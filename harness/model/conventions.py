"""Conventions in which codes differ on one contact law, and known defects of their releases.

Each field moves a result: its description gives formula, code and size, and
``tests/solvers/reference/test_conventions.py`` has a scene for each. Symbols: n normal, u slip
velocity, q spring, h step, w angular velocity, r radius, d overlap, M torque. Conventions that end
in a power of h have one limit of small steps; the others move the limit, by at most the number.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from harness.model.base import ZERO, Parameters, Vector

Mean = Literal["geometric", "arithmetic", "least"]
Steps = tuple[Annotated[int, Field(ge=0)], ...]
Walls = Literal["none", "walls", "all"]


class Rules(Parameters):
    """Conventions of a code; the defaults are those of LAMMPS's pair style granular."""

    # fmt: off
    scheme: Literal["velocity_verlet", "mfix_euler", "mfix_adams_bashforth"] = Field(
        "velocity_verlet", description="[-] v' = v + h/2 a, x+ = x + h v', a+ = a(x+, v'), "
        "v+ = v' + h/2 a+; or MFiX's EULER v+ = v + h a(x, v), x+ = x + h v+; or its "
        "ADAMS_BASHFORTH v+ = v + h/2 (3 a - a_before), x+ = x + h/2 (v + v+); h")
    restitution_mean: Mean = Field(
        "geometric", description="[-] e of two bodies: sqrt(e_i e_j) (LAMMPS), or (e_i + e_j) / 2 "
        "(Yade, ViscElMat); 1")
    friction_mean: Mean = Field(
        "geometric", description="[-] mu of two bodies: sqrt(mu_i mu_j) (LAMMPS), or the smaller "
        "one (Yade); 1")
    damping_in_cap: Literal["inside", "sticking_only"] = Field(
        "inside", description="[-] Coulomb's limit is for |k q + eta u|, or for |k q| with eta u "
        "while it sticks (LIGGGHTS, Yade); 1")
    slides_in_setup: bool = Field(
        False, description="[-] a dashpot beyond Coulomb's limit acts at the limit where a run "
        "begins and q = 0; else not at all in that setup (LAMMPS); h")
    torque_lever: Literal["radius", "contact_point"] = Field(
        "contact_point", description="[-] of friction between spheres: r - d/2, or r (LAMMPS's "
        "gran/*); d/r")
    velocity_lever: Literal["radius", "contact_point"] = Field(
        "radius", description="[-] of w in u between spheres: r, or r - d/2 (LIGGGHTS, Yade, "
        "Kratos); d/r")
    wall_lever: Literal["radius", "contact_point", "height"] = Field(
        "radius", description="[-] both at walls: r, r - d/2 (LIGGGHTS), r - d (Yade, Kratos); d/r")
    wall_spin: Literal["spin", "levered"] = Field(
        "spin", description="[-] of rolling and twisting at a wall: w, or (r - d/2) / (r - d) w "
        "(LIGGGHTS, epsd*); d/r")
    rolling_axis: Literal["across", "projected", "whole"] = Field(
        "across", description="[-] of the constant torque of rolling: w' / |w'|, w' across n; "
        "w' / |w| (LIGGGHTS, cdt); or w / |w| (Kratos, Yade); 1")
    rolling_load: Literal["normal", "elastic"] = Field(
        "normal", description="[-] of that torque: |F_n|, or the elastic force (LIGGGHTS, cdt); 1")
    rolling_lever: Literal["effective_radius", "shortened"] = Field(
        "effective_radius", description="[-] of that torque: R*, or R* l / r with the lever l of "
        "w in u (Kratos); d/r")
    frozen_mass: Literal["infinite", "own"] = Field(
        "infinite", description="[-] of a frozen partner in m*: infinite, or its own (MFiX); 1")
    wall_curvature: float = Field(
        0.0, ge=0.0, description="[1/r] c in R* = r / (1 + c) at a plane: 1e-8 (Yade, whose script "
        "takes walls as spheres of 1e8 r); c")
    least_overlap: float = Field(
        0.0, ge=0.0, lt=1.0, description="[-] of r_i + r_j: no contact up to this, 1e-15 (MFiX, "
        "SMALL_NUMBER); what rounding makes of bodies that just touch")
    wall_touches_at_zero: bool = Field(
        False, description="[-] a wall acts at d = 0 (LIGGGHTS, Yade; defect of LAMMPS 2022); h")
    bodies_touch_at_zero: bool = Field(
        False, description="[-] two spheres act at d = 0 (Yade); h")
    spring_frame: Literal["turned", "projected", "rotated", "finite_rotation"] = Field(
        "turned", description="[-] q before it grows: (1 - n n) q of the old length; after it: "
        "(1 - n n) q (LIGGGHTS; h^2); before it: q - q x (n_old x n), then turned by the mean "
        "spin, h/2 (w_i + w_j) n_old, about n_old (Yade); 1e-2; or R q with the rotation R from "
        "n_old to n (Kratos); h^2")
    torsion_frame: Literal["turned", "rotated", "room"] = Field(
        "turned", description="[-] of rolling and twisting springs: turned with n; rotated as q "
        "is (Yade); M + k R* h w in the room, not turned (LIGGGHTS, epsd*); 1e-3")
    slip_step: Literal["velocity", "turned_arms"] = Field(
        "velocity", description="[-] slip of a step: h u, or h (v_i - v_j) - (R(h w_i) - 1) r_i + "
        "(R(h w_j) - 1) r_j, arms turned by rotations R (Kratos); h^2")
    rescaled_from: Literal["last_radius", "displacement"] = Field(
        "last_radius", description="[-] mindlin_rescale: q a / a_last, or q sqrt(d / (d + n dx)) "
        "with the displacement dx of the step (Kratos, previous_indentation); h")
    looks_set_up: bool = Field(
        True, description="[-] velocity_verlet: forces are set up anew where a look ends a stage, "
        "or finds a body that moves back (LAMMPS, LIGGGHTS, whose run ends there); h")
    mdr_wall_force: Literal["plain", "magnified"] = Field(
        "magnified", description="[-] of mdr: F, or (1 + exp(10.7 d/r_0 - 10)) F (LAMMPS); 9e-4")
    mdr_growth: Literal["whole", "screened"] = Field(
        "screened", description="[-] of mdr's radii: by the volume, or times "
        "1 / (1 + exp(-75 (psi - 0.2))) and up to 1.5 r_0 (LAMMPS)")
    mdr_growth_steps: float = Field(
        10.0, ge=1.0, description="[step] over which growth is averaged: 10 (LAMMPS); h")


class Faults(Parameters):
    """Switches of known defects; without any a code follows its law and conventions."""

    # fmt: off
    tsuji_effective_mass: bool = Field(
        False, description="[-] tsuji has sqrt(m* F/d), not sqrt(2 m* F/d) (LAMMPS 2022-2025)")
    marshall_without_radius: bool = Field(
        False, description="[-] Marshall's spring beside Mindlin's is 8 G* a^2/2, not 8 G* a^3/2 "
        "(LAMMPS 2023-2025)")
    twisting_limit_by_rate: bool = Field(
        False, description="[-] a twisting torque at its limit has the sign of the rate (LAMMPS "
        "2022-2025)")
    tangential_radius: Walls = Field(
        "none", description="[-] where linear springs are k_t a q, a in m (LAMMPS 2023-2025: "
        "walls of the old styles, linear_history_classic)")
    cap_without_radius: Walls = Field(
        "none", description="[-] where Coulomb's limit leaves a q, a in m (LAMMPS 2023-2025: "
        "walls of the old styles, classic styles)")
    shear_factor: float = Field(
        1.0, gt=0.0, description="[-] on G* (LAMMPS 2023-2025: mixed materials)")
    wall_modulus_factor: float = Field(
        1.0, gt=0.0, description="[-] on E* at walls (LAMMPS 2022: 1 + nu)")
    wall_shear_factor: float = Field(
        1.0, gt=0.0, description="[-] on G* at walls (LAMMPS 2022: (2 - nu)^2 (1 + nu)^2 / 8)")
    dmt_limit_without_pull_off: bool = Field(
        False, description="[-] Coulomb's limit of dmt and jkr is mu |F| (LAMMPS 2022)")
    longest_neck: float | None = Field(
        None, ge=0.0, description="[m] of jkr, a longer one parts: 0 at region walls, and the "
        "skin of the neighbour list (LAMMPS before 22 Jul 2025 Update 1)")
    torsion_reversed_at: Steps = Field(
        (), description="[step] rolling and twisting springs change their sign, as a contact "
        "changes hands by sorting or between processors (LAMMPS)")
    springs_lost_in_setup: bool = Field(
        False, description="[-] a later setup forgets tangential springs (LAMMPS, old restarts)")
    parted_springs_kept: bool = Field(
        False, description="[-] two spheres that part and touch again have the springs of their "
        "last contact (LIGGGHTS, Kratos: until the next list of neighbours)")
    rolling_by_rate: bool = Field(
        False, description="[-] the constant torque of rolling is mu_r R* |F_n| w, w in rad/s "
        "(Yade, ViscoelasticPM.cpp: normalized() changes nothing)")
    forgets_setup: bool = Field(
        False, description="[-] the first force of a run stores no spring, yet its torques are M "
        "+ k R* h w (LIGGGHTS, rolling_model_epsd*.h)")
    wall_at_rest_in_setup: bool = Field(
        False, description="[-] setups take moving walls as at rest (LAMMPS, region walls)")
    tsuji_again_in_setup: bool = Field(
        False, description="[-] a later setup takes alpha(e) of tsuji for e (LAMMPS, walls)")
    setup_torque: Vector = Field(
        ZERO, description="[N m] on the first body in the first setup, of memory that was never "
        "set (LAMMPS 2023, 2024: rolling at walls)")
    later_setup_torque: Vector = Field(
        ZERO, description="[N m] likewise in later setups")
    cylinder_shear: Vector = Field(
        ZERO, description="[m/s] added to the surface of cylinders that turn (LAMMPS: fix "
        "wall/gran zcylinder shear)")
    small_angle_quaternion: bool = Field(
        False, description="[-] turned_arms: by the quaternion (1 + t^2/2, t - t^3/6) of half "
        "the angle t, whose cosine is 1 - t^2/2 (Kratos, GeometryFunctions.h)")
    discs_turn_as_spheres: bool = Field(
        False, description="[-] the moment of inertia of every body is 2/5 m R^2 (LAMMPS: fix "
        "nve/sphere/omp disc)")
    mdr_damping_interchanged: bool = Field(
        False, description="[-] mdr's dashpot times 2, at walls times 1/2 (LAMMPS 2025)")
    mdr_sticking_share: float = Field(
        1.0, gt=0.0, le=1.0, description="[-] of mdr's radius that sticks (LAMMPS 2025: 0.99)")
    mdr_newton_error: float = Field(
        0.0, ge=0.0, description="[m] that ends the search of mdr's sticking radius (LAMMPS: "
        "1e-10)")
    mdr_parts_at_zero: bool = Field(False, description="[-] mdr has no neck (LAMMPS 2025)")
    # fmt: on


def mean(kind: Mean, first: float | None, second: float | None) -> float | None:
    """Return a mean of two coefficients, the first where the second body has none of its own."""
    if first is None or second is None:
        return first
    if kind == "least":
        return min(first, second)
    return math.sqrt(first * second) if kind == "geometric" else 0.5 * (first + second)
