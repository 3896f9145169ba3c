"""Settings that must stand before numpy is loaded, and what the tests need of the process they run in."""

from __future__ import annotations

import os
import signal

# As `gen` itself: the matrices are small, and threads of the linear algebra library wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# A shell lets background jobs ignore Ctrl-C, and children inherit that: tests of interrupts would wait forever.
signal.signal(signal.SIGINT, signal.default_int_handler)
