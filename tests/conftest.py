"""Settings that must stand before numpy is loaded, and what the tests need of the process they run in."""

from __future__ import annotations

import os
import signal

from hypothesis import HealthCheck, settings

# As `gen` itself: the matrices are small, and threads of the linear algebra library wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# A shell lets background jobs ignore Ctrl-C, and children inherit that: tests of interrupts would wait forever.
signal.signal(signal.SIGINT, signal.default_int_handler)

# Workers of pytest-xdist have the processors between them: a second process of each would only wait for the others, and
# begin what then is not needed. Commands that tests start are processes of their own, and have what the machine has.
if "PYTEST_XDIST_WORKER" in os.environ and hasattr(os, "sched_getaffinity"):
    vars(os)["sched_getaffinity"] = lambda _: {0}

# How long an example takes, and how quickly one is drawn, is the machine's business.
settings.register_profile("any machine", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("any machine")
