"""The study's schedules against those that identification chooses, on the same curves."""

import numpy as np
import pytest

from gen.study.compare import Comparison, compare, study_left_out
from gen.study.tables import STEADY_S, TRANSIENT_S, Study, read_study, variable_model
from gen.study.text import comparison
from tests.model import published
from tests.verify_helpers import ROOT


@pytest.fixture(scope="module")
def study() -> Study:
    return read_study(ROOT / "examples" / "my1016" / "study.json")


@pytest.fixture(scope="module")
def found(study: Study) -> Comparison:
    return compare(study, lambda _: None)


def test_the_study_s_side_is_the_printed_one(found: Comparison) -> None:
    for name, errors in published.STEADY_ERROR.items():
        assert found.study[name][STEADY_S] == pytest.approx(errors, abs=0.2)


def test_the_worst_steady_error_falls_from_ten_kelvin_to_under_one(found: Comparison) -> None:
    worst = {
        whose: max(float(np.max(np.abs(of[name][t]))) for name in of for t in (TRANSIENT_S, STEADY_S))
        for whose, of in (("study", found.study), ("ours", found.ours))
    }
    assert worst["study"] > 10.0
    assert worst["ours"] < 1.0


def test_leaving_one_speed_out_is_clearly_better(found: Comparison) -> None:
    for name, ours in found.ours_left_out.items():
        theirs = found.study_left_out[name]
        assert np.max(np.abs(ours)) < 0.5 * np.max(np.abs(theirs))
        assert np.sqrt(np.mean(ours**2)) < 0.5 * np.sqrt(np.mean(theirs**2))


def test_where_the_study_s_forms_are_true_leaving_one_out_costs_nothing(study: Study) -> None:
    """A bearing whose poles and gains lie on the study's own schedules is predicted at every speed."""
    schedules = variable_model(study).component("bearing")
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
    assert np.max(np.abs(study_left_out(ideal, "bearing"))) < 0.1


def test_it_is_printed(study: Study, found: Comparison) -> None:
    text = comparison(study, found)
    assert "gen identify" in text
    assert text.count("worst of all") == 3
