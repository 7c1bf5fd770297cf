"""The tower: a grain that runs into a row of particles at rest."""
