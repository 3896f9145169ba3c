"""Rows of several machines in one file, told apart by `--runs`; and what is written of an import that fails."""

from __future__ import annotations

from pathlib import Path

import pytest

from gen.errors import InputError
from gen.importing import importing
from gen.interface import import_runs
from gen.runs import read_run
from tests.importing.logs import csv, write


@pytest.mark.parametrize("without", [(20, 21), tuple(range(10))])
def test_a_missing_input_is_held_from_the_same_machine_s_row(without: tuple[int, ...], tmp_path: Path) -> None:
    lines = ["time_s,motor,pwm,winding_degC"]
    for i in range(40):
        lines += [f"{i},A,200,{20 + 0.1 * i:.2f}", f"{i},B,{'' if i in without else 50},{20 + 0.05 * i:.2f}"]
    found = import_runs([write(tmp_path, "\n".join(lines))], tmp_path / "out", runs="motor")
    first, second = (read_run(path) for path in sorted(found.runs))
    assert set(first.pwm.tolist()) == {200}
    assert set(second.pwm.tolist()) == {50}
    assert second.time_s.size == 40 - (len(without) if 0 in without else 0)  # what came before an input is left out


def test_neither_runs_nor_mapping_stay_of_an_import_that_could_not_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = write(tmp_path, csv())

    def full(path: Path, text: str) -> None:
        raise InputError("cannot be written: No space left on device", file=str(path))

    (tmp_path / "out").mkdir()
    with monkeypatch.context() as patch:
        patch.setattr(importing, "write_text", full)
        with pytest.raises(InputError, match=r"map\.toml: cannot be written: No space left"):
            import_runs([log], tmp_path / "out", mapping=tmp_path / "map.toml")
    assert list((tmp_path / "out").iterdir()) == []
    assert import_runs([log], tmp_path / "out", mapping=tmp_path / "map.toml").runs
