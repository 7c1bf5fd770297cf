"""Contacts of one or two spheres, each law in each system held against the reference."""
