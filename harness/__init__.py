"""Check discrete element (DEM) codes against theory.

The verbs of the command line are functions in :mod:`harness.workflows`; laws and scenes are in
:mod:`harness.model`, the parameters of a case in its module.
"""

__version__ = "1.0.0"
