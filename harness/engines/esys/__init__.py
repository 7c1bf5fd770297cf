"""ESyS-Particle, run as a program under an MPI launcher."""
