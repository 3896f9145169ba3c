"""The study's tables come back from its transfer functions, and what does not is named."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from examples.my1016.study.disagreements import disagreements
from examples.my1016.study.reproduce import Entry, pole_statistics, reproduce, rises
from examples.my1016.study.tables import STUDY, VARIABLE, averaged_model, read_study, variable_model
from gen.coefficients import load
from gen.model import Component, ExactSolution, ExponentialSum, Polynomial, Schedule
from tests.examples import ROOT
from tests.model import published
from tests.model.examples import model


def entries_of(variable: Path = VARIABLE) -> list[Entry]:
    return reproduce(read_study(), averaged_model(), load(variable).model)


def test_the_file_holds_the_published_numbers() -> None:
    """Against the transcription that the model's tests use, made apart from this one."""
    study = read_study()
    for name, functions in published.TRANSFER_FUNCTIONS.items():
        assert [(g.numerator, g.denominator) for g in study.kept(name)] == list(functions)
        assert study.variable_minus_measured[10_800][name] == published.STEADY_ERROR[name]
        assert study.variable_minus_measured[2160][name] == published.TRANSIENT_ERROR[name]
        assert study.averaged_pole[name].numerator == published.AVERAGED[name][0]
    assert sum(len(functions) for functions in study.transfer_functions.values()) == 80


def test_functions_that_nobody_transcribed_twice_settle_where_the_study_measured() -> None:
    """A slipped digit would move the steady rise; many of the other orders hold poles near 0 and settle nowhere."""
    study = read_study()
    for name, functions in study.transfer_functions.items():
        first = [function for function in functions if function.order == 1]
        for function, measured in zip(first, study.measured_steady_degC[name], strict=True):
            rise = function.numerator * function.pwm / function.denominator[-1]
            assert rise == pytest.approx(measured - 30.0, abs=2.5), (name, function.pwm)


def test_measured_temperatures_and_printed_errors_fit_together() -> None:
    """Model less printed error is what was measured, but for the ambient, which all parts of a run share."""
    study = read_study()
    solution = ExactSolution(model("my1016"))
    for place, percent in enumerate((20, 40, 60, 80, 100)):
        pwm = np.full(2, round(percent * 2.55))
        rises = solution.simulate_times([0.0, 10_800.0], pwm)
        ambient = [
            study.measured_steady_degC[name][place] + study.variable_minus_measured[10_800][name][place] - rise[-1]
            for name, rise in rises.items()
        ]
        assert max(ambient) - min(ambient) < 0.55, percent


def test_all_but_the_magnet_s_outlier_come_back() -> None:
    entries = entries_of()
    errors = [e for e in entries if e.table in ("4.11", "4.13")]
    assert len(errors) == 40
    off = [(e.component, e.what) for e in errors if abs(e.difference) > 0.2]
    assert off == [("magnet", "20 %, 2160 s")]
    rounded = [e for e in entries if e.table in ("4.6", "4.8")]
    assert len(rounded) == 40
    assert [(e.table, e.component, e.what) for e in rounded if abs(e.difference) > 1.1] == [
        ("4.8", "magnet", "20 %, 2160 s")
    ]
    for entry in entries:
        if entry.table in ("4.4", "4.5"):
            assert abs(entry.difference) <= 0.02 * max(abs(entry.printed), 1e-12) or "CV" in entry.what


def test_the_coefficient_files_hold_the_study_s_models() -> None:
    """Table 4.10 and 4.5 stand in study.json as well, carried over on their own."""
    tables = json.loads(STUDY.read_text())
    for name, schedules in tables["schedules"].items():
        assert tables_of(variable_model().component(name)) == {k: v for k, v in schedules.items() if k != "sse"}
    for name, printed in tables["averaged_pole"].items():
        component = averaged_model().component(name)
        assert component.raw_gain([255])[0] == printed["numerator"]
        assert component.denominator([255])[0] == pytest.approx(printed["denominator"], rel=1e-12)


def tables_of(component: Component) -> dict[str, dict[str, list[float]]]:
    """The schedules of a component under the names that the study's tables give them."""
    found = {"gain": component.gain}
    for i, pole in enumerate(component.poles, start=1):
        alone = pole.imag is None and component.order == 1
        found["pole" if alone else f"pole{i}_real"] = pole.real
        if pole.imag is not None:
            found[f"pole{i}_imag"] = pole.imag
    return {key: written(schedule) for key, schedule in found.items()}


def written(schedule: Schedule) -> dict[str, list[float]]:
    if isinstance(schedule, Polynomial):
        return {"poly": list(schedule.coefficients)}
    assert isinstance(schedule, ExponentialSum)
    return {"exp2": [number for term in schedule.terms for number in term]}


def test_the_rises_are_those_of_the_exact_solution() -> None:
    model = variable_model()
    found = rises(read_study(), model.transfer_function)
    for percent in (20, 40, 60, 80, 100):
        exact = ExactSolution(model).simulate_times([0.0, 2160.0, 10_800.0], [round(percent * 2.55)] * 3)
        for name, rise in exact.items():
            assert found[name].loc[percent].to_list() == pytest.approx(rise[1:].tolist(), abs=1e-6)


def test_a_changed_number_is_noticed(tmp_path: Path) -> None:
    tree = json.loads(VARIABLE.read_text())
    bearing = next(component for component in tree["components"] if component["name"] == "bearing")
    bearing["gain"]["poly"][1] *= 1.02
    path = tmp_path / "coeffs.json"
    path.write_text(json.dumps(tree))
    off = [e for e in entries_of(path) if not e.agrees and e.table == "4.11"]
    assert {e.component for e in off} == {"bearing"}


def test_the_verdict_is_not_one_linear_system() -> None:
    study = read_study()
    for name in study.components:
        assert (pole_statistics(study, name).cv > 0.1).all()


def test_disagreements_are_found_in_the_numbers() -> None:
    study = read_study()
    text = "\n".join(disagreements(study, entries_of(), variable_model()))
    assert "magnet at 20 %, 2160 s: printed -9.6, from its own transfer functions +1.6" in text
    assert "the brush's gain is negative at PWM 1, 2" in text
    assert "13755 s" in text


def test_the_script_prints_it() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "examples.my1016.study", "--tables-only"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0
    assert "39 of 40 within 0.2 K" in done.stdout
    assert "-9.6" in done.stdout
