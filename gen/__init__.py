"""From identified motor-temperature coefficients to proven firmware for the Arduino Mega 2560."""

from importlib.metadata import version

__version__ = version("gen-thermal")
"""Stands in pyproject.toml; written into everything that is emitted."""
