"""DEM codes behind one contract: write, execute, read."""
