"""LAMMPS's own tests of granular contacts, run in any release and held against the reference."""
