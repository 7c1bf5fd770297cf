"""The chain of deformable particles: contact laws, RK4, exact propagator."""
