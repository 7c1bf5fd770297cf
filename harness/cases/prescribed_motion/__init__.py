"""Forces along a given motion: the law alone, without an integrator."""
