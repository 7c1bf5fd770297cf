"""Closed forms. They share no code with solvers."""
