"""The incline: a grain moves over a row of fixed spheres; the smallest angle of steady motion."""
