"""Cases: what is simulated, read and judged; one folder a case."""
