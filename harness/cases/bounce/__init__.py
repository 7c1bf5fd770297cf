"""A sphere that falls on a floor and bounces, under gravity."""
