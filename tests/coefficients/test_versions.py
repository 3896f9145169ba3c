"""A file of any version loads for ever; one of a version to come is refused, and says so."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import pytest
from pydantic import Field

from gen.coefficients import Document, dump, load, parse, reader, versions, with_effects
from gen.coefficients.base import Part
from gen.coefficients.effects import EffectEntry
from gen.coefficients.schema import STORED, published
from gen.coefficients.versions import VERSION, Tree, migrated
from gen.errors import InputError
from gen.model import ThermalModel
from gen.model.effects import registry
from gen.model.exact import ExactSolution
from gen.model.network_solution import NetworkSolution
from tests.coefficients.test_coefficients_errors import BASE

VERSION_1 = Path(__file__).parent / "version1"
VERSION_2 = Path(__file__).parent / "version2"

#: Written once and never again: SHA-256, and each component's rise in K after an hour at PWM 140 from cold.
FROZEN: dict[str, tuple[str, dict[str, float]]] = {
    "every_key.json": (
        "d3a019d460be072185eaa849fd3dab78d749d33186d3e05891bfec5fb416c82d",
        {"rotor": 23.8372532446, "casing": 10.1591599987},
    ),
    "identified.json": (
        "473d285125fe4d0ed366d7b3bf6ae9de751a365c9545489124fb53e1ea06e24d",
        {"brush": 41.7250597389, "bearing": 31.9426145299, "magnet": 31.5529366176, "casing": 31.0592633565},
    ),
    "my1016.json": (
        "9ef57c76389da99307b100ae5e00bf54ac82196c1fdc36e8b43851183adf39a8",
        {"brush": 42.2786901325, "bearing": 29.1253276933, "magnet": 29.1359919371, "casing": 28.5570761177},
    ),
    "observed.json": (
        "0d17be2e13f1bc4882d143bbe12bfa17fcd113a3666d0e2fe5ef54152fc98eb7",
        {"rotor": 20.3183199974, "casing": 10.1591599987},
    ),
    "two_mass.json": (
        "78aa7e12c3458ab34cdd9b2c43037d97f1a6b1e7bff7fe7dce9f7213bc2d2cc2",
        {"winding": 74.8103680966, "housing": 27.9775616426},
    ),
    "two_mass_refined.json": (
        "293be5eeb9cc5fd65d787cf2acd9afe59d31e8ffd8d64d689b8a1cdfc9fcbe6b",
        {"winding": 74.8103680966, "housing": 27.9775616426},
    ),
    "unproven.json": (
        "d962d485448c1d0e86fc89471baa18cb09428158aed0742af3974e539cdaecc0",
        {"winding": 74.8103680966, "housing": 27.9775616426},
    ),
}

#: The same of version 2; of a network its readings in degC, from 25 degC, its channels at 70 % of their ranges, by
#: `integrated` in tests/model/test_network.py; of the closed motor by `change` in tests/model/test_laws.py.
FROZEN_2: dict[str, tuple[str, dict[str, float]]] = {
    "closed_motor.json": (
        "ab3811c1b4e47e5ecb5b3a89fa66886de639d3cd6547249db59cde75ec06c70c",
        {"casing": 37.1821476090, "magnet": 39.1349802537},
    ),
    "warm_inside.json": (
        "d6c10249a6902d59ae2daa160db8a7e7bc64e1bac3a25287ad833f02137ddad4",
        {"casing": 37.1821476090, "magnet": 39.1349802537},
    ),
    "likely_start.json": (
        "151ae7b5833bd3d0922f7b38faea4b8eb5c2ddfa7c04ed0468b5b22fd2690a07",
        {"casing": 37.1821476090, "magnet": 39.1349802537},
    ),
    "ambient_at_once.json": (
        "60781092f523aee6672382d67ffbf8e7e12b71c855cf7695840cedd6a41e7a97",
        FROZEN["my1016.json"][1],
    ),
    "every_key.json": ("45572e247e729fda594960be5f6b20949500ae0d7de15bace488ecc1c276ec55", FROZEN["every_key.json"][1]),
    "fan_motor.json": (
        "4c776f1c2b944548cdf48e7edfb3a11f5743aea1455a32c0728c7f08d79593de",
        {"bearing": 35.0671243637, "brush": 40.8394482248, "magnet": 32.7277564434, "casing": 29.9183633164},
    ),
    "foreseen.json": ("b67a56172cd4154fcc5ff5369c4957e926ca0601364061f5cc31c7948b78fbc2", FROZEN["my1016.json"][1]),
    "held.json": ("09d1814c6c95a1f191580f78cbce33ef656e3bc9cc8ea4d092db8970d6bb1a12", FROZEN["my1016.json"][1]),
    "identified.json": (
        "f537c879ede233f20f8291be150526a2d52800dfa9ce1f0df3bca059b19f7f3f",
        FROZEN["identified.json"][1],
    ),
    "known_room.json": ("ae08d8515e726a49817704741e750880cde796b06a317effcde8d2c50dd18e82", FROZEN["my1016.json"][1]),
    "looking_ahead.json": (
        "313fbdb8a2869b7b40282f00002db297aef1a8ded72594103576620eea5cfcbf",
        FROZEN["my1016.json"][1],
    ),
    "missing_heat.json": ("8a79541d1321ba5c0ffca53dca50bce6461397fc02ab89c9f16db440a72773f1", FROZEN["my1016.json"][1]),
    "my1016.json": ("02aca1a40681f8b1200c5c59221d1935af03134e909873686f2855deb247131f", FROZEN["my1016.json"][1]),
    "network_every_key.json": (
        "b95020364bbe50e4faf186d6ee5bbc0286b6ea4d868542058c8090fa9095d5ac",
        {"bearing": 42.8842947737, "casing": 35.9995573126, "cover": 34.1647372114},
    ),
    "observed.json": ("a0a2944e2273b3fd259da2e6b7dbecdc79cf266a2fd12772628574cd6e0ca7c2", FROZEN["observed.json"][1]),
    "other_input.json": ("2b77de7de5b0fafd0eaf66a144457e8da798b797162eed3525d05dd0b688f3a9", FROZEN["my1016.json"][1]),
    "rest_of_input.json": (
        "19b25394b09f42aad3d47b45adb0c740cda52f1126ccb322d6b00cbfa9d202e9",
        FROZEN["my1016.json"][1],
    ),
    "protected.json": ("1174edd0d5cccc8c3b5c6b0517b99b288a097d7133c0c3b416c7608259e75b59", FROZEN["my1016.json"][1]),
    "remembered_heat.json": (
        "89e35cdad45bb9d45e0679734bcb7f091e4e8893def101ad8d22e0c7623bc620",
        FROZEN["my1016.json"][1],
    ),
    "sensor_chips.json": ("bc2af1065eb6971b1fe9d72b0a30dddbfd935a7bf7d5701791b58aecc4d6d216", FROZEN["my1016.json"][1]),
    "sensor_drifts.json": (
        "7f0fd88c937de1baf28ec74d06d7eedba6e1fb48ae8ccc0ba6eef0c0b37e6a56",
        {"brush": 53.1073182802, "casing": 34.0167396632},
    ),
    "sensor_gains.json": (
        "58920995e65c4f8a5e4c99bb304f7b9a3bba07bf0365039a67635a4ed812a07e",
        {"brush": 41.2298205151, "casing": 36.7285283989, "mount": 29.8215747518},
    ),
    "started.json": ("97708ee09880950acc8e84f5fbdfa7d16c4cf62f18a96b67a4ae9ebca487cf46", {"casing": 37.7854816146}),
    "supplied.json": ("a7ff1056e23680b0a0c7460b473c455f0c810d9049ffdbeac326aa9df86499ca", FROZEN["my1016.json"][1]),
    "thermistors.json": ("4c1c75e69ac07b5a07c6b91a82b95ba15c48e38d66e42d36898a6b6bfd590e86", FROZEN["my1016.json"][1]),
    "uno.json": (
        "0e00911266016a87658b5187ea10a48c3782837136fa909916d5fc7d0fb25014",
        {"casing": FROZEN["my1016.json"][1]["casing"]},
    ),
    "zeroed.json": ("c967ffcbb618351e5961c368dbb3305981c457f91b549462cfaf1e0c197a6efa", FROZEN["my1016.json"][1]),
}


def after_an_hour(model: ThermalModel) -> dict[str, float]:
    time, pwm = np.array([0.0, 3600.0]), np.array([140, 140])
    if model.network is None:
        solved = ExactSolution(model).simulate_times(time, pwm)
    else:
        told = {c.column: np.full(2, c.low + 0.7 * (c.high - c.low)) for c in model.network.channels}
        solved = NetworkSolution(model).simulate_times(time, pwm, 25.0, told)
    return {name: float(values[-1]) for name, values in solved.items()}


@pytest.mark.parametrize("name", sorted(FROZEN))
def test_a_file_of_version_1_loads_for_ever_and_means_what_it_meant(name: str) -> None:
    path = VERSION_1 / name
    sha256, rises = FROZEN[name]
    assert hashlib.sha256(path.read_bytes()).hexdigest() == sha256, "this file is a witness; do not write it anew"
    model = load(path).model
    found = ExactSolution(model).simulate_times(np.array([0.0, 3600.0]), np.array([140, 140]), {})
    assert {component: rise[-1] for component, rise in found.items()} == pytest.approx(rises, rel=1e-9)


@pytest.mark.parametrize("name", sorted(FROZEN_2))
def test_a_file_of_version_2_loads_for_ever_and_means_what_it_meant(name: str) -> None:
    path = VERSION_2 / name
    sha256, readings = FROZEN_2[name]
    assert hashlib.sha256(path.read_bytes()).hexdigest() == sha256, "this file is a witness; do not write it anew"
    assert after_an_hour(load(path).model) == pytest.approx(readings, rel=1e-9)


def test_the_ambient_passes_the_dynamics_in_a_file_of_every_version_that_does_not_say_otherwise() -> None:
    passes = {
        path: load(path).model.ambient_passes for folder in (VERSION_1, VERSION_2) for path in folder.glob("*.json")
    }
    assert passes[VERSION_1 / "my1016.json"]
    assert passes[VERSION_2 / "my1016.json"]
    assert not passes[VERSION_2 / "ambient_at_once.json"]
    assert not passes[VERSION_2 / "fan_motor.json"], "a network has paths"


def test_the_frozen_files_are_all_there() -> None:
    assert {path.name for path in VERSION_1.glob("*.json")} == set(FROZEN)
    assert {path.name for path in VERSION_2.glob("*.json")} == set(FROZEN_2)


@pytest.mark.parametrize("version", [1, 2])
def test_together_they_hold_every_key_and_every_effect_of_their_version(version: int) -> None:
    """By the published schema of that version, so that no key can be dropped unnoticed."""
    said: set[tuple[str, str]] = set()
    effects: set[tuple[str, str]] = set()

    def walk(part: Part) -> None:
        for key in part.model_fields_set:
            said.add((type(part).__name__, key))
            value = getattr(part, key)
            for item in value if isinstance(value, tuple) else (value,):
                if isinstance(item, Part):
                    walk(item)

    for path in (Path(__file__).parent / f"version{version}").glob("*.json"):
        assert json.loads(path.read_text(encoding="utf-8"))["version"] == version
        document = load(path).document
        walk(document)
        effects |= {(effect.name, key) for effect in document.effects for key in effect.parameters}
    schema = json.loads(published(version).read_text(encoding="utf-8"))
    objects = {"Document": schema, **schema["$defs"]}
    known = {(name, key) for name, part in objects.items() for key in part.get("properties", {})}
    assert known - said == set()
    parameters = {(name, key) for name, effect in registry().items() for key in effect.parameters.model_fields}
    assert parameters - effects == set()


def test_the_newest_version_is_the_one_that_is_written_and_published() -> None:
    assert len(versions.MIGRATIONS) + 1 == VERSION
    assert get_args(Document.model_fields["version"].annotation) == (VERSION,)
    assert STORED.name == f"gen-coefficients-{VERSION}.schema.json"
    assert [published(version).is_file() for version in range(1, VERSION + 2)] == [True] * VERSION + [False]


class Gearbox(Part):
    """A made-up part of a made-up version 3."""

    ratio: float


class Version3(Document):
    """It may hold a made-up gearbox; what was called fast_limit_K is gone."""

    version: Literal[3]  # type: ignore[assignment]
    gearbox: Gearbox | None = None
    note: str = Field(default="")


def to_version_3(tree: Tree) -> Tree:
    """What a later version may do: drop a key, and give a new one what the old files meant."""
    tree.get("accuracy", {}).pop("fast_limit_K", None)
    return tree | {"note": f"was {tree['name']}"}


@pytest.fixture
def version_3(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(versions, "MIGRATIONS", (*versions.MIGRATIONS, to_version_3))
    monkeypatch.setattr(reader, "Document", Version3)


def as_bytes(tree: Any) -> bytes:  # noqa: ANN401
    return json.dumps(tree).encode()


@pytest.mark.usefixtures("version_3")
@pytest.mark.parametrize("name", sorted(FROZEN))
def test_a_file_of_version_1_loads_as_the_made_up_version_3(name: str) -> None:
    loaded = load(VERSION_1 / name)
    assert isinstance(loaded.document, Version3)
    assert loaded.document.version == 3
    assert loaded.document.note == f"was {loaded.name}"
    found = ExactSolution(loaded.model).simulate_times(np.array([0.0, 3600.0]), np.array([140, 140]), {})
    assert {component: rise[-1] for component, rise in found.items()} == pytest.approx(FROZEN[name][1], rel=1e-9)
    assert loaded.sha256 == FROZEN[name][0]


@pytest.mark.usefixtures("version_3")
@pytest.mark.parametrize("name", sorted(FROZEN_2))
def test_a_file_of_version_2_loads_as_the_made_up_version_3(name: str) -> None:
    loaded = load(VERSION_2 / name)
    assert isinstance(loaded.document, Version3)
    assert (loaded.document.version, loaded.document.note) == (3, f"was {loaded.name}")
    assert after_an_hour(loaded.model) == pytest.approx(FROZEN_2[name][1], rel=1e-9)
    assert loaded.sha256 == FROZEN_2[name][0]


@pytest.mark.usefixtures("version_3")
def test_a_file_of_the_made_up_version_3_loads_without_migration() -> None:
    document = reader.parse_document(as_bytes(BASE | {"version": 3, "gearbox": {"ratio": 12.5}}))
    assert isinstance(document, Version3)
    assert document.note == ""
    assert document.gearbox is not None
    assert document.gearbox.ratio == 12.5


@pytest.mark.usefixtures("version_3")
def test_a_fault_in_a_migrated_file_says_which_version_its_place_is_of() -> None:
    with pytest.raises(InputError, match="expected a number") as caught:
        parse(as_bytes(BASE | {"sample_time_s": "x"}))
    assert caught.value.place == "$.sample_time_s"
    assert "the place is that of version 3" in caught.value.message


@pytest.mark.usefixtures("version_3")
@pytest.mark.parametrize("fault", [{"accuracy": 3}, {"accuracy": None}])
def test_a_file_that_no_migration_understands_is_refused_and_no_traceback(fault: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="cannot be brought from version 2 to 3") as caught:
        parse(as_bytes(BASE | fault))
    assert caught.value.place == "$"


@pytest.mark.usefixtures("version_3")
def test_what_is_added_to_an_older_file_makes_it_one_of_the_newest_version() -> None:
    entry = EffectEntry(name="drift", component="casing", parameters={"drift_K_per_h": 0.5})
    made = json.loads(with_effects(json.dumps(BASE), [entry]))
    assert (made["version"], made["note"]) == (3, "was my1016")
    assert list(made)[:2] == ["format", "version"]
    assert [effect.name for effect in parse(as_bytes(made)).document.effects] == ["drift"]


def test_migrations_are_applied_in_order_and_leave_what_they_were_given_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(
        versions,
        "MIGRATIONS",
        tuple((lambda tree, n=n: {**tree, "steps": [*tree.get("steps", []), n]}) for n in (2, 3, 4)),
    )
    for first, steps in ((1, [2, 3, 4]), (3, [4]), (4, None)):
        tree: Tree = {"version": first}
        after = migrated(tree)
        assert after.get("steps") == steps
        assert after["version"] == 4
        assert tree == {"version": first}


@pytest.mark.parametrize("version", [3, 17])
def test_a_file_of_a_later_version_is_refused_in_one_line(tmp_path: Path, version: int) -> None:
    path = tmp_path / "later.json"
    path.write_bytes(as_bytes(BASE | {"version": version, "network": {}}))
    with pytest.raises(InputError) as caught:
        load(path)
    assert str(caught.value) == (
        f"{path}: $.version: found {version}, expected 1 to 2: a newer gen wrote this file; install a newer gen "
        "(docs/format.md)"
    )


@pytest.mark.usefixtures("version_3")
def test_the_range_of_versions_is_named() -> None:
    with pytest.raises(InputError, match="found 4, expected 1 to 3"):
        parse(as_bytes(BASE | {"version": 4}))


def test_a_document_s_own_text_is_of_the_newest_version() -> None:
    assert json.loads(dump(load(VERSION_1 / "two_mass.json").document))["version"] == VERSION


def test_what_version_2_brought_is_no_key_of_version_1() -> None:
    with pytest.raises(InputError) as caught:
        parse(as_bytes(BASE | {"network": {}}))
    assert (caught.value.place, caught.value.message) == (
        "$.network",
        'found "network" in a file of version 1; a network needs "version": 2',
    )


def test_a_fault_in_a_file_of_version_1_has_the_place_that_it_has_there() -> None:
    """Nothing moved between version 1 and 2, so that nothing is said of it."""
    with pytest.raises(InputError) as caught:
        parse(as_bytes(BASE | {"sample_time_s": "x"}))
    assert str(caught.value) == '$.sample_time_s: found the text "x", expected a number'
