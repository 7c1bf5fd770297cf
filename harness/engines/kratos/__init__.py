"""Kratos DEM: generated scripts that any Python with Kratos runs, and their results."""
