"""Refinement of a network: effects are its terms, fitted together with it."""
