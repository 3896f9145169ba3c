"""The examples, loaded once."""

from functools import cache
from pathlib import Path

from gen.coefficients import Coefficients, load
from gen.model import ThermalModel

EXAMPLES = Path(__file__).parents[2] / "examples"
NAMES = ("my1016", "my1016_averaged", "two_mass")


@cache
def example(name: str) -> Coefficients:
    return load(EXAMPLES / name / "coeffs.json")


def model(name: str) -> ThermalModel:
    return example(name).model
