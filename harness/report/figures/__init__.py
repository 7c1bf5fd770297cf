"""Figures: pure functions from results to a matplotlib Figure."""
