"""What is known of MFiX-DEM: its step, and runs of it that were recorded."""
