"""Engines that stand in for others: the reference DEM under other names and traits."""

from __future__ import annotations

from dataclasses import replace

from harness.engines.reference.engine import Reference

TRAITS = replace(Reference.traits, install_hint="apt install it")


class Twin(Reference):
    """Runs jobs as the reference DEM does, in the scheme that it declares."""

    name = "twin"
    traits = replace(TRAITS, lineage="LAMMPS", caveats=("It grew out of LAMMPS.",))

    def __init__(self, program: str | None = None) -> None:
        super().__init__(self.traits.integrator)
        self.program = program


class Clamped(Twin):
    name = "clamped"
    traits = replace(TRAITS, tails=("clipped",), caveats=("It always clips.",))


class Half(Twin):
    """As MFiX: half the mass, the tail kept, semi-implicit Euler."""

    name = "half"
    traits = replace(
        TRAITS, tails=("attractive",), effective_masses=("half",), integrator="mfix-euler"
    )
