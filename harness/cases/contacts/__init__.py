"""Contacts of one or two spheres, each law in each system compared with the reference."""
