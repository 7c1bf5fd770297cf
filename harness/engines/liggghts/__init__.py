"""LIGGGHTS, as an executable."""
