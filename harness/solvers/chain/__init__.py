"""Rows of elastic particles: which of them touch, and their motion by RK4 or exactly."""
