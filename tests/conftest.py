"""Settings that must stand before numpy is loaded."""

from __future__ import annotations

import os

# As `gen` itself: the matrices are small, and threads of the linear algebra library wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
