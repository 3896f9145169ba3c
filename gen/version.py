"""The version: it stands in pyproject.toml, and is written into everything that is emitted."""

from importlib.metadata import version

__version__ = version("gen-thermal")
