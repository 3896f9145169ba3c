"""How what the emitted model costs grows with the model, and the largest one that a board holds.

`models` makes coefficient files of every size, `measure` builds, runs and times them, `table` prints what came of it.
"""
