"""Runs that begin while the inside of a motor is warmer than its sensors say: no term, but the file's `start_factor`.

It is not sought as the others are: `gen.refinement.network.tracing.warm_start` compares starts last of all.
"""

from __future__ import annotations

NAME = "initial_state"
"""In the library of effects."""
