"""A spinning sphere meets a wall or another sphere along the normal: friction from spin alone."""
