"""Quantities of a run, independent of the code that made it. No files, no processes."""
