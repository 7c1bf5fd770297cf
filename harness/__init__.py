"""Check discrete element (DEM) codes against theory."""

__version__ = "0.1.0"
