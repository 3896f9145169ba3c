"""The MY1016: its coefficient file, and the study that identified it."""
