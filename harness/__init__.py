"""Check discrete element (DEM) codes against theory.

The verbs of the command line are functions in :mod:`harness.workflows`, what they
run is described by :mod:`harness.parameters`.
"""

__version__ = "1.0.0"
