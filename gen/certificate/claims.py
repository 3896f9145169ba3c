"""What the project says elsewhere of its errors: none of it may promise more than was proven."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from gen.certificate.document import AnyCertificate
from gen.certificate.exact import Ratio
from gen.certificate.network.document import NetworkCertificate
from gen.certificate.refuted import Refuted
from gen.certificate.verdict import Verdict
from gen.errors import InputError

_COMMENT = re.compile(r"^// (\w+), proven for every sequence of PWM:.*?never more than ([\d.e+-]+) K", re.M | re.S)


@dataclass(frozen=True)
class Claims:
    """Bounds of components by name, K, as each place has them."""

    places: dict[str, dict[str, Ratio]]

    @classmethod
    def of(cls, folder: Path, certificate: AnyCertificate) -> Claims:
        """What the manifest says, and the comments in the C++ of transfer functions.

        Raises
        ------
        InputError
            If one cannot be read.
        """
        manifest, model = {"manifest.json": _manifest(folder / "manifest.json")}, certificate.model
        if isinstance(certificate, NetworkCertificate):
            return cls(manifest)
        step = folder / "lib" / model / "src" / f"{model}_step.h"
        try:
            text = step.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise InputError(f"cannot be read: {error}", file=str(step)) from error
        comments = {name: Ratio(bound) for name, bound in _COMMENT.findall(text)}
        return cls({**manifest, step.name: comments})

    def check(self, verdicts: Sequence[Verdict]) -> None:
        """Compare all of them with what was proven.

        Raises
        ------
        Refuted
            If one claims less than what was proven, or says nothing.
        """
        for part in verdicts:
            for where, claims in self.places.items():
                claimed = claims.get(part.name)
                if claimed is None:
                    raise Refuted(f"{part.name}: {where} claims nothing")
                if claimed < part.proven_K:
                    found, proven_K = float(claimed), float(part.proven_K)
                    raise Refuted(f"{part.name}: {where} claims {found:.6g} K, proven are {proven_K:.6g} K")


def _manifest(path: Path) -> dict[str, Ratio]:
    try:
        components = json.loads(path.read_text(encoding="utf-8"))["components"]
        return {part["name"]: Ratio(part["proof"]["bound_K"]) for part in components if part["proof"] is not None}
    except (OSError, ValueError, KeyError, TypeError, OverflowError) as error:
        raise InputError(f"is not what `gen build` writes: {error}", file=str(path)) from error
