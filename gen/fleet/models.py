"""Where a fleet's coefficient files are in its store, and which of them are in use."""

from __future__ import annotations

from collections.abc import Iterable

from gen.fleet.store import MODELS, Store

REFINED = "refined"
"""Files with what `gen fleet refine` found: in use in the place of those in `models`."""
COMMON = f"{MODELS}/common.json"
"""Of the fleet's mean."""


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


def identified_models_of(store: Store, motors: Iterable[str]) -> dict[str, bytes]:
    """Give the coefficient file of each motor that has one, as it was identified."""
    return {motor: store.read(model_path(motor)) for motor in with_model(store, motors)}


def with_model(store: Store, motors: Iterable[str]) -> list[str]:
    """Give those motors that were identified."""
    there = set(store.names(MODELS))
    return [motor for motor in motors if model_path(motor).removeprefix(f"{MODELS}/") in there]


def write_identified(store: Store, path: str, text: str) -> None:
    """Write a file that was identified; what was found beside the one before goes first, lest it stays in use."""
    store.remove(refined_path(path))
    store.write(path, text.encode())
