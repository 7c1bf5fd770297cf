"""LAMMPS's own granular tests (``unittest/granular``), judged in any release at equal steps."""
