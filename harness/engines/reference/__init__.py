"""A reference DEM of the incline in compiled Python, independent of every DEM code."""
