"""Writing a coefficient file: a new one from a document, or a file that is there with parts added.

The layout is one for all: a key a line, one space for each level, numbers as short as they read back the same. What
was not said is not written. A file that is extended keeps what its author wrote: the order of keys and the form of
numbers. What is written is of the newest version.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from gen.coefficients.base import Part
from gen.coefficients.document import Document
from gen.coefficients.effects import EffectEntry
from gen.coefficients.network import NetworkEntry
from gen.coefficients.provenance import ErrorBand
from gen.coefficients.reader import read_tree
from gen.coefficients.rules import RuleDraft, Rules
from gen.coefficients.versions import Tree, migrated
from gen.coefficients.wiring import Wiring


def dump(document: Document) -> str:
    """Give the text of a document.

    Parameters
    ----------
    document
        What was set in it is written, also where it is what would hold without it; the rest is not.
    """
    return _text(as_json(document))


def with_effects(text: str, effects: Sequence[EffectEntry]) -> str:
    """Give the text of a file with effects added to those that it has.

    Raises
    ------
    InputError
        When the text is no coefficient file; what it says is not checked.
    """
    tree = _source(text)
    if effects:
        tree["effects"] = [*tree.get("effects", []), *(as_json(effect) for effect in effects)]
    return _text(tree)


def with_network(text: str, network: NetworkEntry, said: str, ambient: str | None = None) -> str:
    """Give the text of a file with another network in the place of its own.

    Parameters
    ----------
    text
        The file.
    network
        The network.
    said
        Where it comes from: added to what the file says of its method.
    ambient
        The column of the ambient that the file is to read from now on; None for what it says.

    Raises
    ------
    InputError
        When the text is no coefficient file; what it says is not checked.
    """
    tree = _source(text)
    tree["network"] = as_json(network)
    if ambient is not None:
        tree["ambient"] = {**tree["ambient"], "channel": ambient}
    provenance = dict(tree.get("provenance") or {"source": "gen refine"})
    provenance["method"] = "; ".join(part for part in (provenance.get("method", ""), said) if part)
    tree["provenance"] = provenance
    return _text(tree)


def in_place_of_parts(text: str, network: str) -> str:
    """Give the text of a file with a network in the place of its transfer functions.

    Name, input, ambient, domain, wiring, rules and all else that a bench has stay the file's; what belongs to a model
    (its validity, the error up to which it is built, where it comes from) is the network's.

    Parameters
    ----------
    text
        The file with transfer functions.
    network
        The file of a network with the same parts.

    Raises
    ------
    InputError
        When either text is no coefficient file; what it says is not checked.
    """
    tree, other = _source(text), _source(network)
    made: Tree = {}
    for key, value in tree.items():
        if key == "components":
            made["network"] = other["network"]
        elif key in ("validity", "accuracy", "provenance"):
            made[key] = other[key]
        elif key != "effects":
            made[key] = value
    made["ambient"] = {key: value for key, value in made["ambient"].items() if key != "at_once"}
    return _text({**made, **{key: other[key] for key in ("accuracy", "provenance") if key not in made}})


def with_rules(text: str, rules: Rules, alarms: Sequence[RuleDraft], error: Sequence[ErrorBand], source: str) -> str:
    """Give the text of a file with alarm rules, and the error bands that they count from, in the place of its own.

    Parameters
    ----------
    text
        The file.
    rules
        The rules file: its name, description and wiring, where it has them, take the place of the file's.
    alarms
        Its rules with all their numbers.
    error
        All bands.
    source
        What is named as the source of a file without provenance.

    Raises
    ------
    InputError
        When the text is no coefficient file; what it says is not checked.
    """
    tree = _source(text) | dict(rules.taken_over)
    if tree.get("provenance") is None:
        tree["provenance"] = {"source": source}
    tree["provenance"]["error"] = [as_json(band) for band in error]
    tree["alarms"] = [dict(rule.written) for rule in alarms]
    return _text(tree)


def with_start(text: str, wiring: Wiring | None, alarms: Sequence[RuleDraft] | None) -> str:
    """Give the text of a file with wiring and alarm rules that it had not; None adds nothing.

    Raises
    ------
    InputError
        When the text is no coefficient file; what it says is not checked.
    """
    tree = _source(text)
    if wiring is not None:
        tree["wiring"] = as_json(wiring)
    if alarms is not None:
        tree["alarms"] = [dict(rule.written) for rule in alarms]
    return _text(tree)


def rules_text(wiring: Wiring, alarms: Sequence[RuleDraft]) -> str:
    """Give the text of a rules file, as :func:`gen.coefficients.rules.read_rules` reads it."""
    return _text({"wiring": as_json(wiring), "alarms": [dict(rule.written) for rule in alarms]})


def as_json(part: Part) -> Tree:
    """Give a part of a document as its JSON has it, keys in the format's order.

    Parameters
    ----------
    part
        What was not set in it is left out, and so is null where a missing key means the same.
    """
    made = {}
    for key, field in type(part).model_fields.items():
        value = getattr(part, key)
        if key in part.model_fields_set and (value is not None or field.default is not None):
            made[key] = _plain(value)
    return made


def _plain(value: Any) -> Any:  # noqa: ANN401
    if isinstance(value, Part):
        return as_json(value)
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    return value


def _source(text: str) -> Tree:
    return migrated(read_tree(text.encode()))


def _text(tree: Tree) -> str:
    return json.dumps(tree, indent=1, ensure_ascii=False) + "\n"
