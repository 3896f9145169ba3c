"""A small fleet, identified once."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from gen.fleet.folder.store import Store
from gen.fleet.identify import Identified, Options, identify_fleet
from gen.fleet.tasks.work import Workers
from tests.fleet.made import run_of, store_of

MOTORS = 9
OPTIONS = Options(max_hidden=0, scouts=1, until="2026-01-31")


@pytest.fixture(scope="session")
def identified(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Identified]:
    """Nine motors with a run each, and what cannot be used: a fault, a run too short, half a file."""
    folder = tmp_path_factory.mktemp("fleet") / "store"
    store = store_of(folder, MOTORS)
    store.add("m0", "2026-01-05", "worn", replace(run_of(77, heat=2.0), comments={"fault": "bearing"}))
    store.add("short", "2026-01-01", "run", run_of(78, hours=0.03))
    broken, _ = store.add("m1", "2026-01-06", "broken", run_of(79))
    store.write(broken.path, b"half of")
    return folder, identify_fleet(store, OPTIONS, Workers(), lambda _: None)


@pytest.fixture
def fleet(identified: tuple[Path, Identified], tmp_path: Path) -> Store:
    """A copy of it, to change."""
    shutil.copytree(identified[0], tmp_path / "store")
    return Store(str(tmp_path / "store"))
