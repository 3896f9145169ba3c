"""What a run does beside E: bounds of ``|c_j . D (y - s)|`` for matrices D, one for each |PWM|.

D is small, so it may be taken apart in any way: D = sum of v g + rest, columns v times rows g. Each g . (y - s) is read
off the states' polytope in its own direction, the rest along the axes. Which way is tightest differs; all hold, so the
least counts.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gen.arrays import FloatArray
from gen.certificate.exact import ROUGHLY, Ratios, floats, ratios
from gen.certificate.polytope import Directions, largest_roughly


def along_directions(directions: Directions, columns: FloatArray, sizes: FloatArray) -> FloatArray:
    """sum_m ``|c_j . column_m|``, shape (P, J), in float64 and rounded up by far more than its own errors.

    Parameters
    ----------
    directions
        c_j.
    columns, sizes
        Shape (P, m, n); ``sizes`` are the sums of magnitudes that the columns were made of.
    """
    along = directions.nearest
    found = np.zeros((len(columns), len(along)))
    for m in range(columns.shape[1]):
        found += np.abs(columns[:, m] @ along.T) + ROUGHLY * (sizes[:, m] @ np.abs(along).T)
    return found


def linear_part(
    directions: Directions,
    heights: Ratios,
    matrices: Ratios,
    away: Ratios,
    likely: Ratios,
) -> FloatArray:
    """Bounds of ``|c_j . D (y - s)|``, shape (P, J), with y - (centre, 0, ..) in a polytope.

    Parameters
    ----------
    directions, heights
        The polytope.
    matrices
        D, shape (P, n, n).
    away
        The farthest that what T settles to lies from the polytope's middle, shape (P,).
    likely
        A row g that D may be made of, shape (P, n).
    """
    ways: list[list[Ratios | None]] = [[], [None], [likely, None]]
    found = None
    for way in ways:
        generators = _taken_apart(directions, heights, matrices, away, way)
        bound = along_directions(directions, generators, np.abs(generators))
        found = bound if found is None else np.minimum(found, bound)
    assert found is not None
    return found


def _taken_apart(
    directions: Directions, heights: Ratios, matrices: Ratios, away: Ratios, rows: Sequence[Ratios | None]
) -> FloatArray:
    """Generators of all D (y - s), shape (P, m, n): a product for each row, and the rest; None is the largest row."""
    box = directions.box(heights)
    rest = matrices
    generators: list[FloatArray] = []
    for given in rows:
        column, row = _product(floats(rest), floats(box), None if given is None else floats(given))
        distance = floats(np.abs(row[:, 0]) * away) + largest_roughly(directions, heights, floats(row))
        generators.append((floats(column) * distance[:, None] * (1.0 + ROUGHLY))[:, None, :])
        rest = rest - column[:, :, None] * row[:, None, :]
    boxes = np.tile(box, (len(away), 1))
    boxes[:, 0] += away
    return np.concatenate([*generators, floats((rest * boxes[:, None, :]).transpose(0, 2, 1))], axis=1)


def _product(matrices: FloatArray, box: FloatArray, given: FloatArray | None) -> tuple[Ratios, Ratios]:
    """Columns v and rows g, shape (P, n) each, whose product comes near to matrices where |u_i| <= box_i."""
    scaled = matrices * box[None, None, :] / box[None, :, None]
    if given is None:
        left, size, right = np.linalg.svd(scaled)
        columns, rows = left[:, :, 0] * size[:, :1], right[:, 0, :]
    else:
        rows = given * box[None, :]
        rows = rows / np.maximum(np.linalg.norm(rows, axis=1), 1e-300)[:, None]
        columns = np.einsum("pij,pj->pi", scaled, rows)
    return ratios(columns * box[None, :]), ratios(rows / box[None, :])
