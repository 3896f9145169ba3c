"""A motor that is held at what its look ahead says can be held: for days, with sensors that scatter."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from gen import toolchain
from gen.coefficients import parse
from gen.firmware.project import project_files
from gen.lowering.lower import lower
from tests.examples import ROOT

LIMIT_degC, HOURS = 60, 40


@pytest.fixture(scope="module")
def motor(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("held")
    tree = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
    limits = [{"component": "brush", "limit_degC": LIMIT_degC}]
    tree |= {"version": 2, "forecast": {"horizon_s": 3600, "near_s": 600, "limits": limits}}
    tree["protection"] = [{"cause": "limit_near", "action": "derate", "derate_pwm": "holdable"}]
    coefficients = parse(json.dumps(tree).encode())
    for path, text in project_files(coefficients, lower(coefficients, "fixed", "table"), "coeffs.json", None).items():
        if path.startswith("lib/my1016/src/"):
            (folder / Path(path).name).write_text(text, encoding="utf-8")
    made = [*map(str, folder.glob("*.cpp")), str(Path(__file__).with_name("held_motor.cpp"))]
    command = [str(toolchain.program("g++")), "-std=gnu++11", "-O2", "-Wall", "-Wextra", f"-I{folder}", *made]
    subprocess.run([*command, "-o", str(folder / "motor")], check=True)
    return folder / "motor"


@pytest.mark.parametrize(("scatter_K", "counts"), [(0.0, 1), (0.25, 1), (0.5, 2), (1.0, 2)])
def test_no_sample_is_beyond_the_limit_and_the_pwm_is_steady(motor: Path, scatter_K: float, counts: int) -> None:
    said = subprocess.run([str(motor), str(scatter_K), str(HOURS)], check=True, capture_output=True, text=True)
    warmest_mC, least, most = map(int, said.stdout.split())
    assert 1000 * LIMIT_degC - 500 < warmest_mC < 1000 * LIMIT_degC
    assert 0 < least <= most < 255
    assert most - least <= counts
