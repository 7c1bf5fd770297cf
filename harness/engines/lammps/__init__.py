"""LAMMPS, in-process or as an executable."""

DEFORMABLE = "deformable"  # the law that LAMMPS lacks, and calls back for: inprocess.py
