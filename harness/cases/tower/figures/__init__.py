"""Figures of the tower."""
