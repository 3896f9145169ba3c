"""What the project says elsewhere of its errors: none of it may promise more than was proven."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Protocol

from gen.certificate.refuted import Refuted
from gen.errors import InputError

_COMMENT = re.compile(r"^// (\w+), proven for every sequence of PWM:(.*?)never more than ([\d.e+-]+) K", re.M | re.S)


class Proven(Protocol):
    """What was proven of a component."""

    @property
    def name(self) -> str:
        """The component."""
        ...

    @property
    def proven_K(self) -> Fraction:
        """The largest error of the word that is read."""
        ...


def check_claims(folder: Path, model: str, proven: Sequence[Proven]) -> None:
    """Compare the manifest and the comments in the C++ with what was proven.

    Raises
    ------
    InputError
        If the manifest cannot be read.
    Refuted
        If one claims less than what was proven, or says nothing.
    """
    in_manifest, in_comments = _manifest(folder / "manifest.json"), _comments(folder / "lib" / model / "src", model)
    for part in proven:
        for where, claims in (("manifest.json", in_manifest), (f"{model}_step.h", in_comments)):
            if part.name not in claims:
                raise Refuted(f"{part.name}: {where} claims nothing")
            if claims[part.name] < part.proven_K:
                claimed, proven_K = float(claims[part.name]), float(part.proven_K)
                raise Refuted(f"{part.name}: {where} claims {claimed:.6g} K, proven are {proven_K:.6g} K")


def _manifest(path: Path) -> dict[str, Fraction]:
    try:
        components = json.loads(path.read_text(encoding="utf-8"))["components"]
        return {part["name"]: Fraction(part["proof"]["bound_K"]) for part in components if part["proof"] is not None}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"is not what `gen build` writes: {error}", file=str(path)) from error


def _comments(folder: Path, model: str) -> dict[str, Fraction]:
    text = (folder / f"{model}_step.h").read_text(encoding="utf-8")
    return {name: Fraction(bound) for name, _, bound in _COMMENT.findall(text)}
