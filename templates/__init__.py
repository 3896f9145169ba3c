"""Jinja templates of the emitted project: the folder mirrors the emitted tree."""
