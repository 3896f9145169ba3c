"""What all motors of a fleet share: the network's form, and where each of its numbers lies by how much."""

from __future__ import annotations

import io
import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from gen.arrays import BoolArray, FloatArray
from gen.errors import InputError
from gen.fleet.folder.store import MODELS, Store
from gen.fleet.statistics.pooling import Pool
from gen.identification.network.fitting.bends import BEND
from gen.identification.network.fitting.inputs import Inputs
from gen.identification.network.fitting.priors import OFFSET_K, START_FACTOR, Prior, prior_of
from gen.identification.network.fitting.problem import Problem
from gen.identification.network.fitting.scale import Scale
from gen.identification.network.fitting.structure import Structure

FIRST_SPREAD = 0.3
"""Standard deviation of the logarithms in the first round, before the fleet has told its own."""
FILE = f"{MODELS}/common.npz"


@dataclass(frozen=True, eq=False)
class Common:
    """A network's form, and the fleet's distribution of its numbers.

    Attributes
    ----------
    structure
        Nodes, paths, heats.
    pool
        Mean and variance of the shared parameters, in the structure's order, shape (p,).
    scale
        Of the motor that the form comes from: the prior of what one run alone has is written with it.
    density
        Of a fit's residual to begin with, shape (S,), K^2 s.
    """

    structure: Structure
    pool: Pool
    scale: Scale
    density: FloatArray

    @property
    def fixed(self) -> BoolArray:
        """Sensors' offsets and how warm runs begin: they say nothing of a motor, and keep identification's prior."""
        mask = np.zeros(self.structure.size, dtype=np.bool_)
        mask[self.structure.offsets] = mask[self.structure.factors] = True
        return mask

    def problem(self, inputs: Inputs) -> Problem[Structure]:
        """Runs of one motor with the fleet as the prior."""
        prior = prior_of(self.structure, inputs, self.scale)
        shared = slice(0, self.structure.size)
        mean, precision = prior.mean.copy(), prior.precision.copy()
        mean[shared] = self.pool.mean
        precision[shared, shared] = np.diag(1.0 / self.pool.variance)
        return Problem(self.structure, inputs, Prior(mean, precision))

    def as_json(self) -> dict[str, Any]:
        """As plain numbers and words, exactly: a task's arguments."""
        return {
            "structure": structure_json(self.structure),
            "mean": self.pool.mean.tolist(),
            "variance": self.pool.variance.tolist(),
            "settling": self.scale.settling.tolist(),
            "rise": self.scale.rise.tolist(),
            "density": self.density.tolist(),
        }


def common_of(said: dict[str, Any]) -> Common:
    """Read what :meth:`Common.as_json` gives."""
    return Common(
        structure_of(said["structure"]),
        Pool(np.array(said["mean"]), np.array(said["variance"])),
        Scale(np.array(said["settling"]), np.array(said["rise"])),
        np.array(said["density"]),
    )


def begun(structure: Structure, vector: FloatArray, scale: Scale, density: FloatArray) -> Common:
    """Give the first round's: about one motor's parameters, shape (p,)."""
    mean, variance = vector.copy(), np.full(structure.size, FIRST_SPREAD**2)
    mean[structure.offsets], variance[structure.offsets] = 0.0, OFFSET_K**2
    mean[structure.factors], variance[structure.factors] = 0.0, START_FACTOR**2
    return Common(structure, Pool(mean, variance), scale, density)


def structure_json(structure: Structure) -> dict[str, Any]:
    """Give a structure as plain numbers and words."""
    return {
        "sensed": list(structure.sensed),
        "hidden": structure.hidden,
        "paths": [list(path) for path in structure.paths],
        "heated": list(structure.heated),
        "constant": sorted(structure.constant),
        "fed": [list(one) for one in structure.fed],
        "bend": structure.bend,
        "apart": structure.apart,
        "driven": structure.driven,
    }


def structure_of(said: dict[str, Any]) -> Structure:
    """Read what :func:`structure_json` gives."""
    return Structure(
        tuple(said["sensed"]),
        said["hidden"],
        tuple((i, j) for i, j in said["paths"]),
        tuple(said["heated"]),
        frozenset(said["constant"]),
        tuple((column, node) for column, node in said.get("fed", ())),
        said.get("bend", BEND),
        apart=said.get("apart", 0.0),
        driven=said.get("driven", ""),
    )


def keep(store: Store, common: Common) -> None:
    """Write what the fleet shares into its store."""
    buffer = io.BytesIO()
    np.savez(buffer, said=np.array(json.dumps(common.as_json())))
    store.write(FILE, buffer.getvalue())


def kept(store: Store) -> Common:
    """Read what the fleet shares.

    Raises
    ------
    InputError
        When the fleet was not identified yet.
    """
    if not store.exists(FILE):
        raise InputError("is missing; expected a fleet that gen fleet identify has seen", file=f"{store.url}/{FILE}")
    with np.load(io.BytesIO(store.read(FILE)), allow_pickle=False) as arrays:
        return common_of(json.loads(str(arrays["said"])))
