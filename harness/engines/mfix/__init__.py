"""MFiX-DEM, which a user builds: its inputs, its output, and runs of it that were recorded."""
