"""Yade as an engine: it runs a generated script in its own Python."""
