"""What is called good: by size, by share of the rise, and beside the sensor's noise."""

from __future__ import annotations

import pytest

from gen.identification.grades import Grade, Miss, told, worse_than


@pytest.mark.parametrize(
    ("error_K", "moved_K", "noise_K", "grade"),
    [
        (0.3, 60.0, 0.08, Grade.GOOD),
        (1.0, 60.0, 0.08, Grade.GOOD),
        (2.4, 60.0, 0.08, Grade.FAIR),  # a 25th of the rise, and thirty times what the sensor scatters by
        (2.4, 60.0, 0.8, Grade.FAIR),  # 2.4 K are that many, however much its readings scatter
        (9.2, 60.0, 12.0, Grade.BAD),  # an input that switches between rows looks like a sensor that scatters
        (4.2, 60.0, 3.0, Grade.FAIR),  # so do readings that jump now and then
        (2.4, 20.0, 0.8, Grade.FAIR),  # an eighth of the rise, which such a sensor does not show
        (2.4, 20.0, 0.08, Grade.BAD),  # an eighth of the rise
        (6.0, 300.0, 0.08, Grade.BAD),  # a share of 2 %, but more than limits keep
        (0.6, 3.0, 0.08, Grade.BAD),  # less than a kelvin, but a fifth of the rise
        (0.6, 3.0, 0.25, Grade.GOOD),
    ],
)
def test_an_error_is_graded_by_size_share_and_noise(
    error_K: float, moved_K: float, noise_K: float, grade: Grade
) -> None:
    assert Miss("casing", error_K, moved_K, noise_K).grade is grade


def test_an_error_is_told_beside_the_rise_and_the_noise() -> None:
    good, fair = Miss("shaft", 0.3, 40.0, 0.1), Miss("casing", 2.4, 60.0, 0.08)
    assert worse_than(Grade.GOOD, [good, fair]) == [fair]
    assert told([fair]) == "casing by 2.4 K (4% of what it moves by, 30 times its sensor's scatter)"
