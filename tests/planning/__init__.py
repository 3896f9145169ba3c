"""Tests of `gen.planning` and of `gen plan`."""
