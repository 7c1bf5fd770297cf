"""A rigid grain over a row of rigid spheres, from event to event: no step and no stiffness."""
