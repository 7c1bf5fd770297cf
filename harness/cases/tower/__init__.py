"""The tower: a grain dropped on a row of particles at rest."""
