"""What a proof gives."""

from __future__ import annotations

from dataclasses import dataclass

from gen.certificate.exact import Ratio


@dataclass(frozen=True)
class Verdict:
    """What was proven of one component.

    Attributes
    ----------
    name
        The component.
    bound_K, reading_K
        What is claimed: largest error of the word that is read, and of ``NAME_rise_mK``.
    proven_K
        What follows for the word.
    inequalities
        How many inequalities were decided.
    """

    name: str
    bound_K: Ratio
    reading_K: Ratio
    proven_K: Ratio
    inequalities: int
