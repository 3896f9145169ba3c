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
from gen.errors import CheckFailed, InputError
from gen.lowering.lower import lower
from gen.model.effects import (
    Effect,
    Input,
    Lanes,
    Moment,
    Parameters,
    Values,
    catalogue_only,
    register,
    registry,
    unregister,
)
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
from tests.examples import ROOT

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


def test_an_inner_state_that_the_board_cannot_compute_is_refused_by_name(churning: None) -> None:
    class Drawn(Churning):
        name = "drawn"

        def inner(self, p: Values, m: Moment) -> tuple[Lanes, Lanes] | None:
            return m.pwm * m.channels[p["gauge"]], p["film_s"]

    register(Drawn)
    try:
        entry = effect("drawn", PART, churning_K_per_s_bar=1e-3, resting_bar=3.0, film_s=900.0)
        loaded = parse(json.dumps(document() | {"effects": [entry]}).encode())
        with pytest.raises(CheckFailed, match=r'inner state of the effect "drawn" depends on more than \|PWM\|'):
            lower(loaded, "fixed", "table")
    finally:
        unregister("drawn")


class BesideParameters(Parameters):
    neighbour: str
    exchange_per_s: float


class Beside(Effect):
    name = "beside"
    title = "a part beside it"
    equation = "E' = k T_other - rate E"
    parameters = BesideParameters
    inputs = (Input("neighbour", of="component", units=("_degC",)),)
    signature = "it follows the other part"

    def heat(self, p: Values, m: Moment) -> Lanes:
        return p["exchange_per_s"] * (m.others.get(p["neighbour"], 0.0) + m.channels.get(p["neighbour"], 0.0))


@pytest.fixture
def beside() -> Iterator[None]:
    register(Beside)
    yield
    unregister("beside")


@pytest.mark.parametrize(
    ("neighbour", "columns", "sources"), [("bearing", [], ["bearing"]), ("gearbox_degC", ["gearbox_degC"], [])]
)
def test_another_component_or_a_column_is_read_by_whatever_name_the_parameter_has(
    beside: None, neighbour: str, columns: list[str], sources: list[str]
) -> None:
    whole = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
    loaded = parse(json.dumps(whole | {"effects": [_beside(neighbour)]}).encode())
    names = loaded.model.component_names
    assert (loaded.effects[0].columns(names), loaded.effects[0].sources(names)) == (columns, sources)
    program = lower(loaded, "fixed", "table").effects
    assert program is not None
    assert [channel.column for channel in program.channels[1:]] == columns
    assert [names[index] for index in program.felt] == sources


@pytest.mark.parametrize("neighbour", ["casing", "bearin"])
def test_a_component_that_is_not_there_is_refused_at_its_parameter(beside: None, neighbour: str) -> None:
    whole = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
    with pytest.raises(InputError, match="expected the name of another component") as caught:
        parse(json.dumps(whole | {"effects": [_beside(neighbour)]}).encode())
    assert caught.value.place == "$.effects[0].parameters.neighbour"


def _beside(neighbour: str) -> dict[str, Any]:
    return effect("beside", PART, neighbour=neighbour, exchange_per_s=1e-4)


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
