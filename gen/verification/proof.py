"""The bounds of the emitted library, proven anew from its C++ (:mod:`gen.certificate`)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from gen.certificate.check import check
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


def proof_of(coefficients: Coefficients, program: Program, files: Mapping[str, str], folder: Path) -> ProofResult:
    """Check the certificate of an emitted library.

    Parameters
    ----------
    coefficients, program
        What was emitted.
    files
        The library's files, by path within a project.
    folder
        Where there is room for them.
    """
    project = folder / "certified"
    for path, text in {**files, CERTIFICATE: certificate_json(coefficients, program)}.items():
        target = project / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")
    try:
        _, verdicts = check(project)
    except Refuted as refuted:
        return ProofResult(refuted=str(refuted))
    return ProofResult(
        {verdict.name: float(verdict.proven_K) for verdict in verdicts},
        sum(verdict.inequalities for verdict in verdicts),
    )
