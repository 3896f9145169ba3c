"""What else is known of a motor: its supplier, the batch of its sensors; words under keys, kept for each motor."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence

from gen.errors import InputError
from gen.fleet.folder.names import shown
from gen.fleet.folder.store import Store

FOLDER = "labels"
MOST = 32
"""Labels of one motor."""
_WORD = r"[A-Za-z0-9](?:[A-Za-z0-9._-]{0,62}[A-Za-z0-9_-])?"
_LABEL = re.compile(rf"({_WORD})=({_WORD})?", re.ASCII)

Labels = dict[str, str]
"""Values by their keys."""


def parse_labels(texts: Sequence[str]) -> Labels:
    """Read labels as users write them; an empty value takes one away.

    Parameters
    ----------
    texts
        Each `KEY=VALUE`, as an ID of a motor is written on either side.

    Raises
    ------
    InputError
        When one is none, or a key is there twice.
    """
    found: Labels = {}
    for text in texts:
        match = _LABEL.fullmatch(text)
        if match is None:
            raise InputError(
                f"found {shown(text)}, expected KEY=VALUE, on each side 1 to 64 letters, digits, '.', '_' and '-', "
                "a letter or digit first, no '.' last; nothing after the '=' takes the label away",
                place="--label",
            )
        if match[1] in found:
            raise InputError(f"{match[1]} is given twice", place="--label")
        found[match[1]] = match[2] or ""
    return found


def add_labels(store: Store, motor: str, new: Mapping[str, str]) -> list[str]:
    """Give a motor labels in the place of those under the same keys.

    Returns
    -------
    list of str
        What has changed, in words.

    Raises
    ------
    InputError
        When the motor would have more than :data:`MOST`, or what is there cannot be read.
    """
    before = read_labels(store, motor)
    after = {key: value for key, value in sorted({**before, **new}.items()) if value}
    if len(after) > MOST:
        raise InputError(f"{motor} would have {len(after)} labels, expected {MOST} at most", place="--label")
    if after != before:
        store.write(_path(motor), (json.dumps(after, indent=1) + "\n").encode())
    return [_change(key, before.get(key), value) for key, value in sorted(new.items()) if before.get(key, "") != value]


def read_labels(store: Store, motor: str) -> Labels:
    """Give a motor's labels; none where it has no file.

    Raises
    ------
    InputError
        When the file is not what :func:`add_labels` writes.
    """
    return _read(store, motor) if store.exists(_path(motor)) else {}


def labels_of(store: Store, motors: Iterable[str]) -> dict[str, Labels]:
    """Give the labels of many motors, by one listing."""
    there = set(store.names(FOLDER))
    return {motor: _read(store, motor) if f"motor={motor}.json" in there else {} for motor in motors}


def _read(store: Store, motor: str) -> Labels:
    try:
        said = json.loads(store.read(_path(motor)))
        return parse_labels([f"{key}={value}" for key, value in said.items()])
    except (ValueError, AttributeError, InputError) as error:
        raise InputError(f"is no file of labels: {error}", file=f"{store.url}/{_path(motor)}") from error


def _path(motor: str) -> str:
    return f"{FOLDER}/motor={motor}.json"


def _change(key: str, before: str | None, value: str) -> str:
    if not value:
        return f"{key}={before} taken away"
    return f"{key}={value}" if before is None else f"{key}={value}, before {before}"
