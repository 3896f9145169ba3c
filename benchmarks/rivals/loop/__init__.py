"""Other ways to identify, and to trace what a model misses.

`identification` gives the same runs to `gen identify` and to general tools, of which `network` is one; `terms` makes
the residuals and the terms that `tracing` gives to PySINDy and SysIdentPy beside `gen refine`; `table` prints both.
"""
