"""Version, licence and origin: they stand in pyproject.toml alone, and are written into what is emitted."""

from __future__ import annotations

from importlib.metadata import metadata, version

_ABOUT = metadata("gen-thermal")

__version__ = version("gen-thermal")
LICENSE: str = _ABOUT["License-Expression"]
"""SPDX identifier, which holds for the emitted code as well."""
AUTHORS = "the gen authors"
"""As the licence's text names them."""
REPOSITORY = next(
    (url.partition(",")[2].strip() for url in _ABOUT.get_all("Project-URL", []) if url.startswith("Repository,")), ""
)
"""`Repository` of `[project.urls]`; empty where the package states none."""
