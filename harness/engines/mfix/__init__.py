"""MFiX-DEM, which a user builds: its inputs, its runs, its output."""
