"""Reading a coefficient file."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from gen.coefficients import jsontext
from gen.coefficients.checks.alarm_checks import check_alarms
from gen.coefficients.checks.effect_checks import check_runaway
from gen.coefficients.checks.model_checks import check_model
from gen.coefficients.checks.network_checks import check_network
from gen.coefficients.checks.wiring_checks import check_wiring
from gen.coefficients.convert import to_model
from gen.coefficients.document import Accuracy, Document
from gen.coefficients.messages import described, first_fault
from gen.coefficients.protecting import protections
from gen.coefficients.versions import Tree, migrated
from gen.errors import InputError
from gen.model.dynamics import ThermalModel
from gen.model.effects import Applied
from gen.model.extended import fold


@dataclass(frozen=True)
class Coefficients:
    """A coefficient file that has passed every check.

    Parameters
    ----------
    document
        The file's content, typed.
    model
        The thermal model that it describes, with those effects that are mere changes of its entries.
    effects
        The effects that need a state or a channel of their own.
    warnings
        What is allowed and yet worth a look, one sentence each.
    sha256
        Hash of the file's bytes, hexadecimal.
    """

    document: Document
    model: ThermalModel
    warnings: tuple[str, ...]
    sha256: str
    effects: tuple[Applied, ...] = ()

    @property
    def name(self) -> str:
        """The model's name."""
        return self.document.name

    @property
    def accuracy(self) -> Accuracy:
        """The accepted errors in K."""
        return self.document.accuracy


def load(path: Path | str) -> Coefficients:
    """Read and check a coefficient file.

    Parameters
    ----------
    path
        The JSON file.

    Raises
    ------
    InputError
        With the file, the JSON path (or line and column), what was found and what was expected.
    """
    try:
        raw = _read(Path(path))
        return parse(raw)
    except InputError as error:
        raise InputError(error.message, file=str(path), place=error.place) from error


def check_form(path: Path | str) -> None:
    """Check a coefficient file's form and references only, which is quick; :func:`load` checks all.

    Parameters
    ----------
    path
        The JSON file; what is no file to be opened twice, such as a pipe, is left to its reader.

    Raises
    ------
    InputError
        As :func:`load`.
    """
    if Path(path).exists() and not Path(path).is_file() and not Path(path).is_dir():
        return
    try:
        parse_document(_read(Path(path)))
    except InputError as error:
        raise InputError(error.message, file=str(path), place=error.place) from error


def parse(raw: bytes) -> Coefficients:
    """Check the bytes of a coefficient file, as :func:`load` does.

    Raises
    ------
    InputError
        Without a file name.
    """
    document = parse_document(raw)
    model, effects = fold(to_model(document), [entry.applied() for entry in document.effects])
    checked = check_model(model) if model.network is None else check_network(model)
    warnings = checked + check_alarms(document) + check_wiring(document)
    check_runaway(document, model, effects)
    protections(document)
    return Coefficients(document, model, warnings, hashlib.sha256(raw).hexdigest(), effects)


def parse_document(raw: bytes) -> Document:
    """Check form and references only, not the model's physics.

    Raises
    ------
    InputError
        Without a file name.
    """
    tree = read_tree(raw)
    newest = migrated(tree)
    try:
        return Document.model_validate(newest)
    except ValidationError as error:
        fault = first_fault(error)
        if newest | {"version": None} == tree | {"version": None}:
            raise fault from error  # nothing was moved: the place is the file's own
        brought = f"(the place is that of version {newest['version']}, to which this file was brought)"
        raise InputError(f"{fault.message} {brought}", place=fault.place) from error


def read_tree(raw: bytes) -> Tree:
    """Read the bytes of a file as strict JSON, of whatever version and not yet checked.

    Raises
    ------
    InputError
        Without a file name.
    """
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise InputError(
            f"byte 0x{raw[error.start]:02x} is not UTF-8; expected a UTF-8 text", place=f"line {line}"
        ) from error
    if not text.strip():
        raise InputError("the file is empty; expected a coefficient file")
    tree = jsontext.parse(text)
    if not isinstance(tree, dict):
        raise InputError(f"found {described(tree)}, expected an object {{...}}", place="$")
    return tree


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise InputError("there is no such file; expected a coefficient file") from None
    except IsADirectoryError:
        raise InputError("this is a directory; expected a coefficient file") from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}") from None
