"""What is run: frozen, validated, SI."""
