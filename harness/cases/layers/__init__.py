"""Layers of frictionless spheres on a tilted rough base."""
