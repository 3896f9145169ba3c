"""Where a fleet's coefficient files are in its store, and which of them are in use."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from gen.coefficients import Coefficients, parse
from gen.errors import InputError
from gen.fleet.folder.store import MODELS, Store

REFINED = "refined"
"""Files with what `gen fleet refine` found: in use in the place of those in `models`."""
COMMON = f"{MODELS}/common.json"
"""Of the fleet's mean."""


@dataclass(frozen=True, eq=False)
class Model:
    """A motor's coefficient file, as written and as read."""

    text: str
    coefficients: Coefficients

    @property
    def hash(self) -> str:
        """What stands for it in a task's arguments."""
        return hashlib.sha256(self.text.encode()).hexdigest()


def model_path(motor: str) -> str:
    """Where in the store a motor's coefficient file is, as it was identified."""
    return f"{MODELS}/motor={motor}.json"


def refined_path(path: str) -> str:
    """Where the same file is with what was found."""
    return f"{REFINED}/{path.removeprefix(f'{MODELS}/')}"


def in_use(store: Store, path: str) -> str:
    """Give the refined file's path where there is one."""
    refined = refined_path(path)
    return refined if store.exists(refined) else path


def models_of(store: Store, motors: Iterable[str]) -> dict[str, bytes]:
    """Give the coefficient file in use of each motor that has one."""
    return {motor: store.read(path) for motor, path in paths_in_use(store, with_model(store, motors)).items()}


def paths_in_use(store: Store, motors: Iterable[str]) -> dict[str, str]:
    """Give the same as :func:`in_use` of many motors with a model, by one listing."""
    there = set(store.names(REFINED))
    paths = {motor: (model_path(motor), refined_path(model_path(motor))) for motor in motors}
    return {motor: new if new.removeprefix(f"{REFINED}/") in there else old for motor, (old, new) in paths.items()}


def identified_paths(store: Store, motors: Iterable[str]) -> dict[str, str]:
    """Give where the file of each motor that was identified is, as it was identified."""
    return {motor: model_path(motor) for motor in with_model(store, motors)}


def read_model(store: Store, path: str) -> Coefficients:
    """Read a coefficient file of the store.

    Raises
    ------
    InputError
        When it cannot be read or is none, with its name.
    """
    return _parsed(store, path, store.read(path))


def sound(store: Store, paths: Mapping[str, str]) -> tuple[dict[str, Model], dict[str, str]]:
    """Read motors' coefficient files: one that is broken costs a line.

    Returns
    -------
    models, broken
        By motor; of the broken ones why, with the file's name.
    """
    models, broken = {}, {}
    for motor, path in paths.items():
        try:
            text = store.read(path)
            models[motor] = Model(text.decode(errors="replace"), _parsed(store, path, text))
        except InputError as error:
            broken[motor] = str(error)
    return models, broken


def _parsed(store: Store, path: str, text: bytes) -> Coefficients:
    try:
        return parse(text)
    except InputError as error:
        raise InputError(error.message, file=f"{store.url}/{path}", place=error.place) from error


def with_model(store: Store, motors: Iterable[str]) -> list[str]:
    """Give those motors that were identified."""
    there = set(store.names(MODELS))
    return [motor for motor in motors if model_path(motor).removeprefix(f"{MODELS}/") in there]


def write_identified(store: Store, path: str, text: str) -> None:
    """Write a file that was identified; what was found beside the one before goes first, lest it stays in use."""
    store.remove(refined_path(path))
    store.write(path, text.encode())


def remove_identified(store: Store, path: str) -> None:
    """Remove a file that was identified, and what was found beside it."""
    store.remove(refined_path(path))
    store.remove(path)
