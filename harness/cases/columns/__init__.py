"""The case columns: the grain of the incline over columns of particles that give way."""
