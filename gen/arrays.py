"""Names for arrays of one type of element; their shapes stand where they are used."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
SingleArray = NDArray[np.float32]
"""Of the board's floats."""
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
RecordArray = NDArray[np.void]
"""Of structures, such as what a board records of a sample."""
