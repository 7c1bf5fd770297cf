"""A sphere meets a wall or another sphere at an angle: friction over a whole contact."""
