"""Contacts with friction, integrated from their laws: adaptive, events located, no time step."""
