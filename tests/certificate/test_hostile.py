"""A certificate that anyone may have written, and C++ made to be read otherwise than it is compiled."""

from __future__ import annotations

import copy
import json
import random
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import gen
from gen.errors import CheckFailed, InputError
from tests.certificate.projects import built, small

VALUES: list[Any] = [None, True, -1, 0, 1, 10**30, 1e308, -1e-300, float("nan"), float("inf"), "", "x); evil(", []]
VALUES += [{}, [[1.0]]]
#: In the certificate of one small component, how many of its places are tried.
TRIED = 150


@pytest.fixture(scope="module")
def emitted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built(tmp_path_factory.mktemp("hostile"), small(2), "fixed", "table")


def places(tree: Any, path: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:  # noqa: ANN401
    """Every place of a JSON tree, containers too."""
    yield path
    entries = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, value in entries:
        yield from places(value, (*path, key))


def test_whatever_stands_in_a_certificate_is_proven_refuted_or_named(emitted: Path, tmp_path: Path) -> None:
    """Never a traceback, and no claim that was made smaller."""
    project = shutil.copytree(emitted, tmp_path / "project")
    path = project / "certificate.json"
    tree = json.loads(path.read_text())
    generator = random.Random(11)
    named = [place for place in places(tree) if place and (len(place) < 5 or generator.random() < 0.02)]
    for place in generator.sample(named, min(TRIED, len(named))):
        changed = copy.deepcopy(tree)
        at = changed
        for key in place[:-1]:
            at = at[key]
        at[place[-1]] = generator.choice(VALUES)
        path.write_text(json.dumps(changed))
        try:
            found = gen.check(project)
        except (CheckFailed, InputError) as error:
            assert "\n" not in str(error) and str(error)
        else:
            assert [part.name for part in found.parts] == ["part0"]


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("small_step.h", "#define steady rate[0]\n"),
        ("small_platform.h", "#define inner (inner + 1)\n"),
        ("small_step.h", "#undef SMALL_STEP_H\n"),
        ("small_word.h", "#define SMALL_SMALL inline int evil() { return 1; }\n"),
        ("small_word.h", "static inline int32_t small_high32(int32_t d, int64_t a) {\n    return d;\n}\n"),
    ],
)
def test_cpp_that_is_not_what_it_reads_like_is_refuted(emitted: Path, tmp_path: Path, file: str, text: str) -> None:
    project = shutil.copytree(emitted, tmp_path / "project")
    path = next(project.rglob(file))
    whole = path.read_text()
    guard = whole.index("#include")
    path.write_text(whole[:guard] + text + whole[guard:])
    with pytest.raises(CheckFailed, match=r"macro|a line|two functions|compile"):
        gen.check(project)


@pytest.mark.parametrize(
    "text",
    [
        "%:define steady rate[0]\n",
        "// a comment that another reader ends here\rint evil;\n",
        "#ifdef __AVR__ \f#else\n#endif\n",
        "// a comment \\\nint evil;\n",
        "/\\\n* int evil; /* */\n",
        'static const char *evil = R"(/*)"; // */\n',
        "#ifdef __AVR__\n#define SMALL_EVIL \\\n#else\n#endif\n",
        "#define pgm_read_word(address) (*(address) + 1)\n",
        "#define SMALL_SATURATED (1, 0)\n",
        '#include "small_evil.h"\n',
        '_Pragma("GCC optimize 3")\n',
    ],
)
def test_text_that_a_compiler_reads_otherwise_is_refuted(emitted: Path, tmp_path: Path, text: str) -> None:
    project = shutil.copytree(emitted, tmp_path / "project")
    path = next(project.rglob("small_step.h"))
    whole = path.read_bytes()
    guard = whole.index(b"#include")
    path.write_bytes(whole[:guard] + text.encode() + whole[guard:])
    with pytest.raises(CheckFailed, match=r"the proof does not know|reads small_step\.h otherwise|line|comment"):
        gen.check(project)


def test_names_may_end_as_raw_text_begins(tmp_path: Path) -> None:
    """`"STATOR"` holds R" and is no raw text."""
    tree = small(2)
    tree["components"][0]["name"] = "STATOR"
    assert [part.name for part in gen.check(built(tmp_path, tree, "fixed", "table")).parts] == ["STATOR"]
