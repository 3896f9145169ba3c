"""The bounds of the emitted library, proven anew from its C++ (:mod:`gen.certificate`)."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from gen.certificate.check import check
from gen.certificate.document import read
from gen.certificate.refuted import Refuted
from gen.coefficients import Coefficients
from gen.firmware.certificate import CERTIFICATE, certificate_json
from gen.lowering.program import Program


@dataclass(frozen=True)
class ProofResult:
    """What the certificate's check found.

    Attributes
    ----------
    proven_K
        By component, the largest error of its word that follows from the C++, K.
    inequalities
        How many were decided.
    refuted
        The step that does not follow, or None.
    """

    proven_K: dict[str, float] = field(default_factory=dict)
    inequalities: int = 0
    refuted: str | None = None


def proof_of(coefficients: Coefficients, program: Program, folder: Path) -> ProofResult:
    """Check the certificate of an emitted library.

    Parameters
    ----------
    coefficients, program
        What was emitted.
    folder
        The project that holds the library, to which its certificate is added.
    """
    (folder / CERTIFICATE).write_text(certificate_json(coefficients, program), encoding="utf-8")
    try:
        verdicts = check(folder, read(folder))
    except Refuted as refuted:
        return ProofResult(refuted=str(refuted))
    return ProofResult(
        {verdict.name: float(verdict.proven_K) for verdict in verdicts},
        sum(verdict.inequalities for verdict in verdicts),
    )
