"""Nothing but the catalogues, of components and of networks, knows an effect, or a parameter of one, by its name."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

from gen.model.effects import catalogue_only, registry
from tests.examples import ROOT

with catalogue_only():
    EFFECTS = frozenset(registry())
    PARAMETERS = frozenset(name for effect in registry().values() for name in effect.parameters.model_fields)

#: Words that the model has on its own account, too. As strings they are keys and tags of its own; that none is a key of
#: an effect's parameters or held against an effect's name is tested below.
STRINGS = {
    "ambient": "what every rise is counted from",
    "channel": "an input of the board, and the thermocouple on a chip",
    "drift": "how far a network's sensor has moved since the start",
    "direction": "a pin of a motor driver, and what a residual may go with",
    "gain_factor": "the scale of an emitted table of gains",
    "pwm": "the command",
    "radiation": "a law by which a path of a network carries heat",
    "source": "where a coefficient file comes from",
}
IDENTIFIERS = STRINGS | {
    "about": "what a plot is about",
    "exponent": "of a power of two",
    "gain_error": "of a network's sensor",
    "lag_s": "of a lowered lag",
    "offset_K": "of a sensor, as identification estimates it from cold starts",
    "tau_s": "of a lowered first-order state",
}
#: The simulated motor: physics of its own, which has to share nothing with the effects.
APART = ROOT / "gen" / "rig"
#: What effects are in a network: one module each.
OF_NETWORKS = ROOT / "gen" / "refinement" / "network" / "effects"
PATHS = sorted(path for path in (ROOT / "gen").rglob("*.py") if "catalogue" not in path.parts)
CODE = [path for path in PATHS if not {APART, OF_NETWORKS} & set(path.parents)]


def _tokens(path: Path) -> Iterator[tuple[int, str, bool]]:
    """Line, word, and whether it is a string; comments, and words within a text, are none."""
    with tokenize.open(path) as stream:
        source = stream.read()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.NAME:
            yield token.start[0], token.string, False
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.lineno, node.value, True


def _place(path: Path, line: int) -> str:
    return f"{path.relative_to(ROOT)}:{line}"


def test_code_names_no_effect_and_no_parameter() -> None:
    known = EFFECTS | PARAMETERS
    found = [
        f"{_place(path, line)}: {word}"
        for path in CODE
        for line, word, text in _tokens(path)
        if word in known and word not in (STRINGS if text else IDENTIFIERS)
    ]
    assert found == []


def test_templates_name_no_effect_and_no_parameter() -> None:
    found = [
        f"{_place(path, number)}: {word}"
        for path in sorted((ROOT / "templates").rglob("*.j2"))
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1)
        for word in re.findall(r"\w+", line)
        if word in (EFFECTS | PARAMETERS) - set(IDENTIFIERS)
    ]
    assert found == []


def test_the_registry_alone_imports_the_catalogue() -> None:
    found = [path for path in PATHS if re.search(r"effects(\.| import )catalogue\b", path.read_text(encoding="utf-8"))]
    assert found == [ROOT / "gen" / "model" / "effects" / "registry.py"]


def test_the_simulated_motor_shares_nothing_with_the_effects() -> None:
    assert [
        path for path in PATHS if APART in path.parents and "model.effects" in path.read_text(encoding="utf-8")
    ] == []


def looked_up(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Strings that are keys of an effect's parameters, or that an effect's or a parameter's name is held against."""
    for node in ast.walk(tree):
        match node:
            case ast.Subscript(value=where, slice=ast.Constant(value=str(key))):
                texts, owners = [key], [where]
            case ast.Call(func=ast.Attribute(value=where), args=[ast.Constant(value=str(key)), *_]):
                texts, owners = [key], [where]
            case ast.Compare(left=left, comparators=others):
                parts = [left, *others]
                texts = [x.value for x in parts if isinstance(x, ast.Constant) and isinstance(x.value, str)]
                owners = [x for x in parts if not isinstance(x, ast.Constant)]
            case _:
                continue
        if any(OWNER.search(ast.unparse(owner)) for owner in owners):
            yield from ((node.lineno, text) for text in texts if re.search(r"\w", text))


#: How the code calls parameters by name (`p`, `values`, ..), an effect's name, and that of a fitted parameter.
OWNER = re.compile(
    r"(\bp|\.values|\.fixed|\.parameters|\[['\"]parameters['\"]\]|\beffect\.name|\beffect\[['\"]name['\"]\]"
    r"|\b(free|f)\.name)$"
)


@pytest.mark.parametrize(
    "line",
    [
        'applied.values.get("channel")',
        'p["source"]',
        'applied.effect.name == "ambient"',
        'free.name.endswith("tau_s")',
        '"tau" in f.name',
        'effect["parameters"].get("pwm")',
    ],
)
def test_such_a_line_would_be_found(line: str) -> None:
    assert list(looked_up(ast.parse(line)))


def test_no_parameter_is_looked_up_by_its_name() -> None:
    found = [
        f"{_place(path, line)}: {text}"
        for path in CODE
        for line, text in looked_up(ast.parse(path.read_text(encoding="utf-8")))
    ]
    assert found == []
