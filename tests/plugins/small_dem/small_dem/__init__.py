"""A small DEM, as an engine of dem-harness."""
