"""Simulators that compute the same words as the board."""
