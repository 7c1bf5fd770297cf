"""A grain dropped on one fixed sphere of its size: every engine qualifies by it."""
