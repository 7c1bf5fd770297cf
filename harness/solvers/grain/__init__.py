"""A reference DEM of one grain in compiled Python, independent of every DEM code."""
