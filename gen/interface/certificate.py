"""The proof of an emitted project by what did not emit it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from gen.errors import CheckFailed
from gen.interface.arguments import a_path
from gen.interface.model import Model
from gen.interface.threads import one_thread

if TYPE_CHECKING:
    from gen.certificate.document import AnyCertificate
    from gen.certificate.network.document import NetworkCertificate


@dataclass(frozen=True)
class ProvenPart:
    """What holds for one component.

    Parameters
    ----------
    name
        The component.
    bound_K
        Largest error of the model's own word, K.
    reading_K
        Largest error of what the library gives out, in thousandths of a kelvin, K.
    """

    name: str
    bound_K: float
    reading_K: float


@dataclass(frozen=True)
class Check:
    """What a check proved.

    Parameters
    ----------
    parts
        Every component with a claim.
    unproven
        Components that claim nothing: they saturate instead.
    inequalities
        How many inequalities were decided.
    """

    parts: tuple[ProvenPart, ...]
    unproven: tuple[str, ...]
    inequalities: int


def check(
    folder: Path | str,
    *,
    coefficients: Model | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Check:
    """Prove an emitted project's error bounds anew, from its C++ and its certificate alone.

    Parameters
    ----------
    folder
        What `gen.build` wrote.
    coefficients
        The model that it was built from: then its equations must be those of the certificate.
    progress
        Called with the name of each component.

    Raises
    ------
    InputError
        If a file is missing or is not what `gen.build` writes, or a tool is missing.
    CheckFailed
        If a claim does not follow.

    Examples
    --------
    >>> import gen
    >>> [part.name for part in gen.check("firmware_out").parts]
    ['brush', 'bearing', 'magnet', 'casing']
    """
    from gen.certificate.document import read

    place = a_path("folder", folder)
    certificate = read(place)  # what is quick to tell is told before anything slow is imported
    if coefficients is not None:
        _check_statement(certificate, coefficients)
    return _proven(place, certificate, progress)


@one_thread
def _proven(place: Path, certificate: AnyCertificate, progress: Callable[[str], None]) -> Check:
    """Prove every claim."""
    from gen.certificate.check import check as run
    from gen.certificate.claims import Claims

    claims = Claims.of(place, certificate)
    verdicts = run(place, certificate, progress)
    claims.check(verdicts)
    claimed = {part.name for part in certificate.parts}
    return Check(
        tuple(ProvenPart(v.name, float(v.bound_K), float(v.reading_K)) for v in verdicts),
        tuple(part.name for part in certificate.components if part.name not in claimed),
        sum(v.inequalities for v in verdicts),
    )


def _check_statement(certificate: AnyCertificate, coefficients: Model) -> None:
    """Whether a certificate is about a coefficient file's own equations."""
    from gen.certificate.document import Ambient, Equation
    from gen.certificate.exact import Ratio
    from gen.certificate.network.document import NetworkCertificate
    from gen.firmware.certificate import ambient_of, equations

    model = coefficients.coefficients.model
    if (certificate.model, certificate.domain_pwm) != (model.name, model.domain_pwm):
        raise CheckFailed("the certificate is about another model or domain")
    if certificate.sample_time_s != Ratio(model.sample_time):
        raise CheckFailed("the certificate is about another sample time")
    if isinstance(certificate, NetworkCertificate) != (model.network is not None):
        raise CheckFailed("the certificate is about another kind of model")
    if isinstance(certificate, NetworkCertificate):
        _check_network(certificate, coefficients)
        return
    stated = ambient_of(coefficients.coefficients)
    if certificate.ambient != (Ambient.model_validate(stated) if stated is not None else None):
        raise CheckFailed("the certificate is about another ambient")
    expected = equations(coefficients.coefficients)
    if [part.name for part in certificate.components] != list(expected):
        raise CheckFailed("the certificate is about other components")
    for part in certificate.parts:
        if part.equation != Equation.model_validate(expected[part.name]):
            raise CheckFailed(f"the certificate is about another equation of {part.name}")


def _check_network(certificate: NetworkCertificate, coefficients: Model) -> None:
    """The same of a network."""
    from gen.firmware.network_certificate import network_statement

    expected = network_statement(coefficients.coefficients)
    for key, found in certificate.statement().items():
        if found != expected[key]:
            raise CheckFailed(f"the certificate is about other {key}")
