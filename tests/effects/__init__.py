"""Effects in the firmware."""
