"""What is raised where nothing can be proven."""

from __future__ import annotations


class NoProofError(Exception):
    """Nothing could be proven; the message says why.

    No invariant polytope was found (the switching may be unstable, or the directions too coarse), or what it gives is
    too large for the words.
    """
