"""Two stacked spheres between plates."""
