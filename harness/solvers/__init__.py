"""Independent solvers: chains, contacts with friction, a grain on fixed spheres, rigid spheres."""
