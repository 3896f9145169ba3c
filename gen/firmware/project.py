"""Assemble the emitted PlatformIO project."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from gen.coefficients import Coefficients
from gen.coefficients.protecting import protections
from gen.errors import InputError
from gen.firmware import render
from gen.firmware.certificate import CERTIFICATE, certificate_json
from gen.firmware.context import LibraryContext, Names, project_context
from gen.firmware.contexts.identity import ROOM_degC
from gen.firmware.contexts.tests import tests_context
from gen.firmware.report import report_html
from gen.firmware.sketch.chip_checks import chip_checks
from gen.firmware.sketch.device import DeviceContext, device_context, sketch_files
from gen.firmware.wiring_svg import parts, wiring_svg
from gen.lowering.program import Program
from gen.version import AUTHORS, LICENSE, REPOSITORY, __version__

PROJECT = {
    "lib/NAME/LICENSE": "lib/model/LICENSE.j2",
    "lib/NAME/library.json": "lib/model/library.json.j2",
    "lib/NAME/library.properties": "lib/model/library.properties.j2",
    "lib/NAME/examples/Basic/Basic.ino": "lib/model/examples/Basic/Basic.ino.j2",
}
SKETCH = {
    "platformio.ini": "platformio.ini.j2",
    "README.md": "README.md.j2",
    "seal.py": "seal.py.j2",
}
TESTS = {
    "test/test_model/test_main.cpp": "test/test_model/test_main.cpp.j2",
    "test/test_model/vectors.h": "test/test_model/vectors.h.j2",
}
VERIFICATION = "verification.json"
REPORT = "report.html"
MANIFEST = "manifest.json"
WIRING = "wiring.svg"


def project_files(
    coefficients: Coefficients, program: Program, source_name: str, verification: Mapping[str, Any] | None
) -> dict[str, str]:
    """Every file of the project, by its path.

    Parameters
    ----------
    coefficients, program
        What is emitted.
    source_name
        The coefficient file's name as comments show it.
    verification
        What `gen verify` found for this coefficient file, or None.
    """
    library = project_context(coefficients, program, source_name)
    device = device_context(coefficients, program)
    files = render.library(library)
    about = {"license": LICENSE, "authors": AUTHORS, "repository": REPOSITORY}
    files |= render.render(PROJECT, {**library.of_model(), **about})
    files |= render.render(TESTS, {**library.of_model(), **tests_context(program)})
    files |= render.render(SKETCH | sketch_files(device), _of_sketch(coefficients, library, device))
    if parts(device):
        files[WIRING] = wiring_svg(f"Wiring of {program.model.name}", device)
    if verification is not None:
        files[VERIFICATION] = json.dumps(verification, indent=1) + "\n"
    files[CERTIFICATE] = certificate_json(coefficients, program)
    files[MANIFEST] = json.dumps(_manifest(coefficients, program, files), indent=1) + "\n"
    files[REPORT] = report_html(coefficients, program, verification)
    return files


def kept_verification(folder: Path, coefficients: Coefficients) -> dict[str, Any] | None:
    """The verification that an earlier build's folder holds, if it is about these coefficients and this version."""
    path = folder / VERIFICATION
    if not path.is_file():
        return None
    return read_verification(path, coefficients, strict=False)


def read_verification(path: Path, coefficients: Coefficients, *, strict: bool = True) -> dict[str, Any] | None:
    """Read what `gen verify --json` wrote.

    Raises
    ------
    InputError
        If the file cannot be read, or (when strict) is about other coefficients or another version.
    """
    try:
        record: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        matches = (
            record["coefficients_sha256"] == coefficients.sha256
            and record["tool"] == f"gen {__version__}"
            and isinstance(record["combinations"], list)
        )
    except (OSError, ValueError, TypeError, KeyError) as error:
        if not strict:
            return None
        raise InputError(f"is not what `gen verify --json` writes: {error}", file=str(path)) from error
    if not matches:
        if strict:
            raise InputError("is about another coefficient file or another version of gen", file=str(path))
        return None
    return record


def _of_sketch(coefficients: Coefficients, library: LibraryContext, device: DeviceContext) -> Names:
    """For the sketch and its README: the board, beside what the model's own templates are told."""
    ambient = coefficients.model.ambient_fixed
    return {
        **library.of_model(),
        **library.protection,
        "forecast": library.forecast,
        "device": {**device, "parts": parts(device)},
        **chip_checks(coefficients.model.sample_time),
        "ambient_given": ambient is not None,
        "ambient": f"{ambient if ambient is not None else ROOM_degC:g}",
    }


def _manifest(coefficients: Coefficients, program: Program, files: Mapping[str, str]) -> dict[str, Any]:
    unproven = {component.name: component.unproven for component in program.parts if component.saturates}
    return {
        "tool": f"gen {__version__}",
        "model": program.model.name,
        "coefficients_sha256": coefficients.sha256,
        "arithmetic": program.arithmetic,
        "schedule": program.schedule,
        "sample_time_s": program.model.sample_time,
        "domain_pwm": list(program.model.domain_pwm),
        "validity_pwm": list(program.model.validity),
        "components": [component.describe() for component in program.parts],
        **({"without_proof": unproven} if unproven else {}),
        **({"network": program.network.describe()} if program.network is not None else {}),
        **({"effects": program.effects.describe()} if program.effects is not None else {}),
        "wiring": _plain(coefficients.document.wiring),
        "alarms": [_plain(alarm) for alarm in coefficients.document.alarms],
        "protection": [_plain(entry) for entry in protections(coefficients.document)],
        "forecast": _plain(coefficients.document.forecast),
        "files": {
            path: hashlib.sha256(text.encode()).hexdigest()
            for path, text in sorted(files.items())
            if path != VERIFICATION
        },
    }


def _plain(part: BaseModel | None) -> dict[str, Any] | None:
    return part.model_dump(mode="json", exclude_none=True) if part is not None else None
