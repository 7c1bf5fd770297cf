"""A sphere that spins about the vertical on a floor or on a sphere."""
