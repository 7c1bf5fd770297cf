"""LAMMPS, in-process or as an executable."""
