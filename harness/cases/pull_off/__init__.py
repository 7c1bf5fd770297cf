"""A sphere that sticks to a wall or a sphere is pulled off."""
