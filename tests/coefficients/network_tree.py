"""A file with every key of a network, and changes to it."""

from __future__ import annotations

import copy
import json
from functools import reduce
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from gen.coefficients import parse
from gen.coefficients.schema import STORED
from gen.errors import InputError
from tests.coefficients.test_coefficients_errors import DELETE

Path_ = tuple[str | int, ...]
TREE: dict[str, Any] = json.loads((Path(__file__).parent / "version2" / "network_every_key.json").read_text())
SCHEMA = jsonschema.Draft202012Validator(json.loads(STORED.read_text(encoding="utf-8")))

NODES, PATHS, HEATS, CHANNELS = (("network", key) for key in ("nodes", "paths", "heats", "channels"))
G = "conductance_W_per_K"


def changed(*changes: tuple[Path_, object]) -> dict[str, Any]:
    tree: Any = copy.deepcopy(TREE)
    for (*where, last), value in changes:
        holder = reduce(lambda node, step: node[step], where, tree)
        if value is DELETE:
            del holder[last]
        else:
            holder[last] = value
    return dict(tree)


def failure(tree: object) -> InputError:
    with pytest.raises(InputError) as caught:
        parse(json.dumps(tree).encode())
    return caught.value


def poly(*coefficients: float) -> dict[str, Any]:
    return {"poly": list(coefficients)}


def factor(**table: list[float]) -> dict[str, Any]:
    return {"channel": "fan_rpm", "table": table}
