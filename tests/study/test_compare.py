"""The study's schedules against those that identification chooses, on the same curves."""

import numpy as np
import pytest

from examples.my1016.study.__main__ import comparison
from examples.my1016.study.compare import Comparison, compare, study_left_out
from examples.my1016.study.tables import STEADY_S, TRANSIENT_S, Study, read_study, variable_model
from tests.model import published


@pytest.fixture(scope="module")
def study() -> Study:
    return read_study()


@pytest.fixture(scope="module")
def found(study: Study) -> Comparison:
    return compare(study, variable_model())


def test_the_study_s_side_is_the_printed_one(found: Comparison) -> None:
    for name, errors in published.STEADY_ERROR.items():
        assert found.study[name][STEADY_S].to_list() == pytest.approx(errors, abs=0.2)


def test_the_worst_steady_error_falls_from_ten_kelvin_to_under_one(found: Comparison) -> None:
    columns = [(name, t) for name in published.STEADY_ERROR for t in (TRANSIENT_S, STEADY_S)]
    assert all(len(of.columns) == len(columns) and all(c in of for c in columns) for of in (found.study, found.ours))
    worst = {
        whose: float(np.max(np.abs(of.to_numpy()))) for whose, of in (("study", found.study), ("ours", found.ours))
    }
    assert worst["study"] > 10.0
    assert worst["ours"] < 1.0


def test_leaving_one_speed_out_is_clearly_better(found: Comparison) -> None:
    assert list(found.ours_left_out) == list(published.STEADY_ERROR)
    for name, ours in found.ours_left_out.items():
        theirs = found.study_left_out[name]
        assert np.max(np.abs(ours)) < 0.5 * np.max(np.abs(theirs))
        assert np.sqrt(np.mean(ours**2)) < 0.5 * np.sqrt(np.mean(theirs**2))


def test_where_the_study_s_forms_are_true_leaving_one_out_costs_nothing(study: Study) -> None:
    """A bearing whose poles and gains lie on the study's own schedules is predicted at every speed."""
    schedules = variable_model().component("bearing")
    on_schedule = tuple(
        g.model_copy(
            update={
                "numerator": float(schedules.raw_gain([g.pwm])[0]),
                "denominator": tuple(schedules.denominator([g.pwm])[0].tolist()),
            }
        )
        for g in study.kept("bearing")
    )
    ideal = study.model_copy(update={"transfer_functions": {**study.transfer_functions, "bearing": on_schedule}})
    assert np.max(np.abs(study_left_out(ideal, schedules))) < 0.1


def test_it_is_printed(found: Comparison) -> None:
    text = comparison(found)
    assert "gen identify" in text
    assert text.count("worst of all") == 3
