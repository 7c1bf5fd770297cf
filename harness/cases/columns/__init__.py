"""Columns: the incline's grain over columns of particles that give way."""
