"""The board counts milliseconds: a sample time that it cannot keep is refused, not rounded."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from gen.coefficients.sample_time import milliseconds
from gen.errors import InputError
from tests.command import gen
from tests.examples import ROOT


def test_every_whole_number_of_milliseconds_is_taken() -> None:
    assert [milliseconds(float(f"{count / 1000.0:.3f}")) for count in range(1, 5001)] == list(range(1, 5001))
    assert milliseconds(3600.0) == 3_600_000


@pytest.mark.parametrize(
    ("sample_time", "near"),
    [(1.0 / 30.0, "0.033 or 0.034"), (0.2504, "0.25 or 0.251"), (0.0004, "0.001"), (0.24999, "0.249 or 0.25")],
)
def test_any_other_is_refused_with_those_beside_it(sample_time: float, near: str) -> None:
    with pytest.raises(InputError) as raised:
        milliseconds(sample_time)
    assert str(raised.value).endswith(near)
    assert raised.value.place == "$.sample_time_s"


def test_a_build_writes_nothing_for_it(tmp_path: Path) -> None:
    tree = json.loads((ROOT / "examples" / "two_mass" / "coeffs.json").read_bytes())
    path = tmp_path / "coeffs.json"
    path.write_text(json.dumps(tree | {"sample_time_s": 0.0333}))
    found = gen("build", str(path), "--out", str(tmp_path / "out"))
    assert found.returncode == 2
    assert found.stderr.count("$.sample_time_s: found 0.0333 s, expected a whole number of milliseconds") == 1
    assert not (tmp_path / "out").exists()


def test_identification_refuses_it_before_it_reads_a_run(tmp_path: Path) -> None:
    run = tmp_path / "run.csv"
    run.write_text("time_s,pwm,part_degC\n0,0,20\n")
    found = gen("identify", str(run), "--out", str(tmp_path / "c.json"), "--sample-time", "0.0333")
    assert found.returncode == 2
    assert "--sample-time: found 0.0333 s, expected a whole number of milliseconds" in found.stderr
