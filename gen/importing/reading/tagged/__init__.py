"""Readings that come one by one, each with tags that say whose it is, to one table."""
