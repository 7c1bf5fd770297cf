"""The frictionless incline: a grain slides over a row of fixed spheres."""
