"""A sphere meets a wall or another sphere head-on: normal force and damping alone."""
