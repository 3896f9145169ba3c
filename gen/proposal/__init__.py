"""A start for wiring and alarm rules that fit a model, or what is in the logs; every note in it says why.

`motor` gathers what is known of the motor, `pins` gives everything that was measured a place at the board, `rules`
watches each part.
"""
