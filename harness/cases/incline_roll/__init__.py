"""A sphere that rolls or slides down an incline."""
