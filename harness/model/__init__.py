"""What is simulated: contact laws, scenes, conventions and known defects of codes, and motions."""
