"""A DEM in sixty lines, as an engine of dem-harness."""
