"""The steps of a tracing, pure functions from one state to the next; `gen/refinement/trace.py` has their order."""
