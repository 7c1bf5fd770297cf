"""A grain that meets one fixed sphere; engines qualify with it."""
