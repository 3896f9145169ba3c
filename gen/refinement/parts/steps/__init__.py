"""The steps of a tracing, pure functions from one state to the next; `trace.py` beside them has their order."""
