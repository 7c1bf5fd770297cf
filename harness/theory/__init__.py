"""Closed forms. They share no code with what is held against them."""
