"""Logs as they are: what of them is believed, what room they were in, and what they come to, condensed."""
