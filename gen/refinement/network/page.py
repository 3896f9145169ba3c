"""The story of a network's refinement as one HTML page."""

from __future__ import annotations

from gen.coefficients import Coefficients
from gen.refinement.network.refine import NetworkRefinement


def network_refinement_page(found: NetworkRefinement, baseline: Coefficients, refined: Coefficients) -> str:
    """Render the report.

    Parameters
    ----------
    found
        What was found.
    baseline, refined
        The file that it began with, and the one that it led to.
    """
    return ""
