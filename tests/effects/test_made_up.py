"""An effect that these tests alone define goes the whole way: nothing in gen has to know of it."""

from __future__ import annotations

import importlib
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from gen.cli import cli
from gen.coefficients import load, parse
from gen.coefficients.schema import STORED, json_schema, schema_text
from gen.errors import InputError
from gen.lowering.lower import lower
from gen.model.effects import Effect, catalogue_only, register, registry, unregister
from gen.model.effects import registry as effects_registry
from tests.effects.cases import effect
from tests.effects.made_up import (
    CHURNING_K_PER_S_BAR,
    FILM_S,
    GAUGE,
    PART,
    RESTING_BAR,
    Churning,
    document,
    write_runs,
)

NAME = "oil_churning"


@pytest.fixture(scope="module")
def churning() -> Iterator[None]:
    register(Churning)
    yield
    unregister(NAME)


def _gen(*arguments: object) -> str:
    done = CliRunner().invoke(cli, [str(argument) for argument in arguments], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return done.output


@pytest.fixture(scope="module")
def refined(churning: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `gen refine` makes of runs with the effect."""
    folder = tmp_path_factory.mktemp("made-up")
    (folder / "coeffs.json").write_text(json.dumps(document()), encoding="utf-8")
    runs = write_runs(folder, 6)
    out, summary, report = (folder / name for name in ("refined.json", "summary.json", "report.html"))
    _gen("refine", folder / "coeffs.json", "--fit", *runs[:5], "--test", runs[5], "--out", out, "--json", summary,
         "--report", report)  # fmt: skip
    return out


def test_refine_names_it_and_measures_it(refined: Path) -> None:
    found = json.loads((refined.parent / "summary.json").read_text(encoding="utf-8"))
    assert found["verdict"] == "explained"
    first = found["effects"][0]
    assert (first["name"], first["component"], first["parameters"]["gauge"]) == (NAME, PART, GAUGE)
    assert first["parameters"]["churning_K_per_s_bar"] == pytest.approx(CHURNING_K_PER_S_BAR, rel=0.1)
    assert first["parameters"]["resting_bar"] == pytest.approx(RESTING_BAR, abs=0.2)
    assert first["parameters"]["film_s"] == pytest.approx(FILM_S, rel=0.15)
    assert found["after"]["test"]["rmse_K"] < 0.4 < found["before"]["test"]["rmse_K"]
    page = (refined.parent / "report.html").read_text(encoding="utf-8")
    assert f"{NAME} ({GAUGE})" in page
    assert "oil that is churned under pressure" in page


@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
def test_build_emits_it_with_its_channel(refined: Path, tmp_path: Path, arithmetic: str) -> None:
    _gen("build", refined, "--out", tmp_path / "out", "--arithmetic", arithmetic)
    header = (tmp_path / "out" / "lib" / "my1016" / "src" / "my1016.h").read_text(encoding="utf-8")
    assert "MY1016_CHANNEL_OIL_BAR" in header
    emitted = (tmp_path / "out" / "lib" / "my1016" / "src" / "my1016_effects.cpp").read_text(encoding="utf-8")
    assert Churning.equation in emitted


def test_the_board_is_told_nothing_by_the_references_value(refined: Path) -> None:
    """Until the first value comes, the channel has the one at which the effect does nothing, within its own limits."""
    loaded = load(refined)
    resting = loaded.document.effects[0].parameters["resting_bar"]
    program = lower(loaded, "fixed", "table")
    assert program.effects is not None
    channel = program.effects.channels[1]
    assert (channel.column, channel.low, channel.high) == (GAUGE, 0, 10_000)
    assert channel.neutral == round(resting * 1000.0)


def test_verify_finds_every_word_equal_on_this_computer_and_on_the_emulated_mega(refined: Path, tmp_path: Path) -> None:
    _gen("verify", refined, "--schedule", "table", "--scale", "0.005", "--json", tmp_path / "verified.json")
    found = json.loads((tmp_path / "verified.json").read_text(encoding="utf-8"))
    assert found["differing"] == 0
    assert found["words"] > 100_000
    made = {(one["arithmetic"], target["target"]) for one in found["combinations"] for target in one["targets"]}
    assert {arithmetic for arithmetic, _ in made} == {"fixed", "float"}
    assert any("avr" in target for _, target in made)


def test_a_file_is_checked_by_what_the_effect_declares(churning: None) -> None:
    def changed(**parameters: object) -> bytes:
        known: dict[str, Any] = {"churning_K_per_s_bar": 1e-3, "resting_bar": 3.0, "film_s": 900.0}
        return json.dumps(document() | {"effects": [effect(NAME, PART, **{**known, **parameters})]}).encode()

    assert parse(changed()).effects[0].values["gauge"] == GAUGE
    for wrong, place in ({"gauge": "pwm"}, "gauge"), ({"film_s": 1.0}, "film_s"), ({"gage": "x"}, "gage"):
        with pytest.raises(InputError) as caught:
            parse(changed(**wrong))
        assert caught.value.place == f"$.effects[0].parameters.{place}"


def test_the_schema_is_of_all_effects_and_the_stored_one_of_the_catalogue(churning: None) -> None:
    assert NAME in json.dumps(json_schema())
    assert schema_text() == STORED.read_text(encoding="utf-8")


def test_a_name_is_given_once(churning: None) -> None:
    class Again(Churning):
        name = "radiation"

    for twice in (Churning, Again):
        with pytest.raises(ValueError, match="is there already"):
            register(twice)


class _Point:
    """An entry point of an installed package."""

    name, value = "churning", "oil.effects:Churning"

    def __init__(self, loads: object) -> None:
        self._loads = loads

    def load(self) -> object:
        return self._loads


@pytest.mark.parametrize("known", [True, False])
def test_installed_packages_bring_effects(monkeypatch: pytest.MonkeyPatch, known: bool) -> None:
    class Installed(Churning):
        name = "installed"

    def points(group: str) -> list[_Point]:
        return [_Point(Installed if known else 3)] if group == "gen.effects" else []

    module = importlib.import_module(effects_registry.__module__)
    module._installed.cache_clear()
    monkeypatch.setattr(module, "entry_points", points)
    try:
        if known:
            assert isinstance(registry()["installed"], Effect)
            with catalogue_only():
                assert "installed" not in registry()
        else:
            with pytest.raises(InputError, match=r"oil.effects:Churning: cannot be loaded"):
                registry()
    finally:
        module._installed.cache_clear()
