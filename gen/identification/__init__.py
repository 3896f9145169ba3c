"""Identification: from measured runs to a model, with evidence that it is good enough.

Runs are read and condensed (`logs`); a motor is identified part by part (`parts`) or as one thermal network
(`network`), and which of them is better is decided by the error on what was left out (`choice`).
"""
