"""Frictionless layers on a rough incline: the angle of their stop, steady flow at one angle."""
