"""Networks made at random: what is written reads back as the same, and anything anywhere is taken or named."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gen.coefficients import dump, parse
from gen.errors import InputError
from tests.coefficients.network_tree import (
    SCHEMA,
    TREE,
    G,
    Path_,
    changed,
)

small = st.floats(0.0, 3.0, allow_nan=False)
at_rest = st.fixed_dictionaries({}, optional={"at_rest": small | st.none()})
tables = st.lists(st.integers(0, 200), min_size=2, max_size=5, unique=True).flatmap(
    lambda pwm: st.fixed_dictionaries(
        {
            "pwm": st.just(sorted(pwm)),
            "value": st.lists(small, min_size=len(pwm), max_size=len(pwm)),
            "interpolation": st.sampled_from(["pchip", "linear"]),
        }
    )
)
laws = st.fixed_dictionaries({"constant": small, "forced": small, "exponent": st.floats(0.1, 3.0)})
shapes = st.one_of(
    st.lists(st.floats(0.0, 1e-3), min_size=1, max_size=3).map(lambda c: {"poly": c}),
    st.tuples(small, st.floats(-0.02, 0.005)).map(lambda c: {"exp1": list(c)}),
    st.tuples(small, st.floats(-0.02, 0.005), small, st.floats(-0.02, 0.005)).map(lambda c: {"exp2": list(c)}),
    tables.map(lambda t: {"table": t}),
    laws.map(lambda p: {"power": p}),
)
curves = st.builds(lambda shape, rest: shape | rest, shapes, at_rest)
columns = st.lists(st.sampled_from(["fan_rpm", "current_A", "load_Nm", "flow"]), unique=True, max_size=3)
grids = st.lists(st.integers(-50, 50), min_size=2, max_size=5, unique=True).flatmap(
    lambda at: st.fixed_dictionaries(
        {"at": st.just(sorted(at)), "value": st.lists(st.floats(0.5, 2.0), min_size=len(at), max_size=len(at))}
    )
)


def factors(names: Sequence[str]) -> st.SearchStrategy[list[Any]]:
    if not names:
        return st.just([])
    channel = st.sampled_from(names).map(lambda name: {"channel": name})
    scaled = st.lists(st.floats(0.0, 1e-4), min_size=0, max_size=3).map(lambda c: {"poly": [*c, 1.0]})
    return st.lists(st.builds(lambda c, f: c | f, channel, scaled | grids.map(lambda t: {"table": t})), max_size=2)


@st.composite
def networks(draw: st.DrawFn) -> dict[str, Any]:
    """Connected networks with their last node tied to the ambient, and what else comes."""
    names = [f"part{k}" for k in range(draw(st.integers(1, 6)))]
    channels: list[dict[str, Any]] = [
        {"column": name, "range": [low, low + width], "neutral": low + width}
        for name in draw(columns)
        for low, width in [draw(st.tuples(st.integers(0, 50), st.integers(1, 50)))]
    ]
    with_factors = st.fixed_dictionaries({}, optional={"factors": factors([str(c["column"]) for c in channels])})
    sensor = st.fixed_dictionaries(
        {},
        optional={
            "offset_K": st.floats(-5, 5),
            "lag_s": st.just(0) | st.floats(5, 60),
            "gain_error": st.floats(-0.85, 2),
            "gain_about": st.sampled_from(["ambient", "zero_degC"]),
        },
    )
    about = st.fixed_dictionaries({}, optional={"description": st.text(max_size=9), "sensor": st.none() | sensor})
    nodes = [{"name": n, "capacity_J_per_K": draw(st.floats(2e3, 5e3))} | draw(about) for n in names]
    nodes[draw(st.integers(0, len(names) - 1))]["sensor"] = draw(sensor)
    tree = [(name, draw(st.sampled_from([*names[k + 1 :], "ambient"]))) for k, name in enumerate(names)]
    pairs = [(one, other) for k, one in enumerate(names) for other in [*names[k + 1 :], "ambient"]]
    others = [pair for pair in draw(st.lists(st.sampled_from(pairs), unique=True, max_size=4)) if pair not in tree]
    paths = [{"between": list(ends), G: {"poly": [draw(st.floats(0.1, 3.0))]}} | draw(with_factors) for ends in tree]
    paths += [{"between": draw(st.permutations(ends)), G: draw(curves)} | draw(with_factors) for ends in others]
    warm = st.fixed_dictionaries({}, optional={"per_K": st.floats(-1e-3, 1e-3), "reference_degC": st.floats(0, 40)})
    heats = [
        {"node": draw(st.sampled_from(names)), "power_W": draw(curves)} | draw(with_factors) | draw(warm)
        for _ in range(draw(st.integers(0, 3)))
    ]
    bare = draw(st.sampled_from([True, False]))  # an empty list may be left out
    return {"nodes": nodes, "paths": paths} | {
        key: part for key, part in (("channels", channels), ("heats", heats)) if part or not bare
    }


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(networks())
def test_a_network_survives_writing_and_reading(network: dict[str, Any]) -> None:
    tree = TREE | {"network": network}
    SCHEMA.validate(tree)
    try:
        loaded = parse(json.dumps(tree).encode())
    except InputError as error:  # heat and cooling are drawn apart from each other
        assert any(said in error.message for said in ("runs away", "settles", "follows its neighbours"))
        return
    text = dump(loaded.document)
    again = parse(text.encode())
    assert again.document == loaded.document
    assert again.model == loaded.model
    assert dump(again.document) == text
    said = json.loads(text)["network"]
    assert [node["name"] for node in said["nodes"]] == [node["name"] for node in network["nodes"]]
    assert [path["between"] for path in said["paths"]] == [path["between"] for path in network["paths"]]


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)


def places(node: object, path: Path_ = ()) -> list[Path_]:
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    below = [place for key, value in items for place in places(value, (*path, key))]
    return ([path] if path else []) + below


@settings(max_examples=300, deadline=None)
@given(st.sampled_from([place for place in places(TREE) if place[0] == "network"]), json_values)
def test_anything_anywhere_is_taken_or_named(where: Path_, value: object) -> None:
    """Whatever stands anywhere, the file loads or one InputError with a place says why not."""
    try:
        parse(json.dumps(changed((where, value))).encode())
    except InputError as error:
        assert error.place
        assert error.message
